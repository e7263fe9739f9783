// The lobe of diffuse transmission (KHR_materials_diffuse_transmission): Lambert's, on the side of the
// surface that wo is not on. It takes its share of the light that would reach the diffuse base.
//
// The layers above (dielectric, sheen, clear coat) are on both sides of a sheet, and light from either side
// passes them by the same factor: the sum is reciprocal, and a white sheet returns and passes all light.
//
// Light that is scattered within a thin sheet (KHR_materials_scatter) leaves it on either side, in one color.
//
// At the boundary of a medium of relative index n it obeys the law of every boundary that does not make heat
// flow from cold to warm: f(wo, wi) n(wi)^2 = f(wi, wo) n(wo)^2, as glass does. So of light from the denser
// side, the share that passes is 1 / n^2 of that from the other, and the rest is returned diffusely, in the
// color of the transmission; radiance scales by 1 / eta^2, and the sample returns eta. A body that is part
// glass, part diffuse has the same light within by both: even surroundings stay even.
#ifndef RAYGRAPH_BXDF_DIFFUSE_TRANSMISSION_GLSL
#define RAYGRAPH_BXDF_DIFFUSE_TRANSMISSION_GLSL

#include "bxdf/lobe.glsl"

SHADING_BEGIN

struct DiffuseTransmissionBxDF {
    vec3 albedo;    // the share of light that is transmitted, in [0, 1]
    vec3 returned;  // and that is reflected in its place: on the denser side of a boundary, or by scattering
    float reflectProbability;  // probability of sampling `returned`
    float eta;
};

INLINE void InitLobe(OUT(DiffuseTransmissionBxDF) lobe, SurfaceMaterial material, SurfaceSetting setting,
                      FacetView, INOUT(float) share) {
    vec3 color = share * material.diffuseTransmission *
                 clamp(material.diffuseTransmissionColor, vec3(0.0f), vec3(1.0f));
    lobe.eta = setting.isThin ? 1.0f : setting.eta;
    float passed = Sqr(min(lobe.eta, 1.0f));
    if (HasTraceFeature(kTraceThinScatter) && material.scatterStrength > 0.0f)
        passed = 0.5f + 0.5f * material.scatterMeanCosine;
    lobe.albedo = color * passed;
    lobe.returned = color * (1.0f - passed);
    lobe.reflectProbability = 1.0f - passed;
    share *= 1.0f - material.diffuseTransmission;
}

INLINE bool IsDiffuse(DiffuseTransmissionBxDF) { return true; }

INLINE uint Flags(DiffuseTransmissionBxDF lobe, FacetView) {
    return kBxDFTransmission | kBxDFDiffuse | (lobe.reflectProbability > 0.0f ? kBxDFReflection : 0u);
}

INLINE vec3 Evaluate(DiffuseTransmissionBxDF lobe, FacetView, FacetPair pair, OUT(float) pdf) {
    pdf = 0.0f;
    if (!IsForDiffuse(pair)) return vec3(0.0f);
    float density = CosineHemispherePDF(abs(pair.wi.z));
    bool isThrough = pair.wi.z < 0.0f;
    pdf = isThrough ? (1.0f - lobe.reflectProbability) * density : lobe.reflectProbability * density;
    return (isThrough ? lobe.albedo / Sqr(lobe.eta) : lobe.returned) * kInvPi;
}

INLINE bool SamplesCosine(DiffuseTransmissionBxDF, float) { return true; }

INLINE BSDFSample SampleDirection(DiffuseTransmissionBxDF lobe, FacetView, vec3 drawn, float uc, vec2) {
    if (uc < lobe.reflectProbability) return CosineDirection(drawn, kBxDFDiffuse);
    if (!(drawn.z > 0.0f)) return NoSample();
    return SampledDirection(vec3(drawn.x, drawn.y, -drawn.z), lobe.eta, kBxDFTransmission | kBxDFDiffuse);
}

INLINE LobeMean Reflected(DiffuseTransmissionBxDF lobe, FacetView) {
    LobeMean mean = NoMean();
    mean.albedo = lobe.returned;
    mean.isDiffuse = true;
    return mean;
}

INLINE LobeMean Transmitted(DiffuseTransmissionBxDF lobe, FacetView) {
    LobeMean mean = NoMean();
    mean.albedo = lobe.albedo;
    mean.wi = vec3(0.0f, 0.0f, -1.0f);
    mean.isDiffuse = true;
    return mean;
}

INLINE float Weight(DiffuseTransmissionBxDF lobe, FacetView) { return Average(lobe.albedo + lobe.returned); }

LOBE_HAS_NO_PASS_THROUGH(DiffuseTransmissionBxDF)
LOBE_IS_NOT_A_LAYER(DiffuseTransmissionBxDF)
LOBE_HAS_NO_WALK(DiffuseTransmissionBxDF)
LOBE_BXDF_INTERFACE(DiffuseTransmissionBxDF)

SHADING_END

#endif
