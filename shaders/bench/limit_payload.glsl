// The payload of the limit that bounces in the closest hit.
#ifndef RAYGRAPH_BENCH_LIMIT_PAYLOAD_GLSL
#define RAYGRAPH_BENCH_LIMIT_PAYLOAD_GLSL

#include "core/rng.glsl"

struct LimitPayload {  // 40 bytes
    vec3 origin;       // of the next ray
    float t;           // negative: nothing was hit
    vec3 direction;
    Sampler rng;
};

#endif
