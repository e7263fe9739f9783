// The payloads of each ray type.
#ifndef RAYGRAPH_SCENE_PAYLOADS_GLSL
#define RAYGRAPH_SCENE_PAYLOADS_GLSL

#include "scene/ray.glsl"

SHADING_BEGIN

struct RadiancePayload {  // 24 bytes
    Hit hit;
    uint alphaSeed;
};

// The payload is no larger than that of the other rays: the size of the largest one is reserved for all.
struct ShadowPayload {   // 24 bytes
    vec3 passed;         // transmittance of the smooth thin walls met so far
    float lastDistance;  // distance of the last wall; kShadowRayArrived: nothing opaque was on the ray
    float ior;           // index of the medium around the walls
    uint alphaSeed;
};

CONST float kShadowRayArrived = -2.0f;

SHADING_END

#endif
