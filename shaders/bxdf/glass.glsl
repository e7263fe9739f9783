// The lobe of a dielectric that lets light through: facets that reflect or transmit by Fresnel's share.
//
// At the boundary of a medium they refract: Walter et al. 2007, "Microfacet Models for Refraction through
// Rough Surfaces". Transmission scales radiance by 1 / eta^2, and the sample returns eta. So f(wo, wi)
// n(wi)^2 = f(wi, wo) n(wo)^2, and an estimate that must not contain the scale (Russian roulette) multiplies
// by eta^2.
//
// A thin wall has air on both sides: light that a facet transmits passes straight on. Its direction is that
// of the reflection mirrored through the wall, roughened as much, with the same masking and a returned eta of
// 1 (KHR_materials_transmission). Light between the two faces of the wall is not followed.
//
// Between media of one index no facet deflects light, however rough: all goes straight on, as through a
// smooth thin wall that reflects nothing.
#ifndef RAYGRAPH_BXDF_GLASS_GLSL
#define RAYGRAPH_BXDF_GLASS_GLSL

#include "bxdf/lobe.glsl"

SHADING_BEGIN

// Rough surfaces that refract are kept this far from matched media, where the facet cannot be computed from
// the direction.
CONST float kGlassMinRefraction = 1e-3f;

struct GlassBxDF {
    FacetFresnel fresnel;
    float eta;        // index of the facets; for a thin wall, from outside
    float mediumEta;  // index of the media, by which radiance is scaled
    vec3 reflect;     // factors on what facets reflect, and on what they transmit
    vec3 pass;
    vec3 rest;         // albedo of a diffuse reflection: light that facets sent on more than once
    float compensationProbability;  // probability of sampling `rest`
    float weight;
    vec3 albedo;  // albedo of reflection and transmission, for LobeMean
    vec3 transmittedAlbedo;
};

// Returns a lobe of single scattering, for `share` of the light.
INLINE GlassBxDF GlassOf(SurfaceMaterial material, float eta, bool isThin, float share) {
    GlassBxDF lobe;
    lobe.fresnel = DielectricFresnel(material, eta);
    lobe.eta = isThin ? OutsideEta(eta) : eta;
    lobe.mediumEta = eta;
    lobe.reflect = vec3(share);
    lobe.pass = share * material.baseColor;
    lobe.rest = vec3(0.0f);
    lobe.compensationProbability = 0.0f;
    lobe.weight = share;
    lobe.albedo = vec3(0.0f);
    lobe.transmittedAlbedo = vec3(0.0f);
    return lobe;
}

INLINE void InitLobe(OUT(GlassBxDF) lobe, SurfaceMaterial material, SurfaceSetting setting, FacetView view,
                      INOUT(float) share) {
    float own = share * GlassShare(material);
    lobe = GlassOf(material, setting.eta, view.isThin, own);
    lobe.fresnel = DielectricFresnel(material, setting);
    if (!(own > 0.0f)) return;
    if (HasTraceFeature(kTraceMatchedMedia) && setting.isMatched) {
        lobe.reflect = vec3(0.0f);
        lobe.weight = max(Average(lobe.pass), 0.01f * own);
        lobe.transmittedAlbedo = lobe.pass;
        return;
    }
    if (!view.isThin && !view.isSmooth) {
        lobe.eta = lobe.eta >= 1.0f ? max(lobe.eta, 1.0f + kGlassMinRefraction)
                                    : min(lobe.eta, 1.0f - kGlassMinRefraction);
        lobe.pass *= Sqr(lobe.eta / lobe.mediumEta);
    }
    TableCurve table = TableCurveOf(lobe.fresnel, view, lobe.eta, false);
    vec3 f0 = table.f0;
    vec3 f90 = table.f90;
    vec3 single = SingleAlbedo(view.energy, f0, f90);
    if (HasCompensation() && !view.isSmooth) {
        if (view.isThin) {
            float scale = 1.0f / max(view.energy.single.x + view.energy.single.y, 0.05f);
            lobe.reflect *= scale;
            lobe.pass *= scale;
        } else {
            GlassEnergy energy = ViewGlassEnergy(view.facets.alpha, view.energy.single, lobe.eta, view.wo,
                                                 setting.seed);
            GlassScale scale = GlassScaleOf(energy, f0, f90);
            lobe.reflect *= scale.reflected;
            lobe.pass *= scale.transmitted;
            lobe.rest = own * scale.diffuse;
        }
    }
    // From the denser side there is much total reflection
    vec3 layer = lobe.eta < 1.0f && !view.isThin ? max(single, vec3(0.5f)) : single;
    float rest = Average(lobe.rest);
    float facets = max(own * Average(mix(material.baseColor, vec3(1.0f), layer)) - rest, 0.01f * own);
    lobe.weight = facets + rest;
    lobe.compensationProbability = rest / lobe.weight;
    vec3 reflected = FacetAlbedo(view, view.energy, f0, f90);
    FresnelCoefficients shares = FresnelWithoutFilm(reflected);
    if (HasFilm(lobe.fresnel.film)) {
        vec3 bare = FacetAlbedo(view, view.energy, lobe.fresnel.f0, lobe.fresnel.f90);
        shares = FresnelWithFilm(bare, reflected - bare);
    }
    lobe.albedo = own * shares.reflected;
    lobe.transmittedAlbedo = own * material.baseColor * max(shares.passed, vec3(0.0f));
}

INLINE bool IsDiffuse(GlassBxDF) { return false; }

INLINE uint Flags(GlassBxDF, FacetView view) {
    return kBxDFReflection | kBxDFTransmission | FacetFlags(view);
}

INLINE FresnelCoefficients EvaluateFresnel(GlassBxDF lobe, float cosI) {
    return EvaluateFresnel(lobe.fresnel, cosI, lobe.eta);
}

// Returns the probability that a facet of these shares is sampled by reflection.
INLINE float ReflectProbability(GlassBxDF lobe, FresnelCoefficients shares) {
    float reflected = Average(lobe.reflect * shares.reflected);
    float passed = Average(lobe.pass * shares.passed);
    float sum = reflected + passed;
    return sum > 0.0f ? reflected / sum : 1.0f;
}

// Returns the refraction that the tables scale: masked like reflection, which is closer in shape to all
// bounces together than one bounce is.
INLINE float CompensatedRefractionLobe(FacetView view, vec3 wi, vec3 wm, float eta) {
    float ci = abs(wi.z);
    float lo = LambdaCos(view.facets, view.wo);
    float visible = 1.0f / (view.wo.z * ci + lo * ci + LambdaCos(view.facets, wi) * view.wo.z);
    return D(view.facets, wm) * visible * dot(view.wo, wm) * RefractionJacobian(view.wo, wi, wm, eta) /
           Sqr(eta);
}

INLINE vec3 Evaluate(GlassBxDF lobe, FacetView view, FacetPair pair, OUT(float) pdf) {
    pdf = 0.0f;
    if (pair.isDelta != view.isSmooth) return vec3(0.0f);
    bool isThrough = pair.wi.z < 0.0f;
    float cosI = pair.cosI;
    float white = pair.reflection;  // f of facets that reflect or transmit everything
    float density = pair.reflectionPDF;
    if (isThrough && !view.isThin) {
        cosI = view.wo.z;
        white = 1.0f / (abs(pair.wi.z) * Sqr(lobe.eta));
        density = 1.0f;
        if (!pair.isDelta) {
            vec3 wm = RefractionNormal(view.wo, pair.wi, lobe.eta);
            if (!IsRefractedBy(view.wo, pair.wi, wm)) return vec3(0.0f);
            cosI = dot(view.wo, wm);
            white = HasCompensation() ? CompensatedRefractionLobe(view, pair.wi, wm, lobe.eta)
                                      : RefractionLobe(view.facets, view.wo, pair.wi, wm, lobe.eta);
            density = RefractionPDF(view.facets, view.wo, pair.wi, wm, lobe.eta);
        }
    }
    FresnelCoefficients shares = EvaluateFresnel(lobe, cosI);
    float chance = ReflectProbability(lobe, shares);
    pdf = (1.0f - lobe.compensationProbability) * (isThrough ? 1.0f - chance : chance) * density;
    if (isThrough) return lobe.pass * shares.passed * white;
    pdf += lobe.compensationProbability * CosineHemispherePDF(pair.wi.z);
    return lobe.reflect * shares.reflected * white + lobe.rest * kInvPi;
}

INLINE bool SamplesCosine(GlassBxDF lobe, float uc) { return uc < lobe.compensationProbability; }

INLINE BSDFSample SampleDirection(GlassBxDF lobe, FacetView view, vec3 drawn, float uc, vec2) {
    if (SamplesCosine(lobe, uc)) return CosineDirection(drawn, kBxDFGlossy);
    vec3 wm = drawn;
    float chance = ReflectProbability(lobe, EvaluateFresnel(lobe, dot(view.wo, wm)));
    if (uc - lobe.compensationProbability < (1.0f - lobe.compensationProbability) * chance)
        return ReflectedDirection(view, wm);
    vec3 wi = Reflect(view.wo, wm);
    wi.z = -wi.z;
    if (!view.isThin && !Refract(view.wo, wm, lobe.eta, wi)) return NoSample();
    if (!(wi.z < 0.0f)) return NoSample();
    return SampledDirection(wi, view.isThin ? 1.0f : lobe.mediumEta,
                            kBxDFTransmission | FacetFlags(view));
}

INLINE LobeMean Reflected(GlassBxDF lobe, FacetView view) { return FacetMean(view, lobe.albedo); }

INLINE LobeMean Transmitted(GlassBxDF lobe, FacetView view) {
    LobeMean mean = NoMean();
    mean.albedo = lobe.transmittedAlbedo;
    vec3 refracted = vec3(0.0f);
    mean.wi = -view.wo;
    if (!view.isThin && Refract(view.wo, vec3(0.0f, 0.0f, 1.0f), lobe.eta, refracted)) mean.wi = refracted;
    mean.roughness = view.roughness;
    // Slopes of facets have a deviation of alpha / sqrt(2); a thin wall deflects light twice as far, as a
    // mirror would, and a boundary by the part that remains after refraction
    mean.slope = 0.70710678f * Sqr(view.roughness) * (view.isThin ? 2.0f : abs(1.0f - 1.0f / lobe.eta));
    return mean;
}

INLINE float Weight(GlassBxDF lobe, FacetView) { return lobe.weight; }

INLINE bool IsWalked(GlassBxDF) { return true; }

INLINE MicrosurfaceWalk WalkOf(GlassBxDF lobe, FacetView view) {
    MicrosurfaceWalk walk = ReflectedWalk(view, lobe.fresnel, lobe.eta, lobe.reflect);
    walk.surface.kind = view.isThin ? kWalkPassesThin : kWalkRefracts;
    walk.pass = view.isThin ? lobe.pass : lobe.pass / Sqr(lobe.eta);
    walk.eta = view.isThin ? 1.0f : lobe.mediumEta;
    return walk;
}

INLINE vec3 PassThroughWeight(GlassBxDF lobe, FacetView view) {
    return lobe.pass * EvaluateFresnel(lobe, view.wo.z).passed;
}

INLINE float PassThroughProbability(GlassBxDF lobe, FacetView view) {
    return 1.0f - ReflectProbability(lobe, EvaluateFresnel(lobe, view.wo.z));
}

INLINE GlassBxDF WithoutPassThrough(GlassBxDF lobe) {
    lobe.pass = vec3(0.0f);
    return lobe;
}

LOBE_IS_NOT_A_LAYER(GlassBxDF)
LOBE_BXDF_INTERFACE(GlassBxDF)

SHADING_END

#endif
