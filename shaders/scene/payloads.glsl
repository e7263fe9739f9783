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

// Of shadow rays in scenes with smooth thin walls.
struct WallShadowPayload {  // 28 bytes
    vec3 passed;            // share of light that the walls met so far let through
    float lastDistance;     // of the wall met last
    float ior;              // of the medium around them
    uint alphaSeed;
    uint isOccluded;
};

#endif
