// A lobe of a material alone, with the overloads of bxdf/bxdf.glsl, so that the checks of any lobe run on it:
// single scattering, from either side of the surface.
#pragma once

#include "tests/support/energy_bridge.h"

#include "bxdf/gltf_lobes.glsl"
#include "tests/shading/gltf_lobe.h"

namespace raygraph::shading {

template <class Lobe>
struct LoneLobe {
    Lobe lobe;
    SurfaceSetting setting;
};

// Returns the lobe for a viewer below: the frame is mirrored, and the media are swapped.
template <class Lobe>
Lobe Turned(Lobe lobe, const SurfaceSetting&) {
    return lobe;
}

inline GlassBxDF Turned(GlassBxDF lobe, const SurfaceSetting& setting) {
    if (setting.isThin) return lobe;
    lobe.eta = 1.0f / lobe.eta;
    lobe.mediumEta = 1.0f / lobe.mediumEta;
    return lobe;
}

// Returns the facets without the energy tables, which only InitLobe reads.
inline FacetView FacetsOf(const SurfaceSetting& setting, vec3 wo) {
    FacetView view{};
    view.wo = wo;
    view.facets = MakeMicrofacetDistribution(setting.alpha);
    view.isSmooth = IsEffectivelySmooth(view.facets);
    view.isThin = setting.isThin;
    return view;
}

inline vec3 TurnedOver(vec3 w, bool isBelow) {
    return isBelow ? vec3(w.x, w.y, -w.z) : w;
}

template <class Lobe>
uint Flags(const LoneLobe<Lobe>& lone) {
    return Flags(lone.lobe, FacetsOf(lone.setting, vec3(0.0f, 0.0f, 1.0f)));
}

template <class Lobe>
vec3 f(const LoneLobe<Lobe>& lone, vec3 wo, vec3 wi) {
    const bool isBelow = wo.z < 0.0f;
    const Lobe lobe = isBelow ? Turned(lone.lobe, lone.setting) : lone.lobe;
    return f(lobe, FacetsOf(lone.setting, TurnedOver(wo, isBelow)), TurnedOver(wi, isBelow));
}

template <class Lobe>
float PDF(const LoneLobe<Lobe>& lone, vec3 wo, vec3 wi) {
    const bool isBelow = wo.z < 0.0f;
    const Lobe lobe = isBelow ? Turned(lone.lobe, lone.setting) : lone.lobe;
    return PDF(lobe, FacetsOf(lone.setting, TurnedOver(wo, isBelow)), TurnedOver(wi, isBelow));
}

template <class Lobe>
BSDFSample Sample_f(const LoneLobe<Lobe>& lone, vec3 wo, float uc, vec2 u) {
    const bool isBelow = wo.z < 0.0f;
    const Lobe lobe = isBelow ? Turned(lone.lobe, lone.setting) : lone.lobe;
    BSDFSample s = Sample_f(lobe, FacetsOf(lone.setting, TurnedOver(wo, isBelow)), uc, u);
    s.wi = TurnedOver(s.wi, isBelow);
    return s;
}

// Samples like Sample_f, without evaluation.
template <class Lobe>
BSDFSample DirectionOf(const LoneLobe<Lobe>& lone, vec3 wo, float uc, vec2 u) {
    const bool isBelow = wo.z < 0.0f;
    const Lobe lobe = isBelow ? Turned(lone.lobe, lone.setting) : lone.lobe;
    const FacetView view = FacetsOf(lone.setting, TurnedOver(wo, isBelow));
    BSDFSample s = SampleDirection(lobe, view, SampleCosineOrNormal(view, SamplesCosine(lobe, uc), u), uc, u);
    if (s.flags != kBxDFNone) s.pdf = 1.0f;
    s.wi = TurnedOver(s.wi, isBelow);
    return s;
}

// The lobe that a material has at one of its views.
template <class Lobe>
Lobe PlacedLobe(const GltfBxDF& material, vec3 wo) {
    Lobe lobe{};
    float share = 1.0f;
    InitLobe(lobe, material, material, ViewOf(material, wo), share);
    return lobe;
}

}  // namespace raygraph::shading
