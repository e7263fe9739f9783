// The environment's light scattered by a surface: for each lobe its albedo, by the tables of
// bxdf/energy.glsl, times the environment's mean over the lobe (shared/light_records.h). Exact where
// the environment is the same in all directions.
#ifndef RAYGRAPH_RASTER_ENVIRONMENT_LOBES_GLSL
#define RAYGRAPH_RASTER_ENVIRONMENT_LOBES_GLSL

#include "bxdf/bsdf.glsl"
#include "core/frame.glsl"
#include "scene/environment.glsl"
#include "shared/light_records.h"

layout(set = 0, binding = 17) uniform sampler2D filteredEnvironment;

vec3 FilteredLevel(vec2 uv, uint level) {
    const float rim = 0.5f / float(kFilteredHeight);
    float v = (float(level) + clamp(uv.y, rim, 1.0f - rim)) / float(kFilteredLevels);
    return textureLod(filteredEnvironment, vec2(uv.x, v), 0.0f).xyz;
}

vec3 DiffuseEnvironment(vec3 normal) {
    EnvironmentRecord environment = parameters.value.environment;
    if (environment.hasMap == 0u) return environment.radiance;
    return environment.radiance *
           FilteredLevel(EquirectFromDirection(normal, environment.rotation), kFilteredDiffuse);
}

vec3 GlossyEnvironment(vec3 direction, float roughness) {
    EnvironmentRecord environment = parameters.value.environment;
    if (environment.hasMap == 0u) return environment.radiance;
    vec2 uv = EquirectFromDirection(direction, environment.rotation);
    float place = clamp(roughness, 0.0f, 1.0f) / kFilteredStep;  // 0: the map itself; 1: level 0
    uint above = min(uint(place), kFilteredDiffuse - 1u);
    vec3 sharper = above == 0u ? textureLod(environmentMap, uv, 0.0f).xyz : FilteredLevel(uv, above - 1u);
    return environment.radiance * mix(sharper, FilteredLevel(uv, above), place - float(above));
}

// Unoccluded share of the directions about the reflected one; `open` is that of all directions. Lagarde and
// de Rousiers, as above, section 4.10.2.
float SpecularOcclusion(float open, float cosine, float roughness) {
    return clamp(pow(cosine + open, exp2(-16.0f * roughness - 1.0f)) - 1.0f + open, 0.0f, 1.0f);
}

// Returns the environment's mean over a lobe towards wo that is not diffuse.
vec3 LobeMeanEnvironment(LobeMean lobe, vec3 wo, Frame frame) {
    if (!HasAnisotropicAlpha(lobe.alpha)) return GlossyEnvironment(FromLocal(frame, lobe.wi), lobe.roughness);
    const uint count = 16u;
    vec4 sum = vec4(0.0f);
    DONT_UNROLL
    for (uint i = 0u; i < count; ++i) {
        AnisotropySample part = AnisotropySampleOf(lobe.alpha, wo, i, count);
        if (part.weight > 0.0f)
            sum += part.weight * vec4(GlossyEnvironment(FromLocal(frame, part.wi), part.roughness), 1.0f);
    }
    return sum.xyz / max(sum.w, 1e-20f);
}

// Returns the environment's light reflected by a lobe towards wo; `open` is the unoccluded share of
// directions.
vec3 LobeEnvironment(LobeMean lobe, vec3 wo, float open, Frame frame) {
    if (lobe.isDiffuse) return open * lobe.albedo * DiffuseEnvironment(FromLocal(frame, lobe.wi));
    return SpecularOcclusion(open, wo.z, lobe.roughness) * lobe.albedo * LobeMeanEnvironment(lobe, wo, frame);
}

// Uses the directions of two reflections where a part of the light goes back.
vec3 LobeEnvironment(LobeMean lobe, FacetView view, bool isOfFacets, float open, Frame frame) {
    vec3 ahead = LobeEnvironment(lobe, view.wo, open, frame);
    if (!isOfFacets || !HasRetroreflection(view, lobe.wi)) return ahead;
    lobe.wi = Mirrored(lobe.wi);
    return mix(ahead, LobeEnvironment(lobe, Mirrored(view.wo), open, frame), view.retroreflectedShare);
}

vec3 GltfEnvironment(GltfBSDF g, float open, Frame frame) {
    vec3 sum = vec3(0.0f);
#define ADD_LOBE(Lobe, name, feature)                         \
    if (HasTraceFeature(feature) && g.name##Chance > 0.0f)    \
        sum += LobeEnvironment(Reflected(g.name, g.view), g.view, IsWalked(g.name), open, frame);
    GLTF_LOBES(ADD_LOBE)
#undef ADD_LOBE
    return sum;
}

vec3 ReflectedEnvironment(SurfaceBSDF bsdf, float roughness, float open, Frame frame) {
    vec3 normal = FromLocal(frame, vec3(0.0f, 0.0f, 1.0f));
    if (ActiveBrdf() == kBrdfLambert) return open * bsdf.lambert.albedo * DiffuseEnvironment(normal);
    if (ActiveBrdf() == kBrdfLafortune)
        return open * bsdf.lafortune.diffuse * DiffuseEnvironment(normal) +
               SpecularOcclusion(open, bsdf.wo.z, roughness) * bsdf.lafortune.specular *
                   GlossyEnvironment(FromLocal(frame, DominantReflection(bsdf.wo, roughness)), roughness);
    return GltfEnvironment(bsdf.gltf, open, frame);
}

#endif
