// Random triangles, placed, and rays among them, with what the rays hit, in double precision.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/bvh/wide_scene.h"
#include "shaders/shared/wide_bvh.h"
#include "tests/support/exact_trace.h"

namespace raygraph::testing {

// Triangles of about this size around points in [-1, 1]^3.
BvhMesh TriangleSoup(uint32_t count, float size, uint32_t seed);
// Two meshes, placed in several ways, some of them mirrored and of another scale on each axis.
BvhScene InstancedTriangleSoup();
// Returns rays of different lengths from points in [-2, 2]^3, most of them through [-1, 1]^3.
std::vector<gpu::BenchRay> RandomRays(uint32_t count, uint32_t seed);

std::vector<Box> TriangleBoxes(const BvhMesh& mesh);
WideMesh BuildWideMesh(const BvhMesh& mesh);
// Two levels. Error{Usage} for trees that are too deep, and for meshes that reach too far for one.
WideScene BuildWideScene(const BvhScene& scene);

}  // namespace raygraph::testing
