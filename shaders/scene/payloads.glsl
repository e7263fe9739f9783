// What the rays of each type carry.
#ifndef RAYGRAPH_SCENE_PAYLOADS_GLSL
#define RAYGRAPH_SCENE_PAYLOADS_GLSL

#include "scene/ray.glsl"

struct RadiancePayload {  // 24 bytes
    Hit hit;
    uint alphaSeed;
};

// No larger than that of the other rays: what a ray may carry is reserved for all of them.
struct ShadowPayload {   // 24 bytes
    vec3 passed;         // share of light that the smooth thin walls met so far let through
    float lastDistance;  // of the wall met last; kShadowRayArrived: nothing opaque was on the ray
    float ior;           // of the medium around the walls
    uint alphaSeed;
};

const float kShadowRayArrived = -2.0f;

#endif
