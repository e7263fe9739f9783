// The bounce of the limits: off the geometric normal, cosine-distributed.
#ifndef RAYGRAPH_BENCH_LIMIT_BOUNCE_GLSL
#define RAYGRAPH_BENCH_LIMIT_BOUNCE_GLSL

#include "bench/limit_ray_offset.glsl"
#include "core/frame.glsl"
#include "core/rng.glsl"
#include "core/warp.glsl"
#include "scene/bindings.glsl"
#include "scene/ray.glsl"

const float kLimitAlbedo = 0.5f;

void LimitBounce(Hit hit, inout Ray ray, inout Sampler rng) {
    InstanceRecord instance = instances.at[hit.instance];
    UintStream indices = UintStream(instance.indices);
    Vec3Stream positions = Vec3Stream(instance.positions);
    uint first = 3u * hit.primitive;
    mat3 linear = mat3(instance.objectToWorld);
    vec3 p0 = positions.at[indices.at[first]];
    vec3 e1 = positions.at[indices.at[first + 1u]] - p0;
    vec3 e2 = positions.at[indices.at[first + 2u]] - p0;
    vec3 n = normalize(cross(linear * e1, linear * e2));
    if (dot(n, ray.direction) > 0.0f) n = -n;
    vec3 p = p0 + hit.barycentrics.x * e1 + hit.barycentrics.y * e2;
    ray.origin = OffsetLimitRay(instance.objectToWorld * vec4(p, 1.0f), n);
    ray.direction = FromLocal(FrameFromZ(n), SampleCosineHemisphere(Get2D(rng)));
}

#endif
