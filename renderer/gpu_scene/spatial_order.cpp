#include "renderer/gpu_scene/spatial_order.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

namespace raygraph {
namespace {

constexpr double kFineSteps = (1 << 21) - 1;
constexpr int kDigitBits = 9;  // seven digits

struct Keyed {
    uint64_t key = 0;
    uint32_t index = 0;
};

// Two zeros between any two bits of the lowest 21.
uint64_t SpreadBits(uint64_t bits) {
    bits = (bits | bits << 32) & 0x1f00000000ffffull;
    bits = (bits | bits << 16) & 0x1f0000ff0000ffull;
    bits = (bits | bits << 8) & 0x100f00f00f00f00full;
    bits = (bits | bits << 4) & 0x10c30c30c30c30c3ull;
    return (bits | bits << 2) & 0x1249249249249249ull;
}

}  // namespace

std::vector<uint32_t> SpatialOrder(std::span<const glm::vec3> points) {
    std::vector<uint32_t> order(points.size());
    if (points.empty()) return order;
    std::vector<uint32_t> remap(points.size());
    meshopt_spatialSortRemap(remap.data(), &points[0].x, points.size(), sizeof(glm::vec3));
    for (uint32_t i = 0; i < points.size(); ++i) order[remap[i]] = i;
    return order;
}

std::vector<uint32_t> FineSpatialOrder(std::span<const glm::vec3> points) {
    glm::dvec3 lowest(std::numeric_limits<double>::infinity()), highest = -lowest;
    for (const glm::vec3& point : points) {
        if (!glm::all(glm::lessThan(glm::abs(point), glm::vec3(std::numeric_limits<float>::infinity()))))
            continue;
        lowest = glm::min(lowest, glm::dvec3(point));
        highest = glm::max(highest, glm::dvec3(point));
    }
    const glm::dvec3 size = highest - lowest;
    const double extent = std::max({size.x, size.y, size.z, 0.0});
    const double scale = extent > 0.0 ? kFineSteps / extent : 0.0;
    std::vector<Keyed> keyed(points.size()), sorted(points.size());
    for (uint32_t i = 0; i < keyed.size(); ++i) {
        uint64_t key = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double step = (double(points[i][axis]) - lowest[axis]) * scale;
            if (step >= 0.0 && step <= kFineSteps) key |= SpreadBits(static_cast<uint64_t>(step)) << axis;
        }
        keyed[i] = {key, i};
    }
    // By the digits of the keys, the lowest one first
    for (int shift = 0; shift < 63; shift += kDigitBits) {
        const auto digit = [shift](const Keyed& k) { return (k.key >> shift) % (uint64_t{1} << kDigitBits); };
        std::array<size_t, (1u << kDigitBits) + 1> begins{};
        for (const Keyed& k : keyed) ++begins[digit(k) + 1];
        std::partial_sum(begins.begin(), begins.end(), begins.begin());
        for (const Keyed& k : keyed) sorted[begins[digit(k)]++] = k;
        keyed.swap(sorted);
    }
    std::vector<uint32_t> order(points.size());
    std::ranges::transform(keyed, order.begin(), &Keyed::index);
    return order;
}

std::vector<uint32_t> SortTriangles(std::span<const glm::vec3> positions, std::vector<uint32_t>& indices) {
    const size_t triangleCount = indices.size() / 3;
    std::vector<uint32_t> order;
    {
        std::vector<glm::vec3> centroids(triangleCount);
        for (size_t i = 0; i < triangleCount; ++i)
            centroids[i] =
                (positions[indices[3 * i]] + positions[indices[3 * i + 1]] + positions[indices[3 * i + 2]]) /
                3.0f;
        order = SpatialOrder(centroids);
    }
    bool isMoved = false;
    std::vector<uint32_t> sorted(indices.size());
    for (size_t i = 0; i < triangleCount; ++i) {
        const size_t source = order[i];
        isMoved |= source != i;
        for (size_t corner = 0; corner < 3; ++corner) sorted[3 * i + corner] = indices[3 * source + corner];
    }
    if (!isMoved) return {};
    indices = std::move(sorted);
    return order;
}

}  // namespace raygraph
