// Axis-aligned boxes of primitives, and the tree over them. Threads: plain values.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>

namespace raygraph {

// A box is empty by default: min is above max.
struct Box {
    glm::vec3 min{std::numeric_limits<float>::infinity()};
    glm::vec3 max{-std::numeric_limits<float>::infinity()};

    void Extend(const glm::vec3& point) {
        min = glm::min(min, point);
        max = glm::max(max, point);
    }
    void Extend(const Box& other) {
        min = glm::min(min, other.min);
        max = glm::max(max, other.max);
    }
    // Returns whether the box is neither empty nor infinite.
    bool IsFinite() const {
        for (int axis = 0; axis < 3; ++axis)
            if (!std::isfinite(min[axis]) || !std::isfinite(max[axis]) || min[axis] > max[axis]) return false;
        return true;
    }
    bool operator==(const Box&) const = default;
    glm::vec3 Center() const { return 0.5f * min + 0.5f * max; }
    // Returns half the surface area; 0 for an empty box.
    float HalfArea() const {
        const glm::vec3 size = max - min;
        return size.x >= 0.0f ? size.x * size.y + size.y * size.z + size.z * size.x : 0.0f;
    }
};

}  // namespace raygraph
