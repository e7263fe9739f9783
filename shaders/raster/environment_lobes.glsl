// The environment's light scattered by a surface: for each lobe its albedo, by the tables of
// bxdf/energy.glsl, times the environment's mean over the lobe (shared/filtered_environment.h). Exact where
// the environment is the same in all directions.
#ifndef RAYGRAPH_RASTER_ENVIRONMENT_LOBES_GLSL
#define RAYGRAPH_RASTER_ENVIRONMENT_LOBES_GLSL

#include "bxdf/bsdf.glsl"
#include "core/frame.glsl"
#include "scene/environment.glsl"
#include "shared/filtered_environment.h"

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

// The dominant direction of a rough surface's reflection, between the mirror direction and the normal. S.
// Lagarde and C. de Rousiers 2014, "Moving Frostbite to Physically Based Rendering", section 4.9.3.
vec3 DominantReflection(vec3 wo, float roughness) {
    float smoothness = 1.0f - roughness;
    vec3 mirrored = vec3(-wo.x, -wo.y, wo.z);
    return normalize(mix(vec3(0.0f, 0.0f, 1.0f), mirrored, smoothness * (sqrt(smoothness) + roughness)));
}

// Unoccluded share of the directions about the reflected one; `open` is that of all directions. Lagarde and
// de Rousiers, as above, section 4.10.2.
float OpenReflection(float open, float cosine, float roughness) {
    return clamp(pow(cosine + open, exp2(-16.0f * roughness - 1.0f)) - 1.0f + open, 0.0f, 1.0f);
}

// The environment's light reflected by a surface; `open` is the unoccluded share of directions.
vec3 GltfEnvironment(PreparedGltf g, float roughness, float open, Frame frame) {
    if (!(g.wo.z > 0.0f)) return vec3(0.0f);
    GltfBxDF lobe = g.bxdf;
    FacetEnergy energy = FacetEnergyAt(g.row, g.wo.z);
    vec3 f0 = g.dielectric.f0;
    vec3 f90 = g.dielectric.f90;
    vec3 layer = SingleAlbedo(energy, f0, f90) + LaterAlbedo(g, energy, f0, f90);
    vec3 metal =
        SingleAlbedo(energy, lobe.baseColor, vec3(1.0f)) + LaterAlbedo(g, energy, lobe.baseColor, vec3(1.0f));
    vec3 below = (1.0f - lobe.metallic) * lobe.baseColor * max(PassedShare(layer), vec3(0.0f));
    float glass = HasTraceFeature(kTraceGlass) ? lobe.transmission : 0.0f;

    vec3 reflected = FromLocal(frame, DominantReflection(g.wo, roughness));
    vec3 sum = mix(layer, metal, lobe.metallic) * GlossyEnvironment(reflected, roughness) *
               OpenReflection(open, g.wo.z, roughness);
    if (glass < 1.0f)
        sum += (open * (1.0f - glass)) * below * DiffuseEnvironment(FromLocal(frame, vec3(0.0f, 0.0f, 1.0f)));
    return sum;
}

// Share of the light behind glass that is transmitted, and its direction.
struct GlassPath {
    vec3 weight;
    vec3 direction;
    float spread;  // standard deviation of the slope due to roughness
};

GlassPath PathThroughGlass(PreparedGltf g, float roughness, Frame frame) {
    GlassPath path;
    path.weight = vec3(0.0f);
    path.direction = vec3(0.0f);
    path.spread = 0.0f;
    GltfBxDF lobe = g.bxdf;
    if (!HasTraceFeature(kTraceGlass) || !(lobe.transmission > 0.0f && g.wo.z > 0.0f)) return path;
    FacetEnergy energy = FacetEnergyAt(g.row, g.wo.z);
    vec3 f0 = g.dielectric.f0;
    vec3 f90 = g.dielectric.f90;
    vec3 layer = SingleAlbedo(energy, f0, f90) + LaterAlbedo(g, energy, f0, f90);
    vec3 below = (1.0f - lobe.metallic) * lobe.baseColor * max(PassedShare(layer), vec3(0.0f));
    path.weight = lobe.transmission * below;
    vec3 through = -g.wo;
    vec3 refracted = vec3(0.0f);
    if (!g.isThin && Refract(g.wo, vec3(0.0f, 0.0f, 1.0f), g.eta, refracted)) through = refracted;
    path.direction = FromLocal(frame, through);
    // Slopes of facets have a deviation of alpha / sqrt(2); a thin wall deflects light twice as far, as a
    // mirror would, and a boundary by the part that remains after refraction
    path.spread = 0.70710678f * Sqr(roughness) * (g.isThin ? 2.0f : abs(1.0f - 1.0f / g.eta));
    return path;
}

vec3 ReflectedEnvironment(SurfaceBSDF bsdf, float roughness, float open, Frame frame) {
    vec3 normal = FromLocal(frame, vec3(0.0f, 0.0f, 1.0f));
    if (ActiveBrdf() == kBrdfLambert) return open * bsdf.lambert.albedo * DiffuseEnvironment(normal);
    if (ActiveBrdf() == kBrdfLafortune)
        return open * bsdf.lafortune.diffuse * DiffuseEnvironment(normal) +
               OpenReflection(open, bsdf.wo.z, roughness) * bsdf.lafortune.specular *
                   GlossyEnvironment(FromLocal(frame, DominantReflection(bsdf.wo, roughness)), roughness);
    return GltfEnvironment(bsdf.gltf, roughness, open, frame);
}

#endif
