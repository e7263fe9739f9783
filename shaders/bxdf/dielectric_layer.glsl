// The lobe of a dielectric's surface over an opaque base: facets that reflect by Fresnel's share, and pass
// the rest to the base.
//
// The layer reduces the base by what it reflects: with E its albedo, the base is multiplied by (1 - E(wo))
// (1 - E(wi)) / (1 - mean E), which is reciprocal and returns everything where the base is white (Kulla and
// Conty 2017, "Revisiting Physically Based Shading at Imageworks"). With a thin film E is that of a curve
// which is fitted to the film as seen from wo: still nothing is lost, but this part is not reciprocal.
#ifndef RAYGRAPH_BXDF_DIELECTRIC_LAYER_GLSL
#define RAYGRAPH_BXDF_DIELECTRIC_LAYER_GLSL

#include "bxdf/lobe.glsl"

SHADING_BEGIN

struct DielectricLayerBxDF {
    FacetFresnel fresnel;
    TableCurve table;
    float eta;          // from inside a denser medium the layer acts as from outside
    vec3 scale;         // the layer's share of the surface, with the light of later bounces
    float transmittanceScale;  // 1 / mean of what it passes
};

// Returns the share that the layer passes where it reflects with that energy.
INLINE float LayerTransmittance(DielectricLayerBxDF lobe, FacetView view, FacetEnergy energy) {
    vec3 f0 = lobe.table.f0;
    vec3 f90 = lobe.table.f90;
    if (!HasTraceFeature(kTraceIridescence)) {
        // All channels have one f90: that of the largest f0 reflects most, and is computed alone
        f0 = vec3(MaxComponent(f0));
        f90 = vec3(f90.x);
    }
    return max(1.0f - MaxComponent(FacetAlbedo(view, energy, f0, f90)), 0.0f);
}

INLINE void InitLobe(OUT(DielectricLayerBxDF) lobe, SurfaceMaterial material, SurfaceSetting setting,
                      FacetView view, INOUT(float) share) {
    share *= DielectricShare(material) - GlassShare(material);
    lobe.fresnel = DielectricFresnel(material, setting);
    lobe.table.f0 = lobe.fresnel.f0;
    lobe.table.f90 = lobe.fresnel.f90;
    lobe.eta = OutsideEta(setting.eta);
    // A share of 0 needs no branch but for what is costly: paths that run in lockstep would diverge
    if (HasTraceFeature(kTraceIridescence) && share > 0.0f)
        lobe.table = TableCurveOf(lobe.fresnel, view, lobe.eta, true);
    vec3 f0 = lobe.table.f0;
    vec3 f90 = lobe.table.f90;
    vec3 later = MultipleScatteringAlbedo(view, view.energy, f0, f90);
    lobe.scale = share * MultipleScatteringScale(SingleAlbedo(view.energy, f0, f90), later, f90);
    lobe.transmittanceScale = 1.0f / max(LayerTransmittance(lobe, view, MeanFacetEnergy(view.row)), 1e-3f);
    share *= LayerTransmittance(lobe, view, view.energy);
}

INLINE bool IsDiffuse(DielectricLayerBxDF) { return false; }

INLINE uint Flags(DielectricLayerBxDF, FacetView view) {
    return kBxDFReflection | FacetFlags(view);
}

INLINE vec3 Evaluate(DielectricLayerBxDF lobe, FacetView, FacetPair pair, OUT(float) pdf) {
    pdf = 0.0f;
    if (pair.wi.z < 0.0f) return vec3(0.0f);
    pdf = pair.reflectionPDF;
    return lobe.scale * OutsideReflectance(lobe.fresnel, pair.cosI, lobe.eta) * pair.reflection;
}

INLINE bool SamplesCosine(DielectricLayerBxDF, float) { return false; }

INLINE BSDFSample SampleDirection(DielectricLayerBxDF, FacetView view, vec3 wm, float, vec2) {
    return ReflectedDirection(view, wm);
}

INLINE LobeMean Reflected(DielectricLayerBxDF lobe, FacetView view) {
    return FacetMean(view, lobe.scale, lobe.table.f0, lobe.table.f90);
}

INLINE float Weight(DielectricLayerBxDF lobe, FacetView view) {
    return Average(Reflected(lobe, view).albedo);
}

INLINE float NormalizedTransmittance(DielectricLayerBxDF lobe, FacetView view, FacetPair pair) {
    if (!IsForDiffuse(pair)) return 1.0f;
    vec3 wi = vec3(pair.wi.x, pair.wi.y, abs(pair.wi.z));
    return LayerTransmittance(lobe, view, FacetEnergyFrom(view.facets.alpha, view.row, wi)) *
           lobe.transmittanceScale;
}

INLINE bool IsWalked(DielectricLayerBxDF) { return true; }

INLINE MicrosurfaceWalk WalkOf(DielectricLayerBxDF lobe, FacetView view) {
    return ReflectedWalk(view, lobe.fresnel, lobe.eta, lobe.scale);
}

LOBE_IS_OPAQUE(DielectricLayerBxDF)
LOBE_BXDF_INTERFACE(DielectricLayerBxDF)

SHADING_END

#endif
