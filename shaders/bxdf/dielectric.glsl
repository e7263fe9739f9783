// The interface of two dielectrics, smooth or rough, that absorbs nothing: Walter et al. 2007, "Microfacet
// Models for Refraction through Rough Surfaces". Single scattering: light that a facet sends to another facet
// is lost.
//
// eta is the index below the surface (z < 0) over that above it; wo may be on either side. Transmission
// scales radiance by the square of the relative index, 1 / eta^2 seen from above, and returns as
// BSDFSample::eta the index on the side of wi over that on the side of wo. So f(wo, wi) n(wi)^2 = f(wi, wo)
// n(wo)^2, and an estimate that must not contain the scale (Russian roulette) multiplies by eta^2.
//
// Thin: a sheet with air on both sides. Light that a facet transmits passes straight on: its direction is
// that of the reflection mirrored through the sheet, roughened as much as the reflection, with the same
// masking and a returned eta of 1 (KHR_materials_transmission). Light between the two faces of the sheet is
// not followed.
#ifndef RAYGRAPH_BXDF_DIELECTRIC_GLSL
#define RAYGRAPH_BXDF_DIELECTRIC_GLSL

#include "bxdf/microfacet.glsl"

SHADING_BEGIN

struct DielectricBxDF {
    MicrofacetDistribution distribution;
    float eta;
    bool isThin;
};

// Indices this close refract by less than a smooth surface does, and are a delta for every roughness.
CONST float kSameIndex = 1e-4f;

INLINE bool IsDelta(DielectricBxDF lobe) {
    return IsEffectivelySmooth(lobe.distribution) || (!lobe.isThin && abs(lobe.eta - 1.0f) < kSameIndex);
}

INLINE uint Flags(DielectricBxDF lobe) {
    uint parts = abs(lobe.eta - 1.0f) < kSameIndex ? kBxDFTransmission : kBxDFReflection | kBxDFTransmission;
    return parts | (IsDelta(lobe) ? kBxDFSpecular : kBxDFGlossy);
}

// Seen from the side of wo.
INLINE float EtaAhead(DielectricBxDF lobe, vec3 wo) { return wo.z < 0.0f ? 1.0f / lobe.eta : lobe.eta; }

// The same from either face of a sheet, whose inside is denser or thinner than the air about it.
INLINE float FacetReflectance(DielectricBxDF lobe, vec3 wo, vec3 wm) {
    return DielectricReflectance(abs(dot(wo, wm)), lobe.isThin ? lobe.eta : EtaAhead(lobe, wo));
}

INLINE vec3 MirrorThroughSheet(vec3 w) { return vec3(w.x, w.y, -w.z); }

INLINE vec3 f(DielectricBxDF lobe, vec3 wo, vec3 wi) {
    if (wo.z == 0.0f || wi.z == 0.0f || IsDelta(lobe)) return vec3(0.0f);
    bool isReflection = SameHemisphere(wo, wi);
    if (isReflection || lobe.isThin) {
        vec3 wr = isReflection ? wi : MirrorThroughSheet(wi);
        vec3 wm = ReflectionNormal(wo, wr);
        float reflected = FacetReflectance(lobe, wo, wm);
        float share = isReflection ? reflected : 1.0f - reflected;
        return vec3(share * ReflectionLobe(lobe.distribution, wo, wr, wm));
    }
    float eta = EtaAhead(lobe, wo);
    vec3 wm = RefractionNormal(wo, wi, eta);
    if (!IsRefractedBy(wo, wi, wm)) return vec3(0.0f);
    float transmitted = 1.0f - FacetReflectance(lobe, wo, wm);
    return vec3(transmitted * RefractionLobe(lobe.distribution, wo, wi, wm, eta));
}

INLINE float PDF(DielectricBxDF lobe, vec3 wo, vec3 wi) {
    if (wo.z == 0.0f || wi.z == 0.0f || IsDelta(lobe)) return 0.0f;
    bool isReflection = SameHemisphere(wo, wi);
    if (isReflection || lobe.isThin) {
        vec3 wm = ReflectionNormal(wo, isReflection ? wi : MirrorThroughSheet(wi));
        float reflected = FacetReflectance(lobe, wo, wm);
        float share = isReflection ? reflected : 1.0f - reflected;
        return share * ReflectionPDF(lobe.distribution, wo, wm);
    }
    float eta = EtaAhead(lobe, wo);
    vec3 wm = RefractionNormal(wo, wi, eta);
    if (!IsRefractedBy(wo, wi, wm)) return 0.0f;
    float transmitted = 1.0f - FacetReflectance(lobe, wo, wm);
    return transmitted * RefractionPDF(lobe.distribution, wo, wi, wm, eta);
}

INLINE BSDFSample SampleSmooth(DielectricBxDF lobe, vec3 wo, float uc) {
    BSDFSample result = NoSample();
    vec3 wm = vec3(0.0f, 0.0f, wo.z < 0.0f ? -1.0f : 1.0f);
    float reflected = IsReflective(Flags(lobe)) ? FacetReflectance(lobe, wo, wm) : 0.0f;
    if (uc < reflected) {
        result.wi = Reflect(wo, wm);
        result.f = vec3(reflected / abs(wo.z));
        result.pdf = reflected;
        result.flags = kBxDFReflection | kBxDFSpecular;
        return result;
    }
    float eta = EtaAhead(lobe, wo);
    vec3 wi = -wo;
    if (!lobe.isThin) {
        if (!Refract(wo, wm, eta, wi)) return result;
        result.eta = eta;
    }
    result.wi = wi;
    result.f = vec3((1.0f - reflected) / (abs(wi.z) * Sqr(result.eta)));
    result.pdf = 1.0f - reflected;
    result.flags = kBxDFTransmission | kBxDFSpecular;
    return result;
}

INLINE BSDFSample Sample_f(DielectricBxDF lobe, vec3 wo, float uc, vec2 u) {
    BSDFSample result = NoSample();
    if (wo.z == 0.0f) return result;
    if (IsDelta(lobe)) return SampleSmooth(lobe, wo, uc);
    float side = wo.z < 0.0f ? -1.0f : 1.0f;
    vec3 wm = side * Sample_wm(lobe.distribution, side * wo, u);
    if (dot(wo, wm) <= 0.0f) return result;
    float reflected = FacetReflectance(lobe, wo, wm);
    bool isReflection = uc < reflected;
    float share = isReflection ? reflected : 1.0f - reflected;
    result.flags = (isReflection ? kBxDFReflection : kBxDFTransmission) | kBxDFGlossy;
    if (isReflection || lobe.isThin) {
        // A direction into the surface meets another facet; that light is lost.
        vec3 wr = Reflect(wo, wm);
        if (!SameHemisphere(wo, wr)) return result;
        result.wi = isReflection ? wr : MirrorThroughSheet(wr);
        result.f = vec3(share * ReflectionLobe(lobe.distribution, wo, wr, wm));
        result.pdf = share * ReflectionPDF(lobe.distribution, wo, wm);
        return result;
    }
    float eta = EtaAhead(lobe, wo);
    vec3 wi = vec3(0.0f);
    if (!Refract(wo, wm, eta, wi) || wi.z * wo.z >= 0.0f) return result;
    result.wi = wi;
    result.eta = eta;
    result.f = vec3(share * RefractionLobe(lobe.distribution, wo, wi, wm, eta));
    result.pdf = share * RefractionPDF(lobe.distribution, wo, wi, wm, eta);
    return result;
}

SHADING_END

#endif
