// glTF lobes for tests, and estimates of their albedo.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "tests/support/energy_bridge.h"

#include "bxdf/bsdf.glsl"
#include "bxdf/gltf.glsl"
#include "bxdf/gltf_lobes.glsl"
#include "core/rng.glsl"
#include "tests/shading/lobe_checks.h"

namespace raygraph::shading {

// A material where it is shaded.
struct GltfBxDF : SurfaceMaterial, SurfaceSetting {};

inline GltfBSDF Prepare(const GltfBxDF& lobe, vec3 wo) {
    return Prepare(lobe, lobe, wo);
}

inline FacetView ViewOf(const GltfBxDF& lobe, vec3 wo) {
    return ViewOf(lobe, lobe, wo);
}

inline uint Flags(const GltfBxDF& lobe) {
    return Prepare(lobe, DirectionAt(0.8f, 0.0f)).flags;
}

inline vec3 f(const GltfBxDF& lobe, vec3 wo, vec3 wi) {
    return f(Prepare(lobe, wo), wi);
}

inline float PDF(const GltfBxDF& lobe, vec3 wo, vec3 wi) {
    return PDF(Prepare(lobe, wo), wi);
}

inline BSDFSample Sample_f(const GltfBxDF& lobe, vec3 wo, float uc, vec2 u) {
    return Sample_f(Prepare(lobe, wo), uc, u);
}

// Prepares the lobe once for one viewing direction, instead of for each sample.
struct Seen {
    GltfBSDF bsdf;
};
inline Seen SeenFrom(const GltfBxDF& lobe, vec3 wo) {
    return {Prepare(lobe, wo)};
}
inline uint Flags(const Seen& seen) {
    return seen.bsdf.flags;
}
inline vec3 f(const Seen& seen, vec3, vec3 wi) {
    return f(seen.bsdf, wi);
}
inline float PDF(const Seen& seen, vec3, vec3 wi) {
    return PDF(seen.bsdf, wi);
}
inline BSDFSample Sample_f(const Seen& seen, vec3, float uc, vec2 u) {
    return Sample_f(seen.bsdf, uc, u);
}
// The direction of a sample, which is not evaluated if it need not be: pdf is above 0 where there is one.
inline BSDFSample DirectionOf(const Seen& seen, vec3, float uc, vec2 u) {
    bool isEvaluated = false;
    BSDFSample s = SampleDirection(seen.bsdf, uc, u, isEvaluated);
    if (!isEvaluated) s.pdf = 1.0f;
    return s;
}

inline FacetFresnel DielectricFresnel(const GltfBxDF& lobe) {
    return DielectricFresnel(lobe, SurfaceSetting(lobe));
}

inline GltfBxDF GltfLobe(float alpha) {
    GltfBxDF lobe{};
    lobe.baseColor = vec3(1.0f);
    lobe.metallic = 0.0f;
    lobe.transmission = 0.0f;
    lobe.alpha = vec2(alpha);
    lobe.specular = 1.0f;
    lobe.specularColor = vec3(1.0f);
    lobe.eta = 1.5f;
    lobe.isThin = false;
    lobe.seed = 1u;
    lobe.coatNormal = vec3(0.0f, 0.0f, 1.0f);
    lobe.outerIor = 1.0f;
    return lobe;
}

inline GltfBxDF Metal(float alpha, vec3 color = vec3(1.0f)) {
    GltfBxDF lobe = GltfLobe(alpha);
    lobe.metallic = 1.0f;
    lobe.baseColor = color;
    return lobe;
}

inline GltfBxDF Glass(float alpha, float eta) {
    GltfBxDF lobe = GltfLobe(alpha);
    lobe.transmission = 1.0f;
    lobe.eta = eta;
    return lobe;
}

inline GltfBxDF ThinGlass(float alpha) {
    GltfBxDF lobe = Glass(alpha, 1.5f);
    lobe.isThin = true;
    return lobe;
}

inline GltfBxDF Blend(float alpha) {
    GltfBxDF lobe = GltfLobe(alpha);
    lobe.baseColor = vec3(0.9f, 0.6f, 0.3f);
    lobe.metallic = 0.4f;
    lobe.transmission = 0.5f;
    lobe.specularColor = vec3(0.5f, 1.0f, 1.5f);
    return lobe;
}

// The way that later bounces are treated, for as long as this lives.
class MultiscatterScope {
  public:
    explicit MultiscatterScope(MultiscatterKind kind) : m_before(threadMultiscatterKind) {
        threadMultiscatterKind = kind;
    }
    ~MultiscatterScope() { threadMultiscatterKind = m_before; }
    MultiscatterScope(const MultiscatterScope&) = delete;
    MultiscatterScope& operator=(const MultiscatterScope&) = delete;

  private:
    MultiscatterKind m_before;
};

struct Albedo {
    glm::dvec3 reflected{0.0};
    glm::dvec3 transmitted{0.0};  // flux, not radiance: without 1 / eta^2
    glm::dvec3 Sum() const { return reflected + transmitted; }
};

// Measures with so many samples of Sample_f, stratified over the sample's numbers.
inline Albedo MeasureAlbedo(GltfBxDF lobe, vec3 wo, uint sampleCount) {
    Albedo albedo;
    for (uint i = 0; i < sampleCount; ++i) {
        Sampler rng = StartPixelSample(uvec2(3u, 7u), i, 11u);
        lobe.seed = MixBits(i + 77u);
        const float uc = Get1D(rng);
        const BSDFSample s = Sample_f(lobe, wo, uc, Get2D(rng));
        if (s.pdf == 0.0f) continue;
        const glm::dvec3 weight =
            glm::dvec3(s.f) * static_cast<double>(std::abs(s.wi.z) * s.eta * s.eta / s.pdf);
        (s.wi.z > 0.0f ? albedo.reflected : albedo.transmitted) += weight;
    }
    albedo.reflected /= sampleCount;
    albedo.transmitted /= sampleCount;
    return albedo;
}

// A lobe of a material alone, with the overloads of bxdf/bxdf.glsl, so that the checks of any lobe run on it: single
// scattering, from either side of the surface.
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
