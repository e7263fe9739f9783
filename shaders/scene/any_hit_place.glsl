// Where a ray hits what an any-hit shader is asked about.
#ifndef RAYGRAPH_SCENE_ANY_HIT_PLACE_GLSL
#define RAYGRAPH_SCENE_ANY_HIT_PLACE_GLSL

#include "core/capsule.glsl"
#include "scene/alpha_test.glsl"

// As Hit::barycentrics. Computed anew for capsules: Mesa's CPU driver does not hand the attributes of an
// intersection shader to any-hit shaders.
vec2 AnyHitPlace(uint instanceIndex, uint primitive, vec2 attributes) {
    InstanceRecord instance = instances.at[instanceIndex];
    if (!IsRound(instance)) return attributes;
    return CapsulePlaceOf(CapsuleAt(instance, primitive),
                          gl_ObjectRayOriginEXT + gl_HitTEXT * gl_ObjectRayDirectionEXT);
}

#endif
