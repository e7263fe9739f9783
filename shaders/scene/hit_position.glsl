// The place of a hit in the space of its instance.
#ifndef RAYGRAPH_SCENE_HIT_POSITION_GLSL
#define RAYGRAPH_SCENE_HIT_POSITION_GLSL

#include "core/capsule.glsl"
#include "scene/material_textures.glsl"
#include "scene/ray.glsl"

SHADING_BEGIN

INLINE vec3 ObjectPositionOf(InstanceRecord instance, Hit hit) {
    if (IsRound(instance))
        return CapsulePointAt(CapsuleAt(instance, hit.primitive), hit.barycentrics).position;
    UintStream indices = UintStream(instance.indices);
    Vec3Stream positions = Vec3Stream(instance.positions);
    uint first = 3u * hit.primitive;
    vec3 p0 = positions.at[indices.at[first]];
    return p0 + hit.barycentrics.x * (positions.at[indices.at[first + 1u]] - p0) +
           hit.barycentrics.y * (positions.at[indices.at[first + 2u]] - p0);
}

SHADING_END

#endif
