// Orders for acceleration-structure builds. Some builders keep the order of their input (lavapipe's does), so
// that neighbors in space have to be neighbors in the index buffer and in the instance buffer.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace raygraph {

// order[k] is the index of the point that comes k-th along a space-filling curve.
std::vector<uint32_t> SpatialOrder(std::span<const glm::vec3> points);

// The same for points of which some may be very far from the others: it tells 2^21 steps an axis apart, not
// 2^10. Points that are not finite count as the nearest ones.
std::vector<uint32_t> FineSpatialOrder(std::span<const glm::vec3> points);

// Reorders the triangles of an index list by their centroids, in place. Returns for each triangle of the new
// order its index in the old one; empty when the order is unchanged.
std::vector<uint32_t> SortTriangles(std::span<const glm::vec3> positions, std::vector<uint32_t>& indices);

}  // namespace raygraph
