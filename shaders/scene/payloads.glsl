// What the rays of each type carry.
#ifndef RAYGRAPH_SCENE_PAYLOADS_GLSL
#define RAYGRAPH_SCENE_PAYLOADS_GLSL

#include "scene/ray.glsl"

struct RadiancePayload {  // 24 bytes
    Hit hit;
    uint alphaSeed;
};

struct ShadowPayload {
    uint alphaSeed;
    uint isOccluded;
};

#endif
