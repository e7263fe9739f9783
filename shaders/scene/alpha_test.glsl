// Whether a surface that is not there for every ray stops one: a partly transparent one, or one whose back is
// not there in a group where others' are.
#ifndef RAYGRAPH_SCENE_ALPHA_TEST_GLSL
#define RAYGRAPH_SCENE_ALPHA_TEST_GLSL

#include "core/rng.glsl"
#include "scene/material_textures.glsl"

// The backs of these are not there: as IsBackCulled of renderer/scene says.
bool IsBackCulled(MaterialRecord material) {
    return (material.flags & kMaterialDoubleSided) == 0u && material.transmission == 0.0f;
}

// BLEND is stochastic: of many rays, the share alpha is stopped. The same ray meets the same answer however
// often it is asked, as a device may. `isBack`: it meets the back of the surface.
bool IsThere(uint alphaSeed, uint instanceIndex, uint primitive, vec2 barycentrics, bool isBack) {
    InstanceRecord instance = instances.at[instanceIndex];
    GeometryRecord geometry = geometries.at[GeometryIndex(instance, primitive)];
    MaterialRecord material = materials.at[geometry.material];
    if (isBack && IsBackCulled(material)) return false;
    float opacity = Opacity(geometry, material, TriangleAt(instance, primitive, barycentrics));
    return BitsToUnit(MixBits(alphaSeed ^ MixBits(instanceIndex * 0x9e3779b9u + primitive))) < opacity;
}

#endif
