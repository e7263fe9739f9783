// The lobe of a metal: facets that reflect by Fresnel's share (Walter et al. 2007, eq. 20), or a mirror where
// they are smooth.
#ifndef RAYGRAPH_BXDF_CONDUCTOR_GLSL
#define RAYGRAPH_BXDF_CONDUCTOR_GLSL

#include "bxdf/lobe.glsl"

SHADING_BEGIN

struct ConductorBxDF {
    ConductorFresnel fresnel;
    ThinFilm film;
    TableCurve table;
    vec3 scale;  // the metal's share of the surface, with the light of later bounces
};

INLINE FacetFresnel FresnelOf(ConductorBxDF lobe) {
    FacetFresnel fresnel;
    fresnel.f0 = lobe.fresnel.f0;
    fresnel.f90 = lobe.fresnel.f90;
    fresnel.exactF90 = lobe.fresnel.f90;
    fresnel.isMetal = true;
    fresnel.film = lobe.film;
    return fresnel;
}

INLINE void InitLobe(OUT(ConductorBxDF) lobe, SurfaceMaterial material, SurfaceSetting setting,
                      FacetView view, INOUT(float) share) {
    vec3 f0 = material.baseColor;
    vec3 f90 = vec3(1.0f);
    lobe.fresnel = ConductorFromColor(f0, f90);
    lobe.film = NoFilm();
    if (HasTraceFeature(kTraceIridescence)) lobe.film = FilmOf(material, setting.outerIor);
    lobe.table.f0 = f0;
    lobe.table.f90 = f90;
    // No branch where there is none, but for what is costly, as in bxdf/dielectric_layer.glsl
    if (HasTraceFeature(kTraceIridescence) && material.metallic > 0.0f)
        lobe.table = TableCurveOf(FresnelOf(lobe), view, 1.0f, true);
    f0 = lobe.table.f0;
    f90 = lobe.table.f90;
    vec3 later = MultipleScatteringAlbedo(view, view.energy, f0, f90);
    lobe.scale =
        share * material.metallic * MultipleScatteringScale(SingleAlbedo(view.energy, f0, f90), later, f90);
}

INLINE bool IsDiffuse(ConductorBxDF) { return false; }

INLINE uint Flags(ConductorBxDF, FacetView view) { return kBxDFReflection | FacetFlags(view); }

INLINE vec3 Evaluate(ConductorBxDF lobe, FacetView, FacetPair pair, OUT(float) pdf) {
    pdf = 0.0f;
    if (pair.wi.z < 0.0f) return vec3(0.0f);
    pdf = pair.reflectionPDF;
    return lobe.scale * ConductorReflectance(lobe.fresnel, lobe.film, pair.cosI) * pair.reflection;
}

INLINE bool SamplesCosine(ConductorBxDF, float) { return false; }

INLINE BSDFSample SampleDirection(ConductorBxDF, FacetView view, vec3 wm, float, vec2) {
    return ReflectedDirection(view, wm);
}

INLINE LobeMean Reflected(ConductorBxDF lobe, FacetView view) {
    return FacetMean(view, lobe.scale, lobe.table.f0, lobe.table.f90);
}

INLINE float Weight(ConductorBxDF lobe, FacetView view) { return Average(Reflected(lobe, view).albedo); }

INLINE bool IsWalked(ConductorBxDF) { return true; }

INLINE MicrosurfaceWalk WalkOf(ConductorBxDF lobe, FacetView view) {
    return ReflectedWalk(view, FresnelOf(lobe), 1.0f, lobe.scale);
}

LOBE_IS_OPAQUE(ConductorBxDF)
LOBE_IS_NOT_A_LAYER(ConductorBxDF)
LOBE_BXDF_INTERFACE(ConductorBxDF)

SHADING_END

#endif
