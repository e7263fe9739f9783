// The any-hit test of shadow rays in a scene with smooth thin walls: a wall attenuates the light and the ray
// goes on. Runs once for each triangle on the ray that is not opaque, or is of such a wall.
#ifndef RAYGRAPH_SCENE_WALL_SHADOW_GLSL
#define RAYGRAPH_SCENE_WALL_SHADOW_GLSL

#include "scene/alpha_test.glsl"
#include "scene/light_bridge.glsl"
#include "scene/payloads.glsl"
#include "scene/surface.glsl"

#include "bxdf/bsdf.glsl"

SHADING_BEGIN

// A ray through an edge may meet the triangles on both sides of it: they are one wall.
CONST float kEdgeWeight = 1e-5f;
CONST float kSameDistance = 1e-6f;

INLINE bool IsDuplicateEdgeHit(Hit hit, float lastDistance) {
    if (IsRound(InstanceAt(hit.instance))) return false;  // has no edges
    float weight = min(min(hit.barycentrics.x, hit.barycentrics.y),
                       1.0f - hit.barycentrics.x - hit.barycentrics.y);
    return weight < kEdgeWeight && abs(hit.t - lastDistance) <= kSameDistance * hit.t;
}

// Returns false if the ray goes on. `isBack`: it hits the back face.
INLINE bool OccludesShadowRay(Hit hit, vec3 origin, vec3 direction, bool isBack,
                              INOUT(ShadowPayload) payload) {
    if (!StopsRay(payload.alphaSeed, hit.instance, hit.primitive, hit.barycentrics, isBack)) return false;
    // Other alpha-tested surfaces, leaves for example, come here too: avoid reading their textures
    // needlessly.
    GeometryRecord geometry = geometries.at[GeometryIndex(InstanceAt(hit.instance), hit.primitive)];
    if ((materials.at[geometry.material].flags & kMaterialGlass) == 0u) return true;
    Ray ray;
    ray.origin = origin;
    ray.direction = direction;
    ray.cone = MakeCone(0.0f, 0.0f);  // shadow rays read level 0, as alpha tests do
    SurfaceInteraction surface = SurfaceAt(hit, ray);
    if (!IsSmoothThinWall(surface.material)) return true;
    if (IsDuplicateEdgeHit(hit, payload.lastDistance)) return false;
    payload.lastDistance = hit.t;
    Frame frame = FrameOf(surface);
    SurfaceSetting setting = SettingOf(surface, frame, surface.material.ior / payload.ior, 0.0f, 0u);
    payload.passed *= PassThroughWeight(surface.material, setting, ToLocal(frame, -ray.direction));
    return !(MaxComponent(payload.passed) > 0.0f);
}

SHADING_END

#endif
