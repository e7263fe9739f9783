// Facets that reflect light back to where it came from (KHR_materials_retroreflection, draft): a share of
// what the material's own facets reflect, of metal, dielectric layer and glass, is that for a viewer mirrored
// about the normal, f(Mirrored(wo), wi). Portsmouth et al. 2026, the minimal retroreflective microfacet
// model, JCGT 15(1). What they transmit, clear coat, sheen and diffuse lobes stay as they are.
//
// Turned by half a circle facets are distributed as before. So f stays reciprocal, albedos and what passes to
// lobes below are those without, and a direction of f(wo, .) that is mirrored is one of f(Mirrored(wo), .).
//
// It applies to the lobes with IsWalked, which have these facets.
#ifndef RAYGRAPH_BXDF_RETROREFLECTION_GLSL
#define RAYGRAPH_BXDF_RETROREFLECTION_GLSL

#include "bxdf/lobe.glsl"

SHADING_BEGIN

// Returns whether a part of such light is reflected back: not of what is transmitted.
INLINE bool HasRetroreflection(FacetView view, vec3 wi) {
    return HasTraceFeature(kTraceRetroreflection) && view.retroreflectedShare > 0.0f && wi.z > 0.0f;
}

// Returns the pair for light that goes back; only for directions that HasRetroreflection.
INLINE FacetPair RetroreflectedPair(FacetView view, vec3 wi, bool isDelta) {
    view.wo = Mirrored(view.wo);
    return PairOf(view, wi, isDelta);
}

// Returns whether a sample is of that light; `within` remains uniform.
INLINE bool ChooseRetroreflection(FacetView view, INOUT(float) within) {
    if (!HasTraceFeature(kTraceRetroreflection) || !(view.retroreflectedShare > 0.0f)) return false;
    bool isBack = within < view.retroreflectedShare;
    within = isBack ? within / view.retroreflectedShare
                    : (within - view.retroreflectedShare) / (1.0f - view.retroreflectedShare);
    within = min(within, 0.99999994f);
    return isBack;
}

SHADING_END

#endif
