// Whether a partly transparent surface stops a ray.
#ifndef RAYGRAPH_SCENE_ALPHA_TEST_GLSL
#define RAYGRAPH_SCENE_ALPHA_TEST_GLSL

#include "core/rng.glsl"
#include "scene/material_textures.glsl"

// BLEND is stochastic: of many rays, the share alpha is stopped. The same ray meets the same answer however
// often it is asked, as a device may.
bool IsThere(uint alphaSeed, uint instanceIndex, uint primitive, vec2 barycentrics) {
    InstanceRecord instance = instances.at[instanceIndex];
    GeometryRecord geometry = geometries.at[GeometryIndex(instance, primitive)];
    MaterialRecord material = materials.at[geometry.material];
    float opacity = Opacity(geometry, material, TriangleAt(instance, primitive, barycentrics));
    return BitsToUnit(MixBits(alphaSeed ^ MixBits(instanceIndex * 0x9e3779b9u + primitive))) < opacity;
}

#endif
