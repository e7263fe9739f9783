// Orders for acceleration-structure builds. Some builders keep the order of their input (lavapipe's does), so
// that neighbors in space have to be neighbors in the index buffer and in the instance buffer.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace raygraph {

// order[k] is the index of the point that comes k-th along a Hilbert curve through a grid of 2^21 steps an
// axis: some points may be very far from the others. Those at one step keep their order. Coordinates that are
// not finite count as the lowest ones.
std::vector<uint32_t> SpatialOrder(std::span<const glm::vec3> points);

// Reorders the triangles of an index list by their centroids, in place. Returns for each triangle of the new
// order its index in the old one; empty when the order is unchanged.
std::vector<uint32_t> SortTriangles(std::span<const glm::vec3> positions, std::vector<uint32_t>& indices);

}  // namespace raygraph
