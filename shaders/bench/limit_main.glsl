// An upper bound for a path tracer on this device, in this scene: the same camera rays, and no shading.
// LIMIT_BOUNCES cosine bounces follow, off the geometric normal, with only one number kept. Variants define
// LIMIT_BOUNCES, COUNT_RAYS, and SOFTWARE_TRAVERSAL (a compute shader, by the scene's own trees). Round
// primitives are not hit.
#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef SOFTWARE_TRAVERSAL
#define NO_TLAS
layout(local_size_x = 8, local_size_y = 8) in;
#define LAUNCH_ID   gl_GlobalInvocationID
#define LAUNCH_SIZE imageSize(result)
#else
#define LAUNCH_ID   gl_LaunchIDEXT
#define LAUNCH_SIZE gl_LaunchSizeEXT
#endif
#include "scene/extensions.glsl"

#include "bench/limit_ray_offset.glsl"
#include "core/frame.glsl"
#include "core/rng.glsl"
#include "core/warp.glsl"
#include "scene/bindings.glsl"
#include "scene/camera.glsl"
#define RAY_MASK kMaskTriangles
#include "scene/trace_rays.glsl"

layout(set = 0, binding = 16, r32f) writeonly uniform image2D result;
#ifdef COUNT_RAYS
layout(set = 0, binding = 17, r32f) writeonly uniform image2D rayCounts;
#endif

const float kLimitAlbedo = 0.5f;

void main() {
    uvec2 pixel = LAUNCH_ID.xy;
#ifdef SOFTWARE_TRAVERSAL
    if (any(greaterThanEqual(pixel, uvec2(imageSize(result))))) return;
#endif
    Sampler rng = StartPixelSample(pixel, parameters.value.sampleIndex, parameters.value.seed);
    vec2 film = (vec2(pixel) + Get2D(rng)) / vec2(LAUNCH_SIZE.xy);
    Ray ray = CameraRay(parameters.value.camera, film, Get2D(rng));
    Hit hit = Intersect(ray, 0u);
    float value = hit.t;
    float rayCount = 1.0f;
#if LIMIT_BOUNCES > 0
    for (uint bounce = 0u; bounce < LIMIT_BOUNCES && IsHit(hit); ++bounce) {
#ifdef SOFTWARE_TRAVERSAL
        InstanceRecord instance = InstanceAt(hit.instance);
#else
        InstanceRecord instance = instances.at[hit.instance];
#endif
        UintStream indices = UintStream(instance.indices);
        Vec3Stream positions = Vec3Stream(instance.positions);
        uint first = 3u * hit.primitive;
        mat3 linear = mat3(instance.objectToWorld);
        vec3 p0 = positions.at[indices.at[first]];
        vec3 e1 = positions.at[indices.at[first + 1u]] - p0;
        vec3 e2 = positions.at[indices.at[first + 2u]] - p0;
        vec3 n = UnitOr(cross(linear * e1, linear * e2), -ray.direction);
        if (dot(n, ray.direction) > 0.0f) n = -n;
        vec3 p = p0 + hit.barycentrics.x * e1 + hit.barycentrics.y * e2;
        ray.origin = OffsetLimitRay(instance.objectToWorld * vec4(p, 1.0f), n);
        ray.direction = FromLocal(FrameFromZ(n), SampleCosineHemisphere(Get2D(rng)));
        hit = Intersect(ray, 0u);
        value = kLimitAlbedo * value + hit.t;
        rayCount += 1.0f;
    }
#endif
    imageStore(result, ivec2(pixel), vec4(value));
#ifdef COUNT_RAYS
    imageStore(rayCounts, ivec2(pixel), vec4(rayCount));
#endif
}
