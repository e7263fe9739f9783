// Orders for acceleration-structure builds. Some builders keep the order of their input (lavapipe's does), so
// that neighbors in space have to be neighbors in the index buffer and in the instance buffer. Threads: pure
// functions of their arguments.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace raygraph {

// Returns the order of the points along a Hilbert curve: order[k] is the index of the k-th point. The grid
// has 2^21 steps per axis, since some points may be very far from the others. Points of one cell keep their
// order, and coordinates that are not finite count as the lowest ones.
std::vector<uint32_t> SpatialOrder(std::span<const glm::vec3> points);

// Reorders the triangles of an index list by their centroids, in place. Returns for each triangle of the new
// order its index in the old one; empty when the order is unchanged.
std::vector<uint32_t> SortTriangles(std::span<const glm::vec3> positions, std::vector<uint32_t>& indices);

}  // namespace raygraph
