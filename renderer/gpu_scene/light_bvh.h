// The light tree of shaders/lights/light_bvh.glsl: built over position, orientation and power.
#pragma once

#include <span>
#include <vector>

#include "shaders/shared/light_records.h"

namespace raygraph {

// Builds the tree over the bounded lights (triangles, points, spots) whose power (luminance, W) is above 0,
// and writes their bitTrail; the others are left out. One leaf a light, node 0 the root; empty if no light
// has power. Splits by the surface area orientation heuristic of Conty Estevez and Kulla 2018 over buckets
// along each axis; O(n log n), depth at most 32. Needs no device.
std::vector<gpu::LightNode> BuildLightTree(std::span<gpu::LightRecord> lights, std::span<const float> power);

// Updates the boxes of a tree over these lights, which have all been moved by the same translation: the rest
// of the tree stays. O(n).
void RefitLightTree(std::span<gpu::LightNode> nodes, std::span<const gpu::LightRecord> lights);

}  // namespace raygraph
