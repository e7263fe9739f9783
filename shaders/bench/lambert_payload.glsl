// The payload of the recursive form.
#ifndef RAYGRAPH_BENCH_LAMBERT_PAYLOAD_GLSL
#define RAYGRAPH_BENCH_LAMBERT_PAYLOAD_GLSL

#include "core/rng.glsl"

struct LambertPayload {  // 28 bytes
    vec3 radiance;       // back: along the ray, what comes after it included
    uint depth;          // there: bounces before the ray
    Sampler rng;
};

#endif
