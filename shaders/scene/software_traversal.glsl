// Tracing by the scene's own trees (shared/wide_bvh.h), in any kind of shader: what scene/trace_rays.glsl is
// made of where SOFTWARE_TRAVERSAL is defined. What any-hit shaders do is done here. Triangles alone;
// compiled as C++, also capsules, by
//     WideHit HitOrCapsule(vec3 origin, vec3 direction, float tMax, bool isAny, WideHit hit)
//         which returns `hit`, or that of a capsule that is nearer
// of the bridge, which then also has the functions that scene/wide_bvh.glsl asks for, but for IsAccepted.
#ifndef RAYGRAPH_SCENE_SOFTWARE_TRAVERSAL_GLSL
#define RAYGRAPH_SCENE_SOFTWARE_TRAVERSAL_GLSL

#include "scene/alpha_test.glsl"
#include "scene/payloads.glsl"
#ifdef TRACES_SHADOW_RAYS
#include "scene/wall_shadow.glsl"
#endif
#include "shared/wide_bvh.h"

#ifndef __cplusplus
layout(set = 0, binding = 6, scalar) uniform WideTables {
    Words wideNodes;
    Words wideTriangles;
    Words wideInstances;
};

layout(constant_id = 11) const uint kWideLevels = 2u;  // 1 or 2: see shared/wide_bvh.h

uvec4 WideNodeWord(uint at) { return HalvesOf(wideNodes.at[at]); }
uvec4 WideTriangleWord(uint at) { return HalvesOf(wideTriangles.at[at]); }
uvec4 WideInstanceWord(uint at) { return HalvesOf(wideInstances.at[at]); }

uvec2 groupStack[kWideStackSize];
void PushGroup(uint at, uvec2 group) { groupStack[at] = group; }
uvec2 GroupAt(uint at) { return groupStack[at]; }
#endif

SHADING_BEGIN

// The seed of the ray that is traced.
PRIVATE uint ownAlphaSeed;
#ifdef TRACES_SHADOW_RAYS
PRIVATE ShadowPayload ownShadow;
PRIVATE Ray ownShadowRay;
#endif

INLINE Hit HitOf(WideHit from) {
    Hit hit;
    hit.t = from.t;
    hit.instance = from.instance;
    hit.primitive = from.primitive;
    hit.barycentrics = from.barycentrics;
    return hit;
}

INLINE bool IsAccepted(WideHit hit, bool isBack, bool isAny) {
#ifdef TRACES_SHADOW_RAYS
    // Thin walls are opaque to other rays. The feature comes first: without it nothing of this is compiled
    if (HasTraceFeature(kTraceThinWalls)) {
        if (isAny)
            return OccludesShadowRay(HitOf(hit), ownShadowRay.origin, ownShadowRay.direction, isBack,
                                     ownShadow);
    }
#endif
    if (!HasTraceFeature(kTraceAnyHit)) return true;
    return StopsRay(ownAlphaSeed, hit.instance, hit.primitive, hit.barycentrics, isBack);
}

SHADING_END

#include "scene/wide_bvh.glsl"

SHADING_BEGIN

// Returns the nearest surface up to a distance; `terminateOnFirstHit`: any, of which only whether there is
// one counts.
INLINE Hit HitWithin(Ray ray, float distance, bool terminateOnFirstHit, uint alphaSeed) {
    WideCounts counts;  // nobody asks for them
    counts.nodes = 0u;
    counts.triangles = 0u;
    counts.instances = 0u;
    ownAlphaSeed = alphaSeed;
#ifdef __cplusplus
    WideHit hit = TraverseWide(ray.origin, ray.direction, distance, terminateOnFirstHit, false, counts);
    if (HasTraceFeature(kTraceCapsules))
        hit = HitOrCapsule(ray.origin, ray.direction, distance, terminateOnFirstHit, hit);
    return HitOf(hit);
#else
    return HitOf(
        TraverseWide(ray.origin, ray.direction, distance, terminateOnFirstHit, kWideLevels == 1u, counts));
#endif
}

#ifdef TRACES_SHADOW_RAYS
// Returns ShadowTransmittance of scene/trace_rays.glsl.
INLINE vec3 TransmittanceUpTo(Ray ray, float distance, float ior, uint alphaSeed) {
    if (HasTraceFeature(kTraceThinWalls)) {
        ownShadowRay = ray;
        ownShadow.passed = vec3(1.0f);
        ownShadow.lastDistance = -1.0f;
        ownShadow.ior = ior;
        ownShadow.alphaSeed = alphaSeed;
    }
    bool isFree = HitWithin(ray, distance, true, alphaSeed).t < 0.0f;
    if (HasTraceFeature(kTraceThinWalls)) return isFree ? ownShadow.passed : vec3(0.0f);
    return vec3(isFree ? 1.0f : 0.0f);
}
#endif

SHADING_END

#endif
