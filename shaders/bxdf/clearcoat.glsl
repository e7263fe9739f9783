// The lobe of a clear coat (KHR_materials_clearcoat): a layer of a dielectric of index 1.5 over the whole
// material, with a weight, a roughness and a normal of its own. It scatters at the coat's facets, and passes
// the rest to what lies below. The extension weights that by 1 - w F(V.N); here the albedo E of the coat is
// in place of F, which is the same where the coat is smooth, and a diffuse base depends on the light's
// direction by Kulla and Conty's factor, as in bxdf/dielectric_layer.glsl. So a white material stays white
// under any coat.
//
// The coat's normal may be another than the surface's: f here is per cosine to the surface's.
#ifndef RAYGRAPH_BXDF_CLEARCOAT_GLSL
#define RAYGRAPH_BXDF_CLEARCOAT_GLSL

#include "bxdf/lobe.glsl"
#include "core/frame.glsl"

SHADING_BEGIN

CONST float kClearcoatEta = 1.5f;

INLINE FacetFresnel ClearcoatFresnel() {
    FacetFresnel fresnel;
    fresnel.f0 = vec3(DielectricF0(kClearcoatEta));
    fresnel.f90 = vec3(DielectricF90(kClearcoatEta));
    fresnel.exactF90 = vec3(1.0f);
    fresnel.isMetal = false;
    fresnel.film = NoFilm();
    return fresnel;
}

// Returns the albedo of the coat's facets where they reflect with that energy, later reflections included.
INLINE float ClearcoatAlbedo(FacetEnergy energy, float higherOrderCurve) {
    FacetFresnel fresnel = ClearcoatFresnel();
    vec3 albedo = SingleAlbedo(energy, fresnel.f0, fresnel.f90);
    if (HasCompensation()) albedo += MultipleAlbedo(energy, fresnel.f0, fresnel.f90, higherOrderCurve);
    return min(albedo.x, 1.0f);
}

// Returns the share of light at that cosine to the coat's normal that a coat lets pass, as for what the
// surface below emits.
INLINE float ClearcoatTransmittance(float weight, float roughness, float cosTheta) {
    TableSpan row = EnergyRow(MakeMicrofacetDistribution(vec2(Sqr(roughness))).alpha.x);
    return 1.0f - weight * ClearcoatAlbedo(FacetEnergyAt(row, cosTheta), HigherOrderCurve(row));
}

// Returns the share of what a surface emits towards wo that its clear coat lets pass: of a surface that a ray
// hit, and of a light that is sampled.
INLINE float EmissionTransmittance(SurfaceInteraction surface, vec3 wo) {
    SurfaceMaterial material = surface.material;
    if (!HasTraceFeature(kTraceClearcoat) || !(material.clearcoat > 0.0f)) return 1.0f;
    return ClearcoatTransmittance(material.clearcoat, material.clearcoatRoughness,
                                  dot(surface.coatNormal, wo));
}

struct ClearcoatBxDF {
    Frame frame;     // frame of the coat's normal, within the surface's frame
    FacetView view;  // view of the coat's facets, within `frame`
    float weight;
    float scale;        // weight, with the light of later bounces
    float transmittanceScale;  // 1 / mean of what it passes
};

INLINE void InitLobe(OUT(ClearcoatBxDF) lobe, SurfaceMaterial material, SurfaceSetting setting,
                      FacetView view, INOUT(float) share) {
    lobe.frame = FrameFromZ(setting.coatNormal);
    lobe.view = ViewOfFacets(vec2(setting.coatAlpha), false, material.clearcoatRoughness,
                             ToLocal(lobe.frame, view.wo), setting.seed);
    lobe.weight = share * material.clearcoat;
    lobe.scale = 0.0f;
    lobe.transmittanceScale = 1.0f;
    if (!(lobe.weight > 0.0f)) return;
    FacetFresnel fresnel = ClearcoatFresnel();
    FacetEnergy energy = lobe.view.energy;
    vec3 single = SingleAlbedo(energy, fresnel.f0, fresnel.f90);
    vec3 multiple = MultipleAlbedo(energy, fresnel.f0, fresnel.f90, lobe.view.higherOrderCurve);
    lobe.scale = lobe.weight * MultipleScatteringScale(single, multiple, fresnel.f90).x;
    float mean = ClearcoatAlbedo(MeanFacetEnergy(lobe.view.row), lobe.view.higherOrderCurve);
    lobe.transmittanceScale = 1.0f / max(1.0f - lobe.weight * mean, 1e-3f);
    share *= 1.0f - lobe.weight * ClearcoatAlbedo(energy, lobe.view.higherOrderCurve);
}

INLINE bool IsDiffuse(ClearcoatBxDF) { return false; }

INLINE uint Flags(ClearcoatBxDF lobe, FacetView) { return kBxDFReflection | FacetFlags(lobe.view); }

INLINE vec3 Evaluate(ClearcoatBxDF lobe, FacetView, FacetPair pair, OUT(float) pdf) {
    pdf = 0.0f;
    vec3 wi = ToLocal(lobe.frame, pair.wi);
    if (!(pair.wi.z > 0.0f) || !(wi.z > 0.0f) || !(lobe.view.wo.z > 0.0f)) return vec3(0.0f);
    FacetPair own = PairOf(lobe.view, wi, pair.isDelta);
    pdf = own.reflectionPDF;
    float reflectance = OutsideReflectance(ClearcoatFresnel(), own.cosI, kClearcoatEta).x;
    return vec3(lobe.scale * reflectance * own.reflection * (wi.z / pair.wi.z));
}

INLINE bool SamplesCosine(ClearcoatBxDF, float) { return false; }

INLINE BSDFSample SampleDirection(ClearcoatBxDF lobe, FacetView, vec3, float, vec2 u) {
    if (!(lobe.view.wo.z > 0.0f)) return NoSample();
    BSDFSample s = ReflectedDirection(lobe.view, SampleNormal(lobe.view, u));
    s.wi = FromLocal(lobe.frame, s.wi);
    if (!(s.wi.z > 0.0f)) return NoSample();
    return s;
}

INLINE LobeMean Reflected(ClearcoatBxDF lobe, FacetView) {
    FacetFresnel fresnel = ClearcoatFresnel();
    LobeMean mean = FacetMean(lobe.view, vec3(lobe.scale), fresnel.f0, fresnel.f90);
    mean.wi = FromLocal(lobe.frame, mean.wi);
    return mean;
}

INLINE float Weight(ClearcoatBxDF lobe, FacetView view) { return Reflected(lobe, view).albedo.x; }

INLINE float NormalizedTransmittance(ClearcoatBxDF lobe, FacetView, FacetPair pair) {
    if (!IsForDiffuse(pair)) return 1.0f;
    // On the other side of a sheet, the coat's normal points to that side.
    float cosTheta = dot(lobe.frame.z, pair.wi) * (pair.wi.z < 0.0f ? -1.0f : 1.0f);
    FacetEnergy energy = FacetEnergyAt(lobe.view.row, cosTheta);
    return (1.0f - lobe.weight * ClearcoatAlbedo(energy, lobe.view.higherOrderCurve)) *
           lobe.transmittanceScale;
}

LOBE_IS_OPAQUE(ClearcoatBxDF)
LOBE_HAS_NO_WALK(ClearcoatBxDF)
LOBE_BXDF_INTERFACE(ClearcoatBxDF)

SHADING_END

#endif
