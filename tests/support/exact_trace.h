// Finds what a ray hits by testing every triangle in double precision, to decide who is wrong where two ways
// of tracing disagree. Threads: pure functions.
#pragma once

#include "renderer/bvh/wide_scene.h"

namespace raygraph {

struct ExactHit {
    double t = -1.0;  // negative: nothing
    uint32_t instance = gpu::kWideNoInstance;
    uint32_t primitive = 0;
    // Another answer is within the rounding of floats: the ray passes by an edge, two triangles are
    // equally far, or the hit is at an end of the ray.
    bool isAmbiguous = false;
};

// The nearest triangle between 0 and the ray's tMax.
ExactHit TraceExactly(const BvhScene& scene, const gpu::BenchRay& ray);

}  // namespace raygraph
