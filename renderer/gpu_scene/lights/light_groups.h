// Groups of a scene's lights: see gpu::kLightGroupRest and its neighbors. Threads: plain values and pure
// functions.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/api.h"
#include "shaders/shared/light_records.h"

namespace raygraph {

// Light groups by index of the scene's instances, materials and punctual lights: gpu::kLightGroupNamed and
// above, or gpu::kLightGroupRest. A triangle is in the lower of the groups of its instance and its material,
// where Rest is the highest. An empty list assigns all to Rest.
struct LightGroups {
    uint32_t namedCount = 0;  // at most gpu::kMaxNamedLightGroups
    std::vector<uint32_t> instances, materials, lights;
};

// Throws Error{Usage} for lists that are neither empty nor of the scene's sizes, or a group that is out of
// range.
RAYGRAPH_API void RequireFitting(const LightGroups& groups, size_t instanceCount, size_t materialCount,
                                 size_t lightCount);

// Returns the group of a light that is in two: the lower one, with Rest as the highest.
inline uint32_t FirstLightGroup(uint32_t a, uint32_t b) {
    return a == gpu::kLightGroupRest || b == gpu::kLightGroupRest ? std::max(a, b) : std::min(a, b);
}

}  // namespace raygraph
