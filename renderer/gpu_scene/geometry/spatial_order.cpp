#include "renderer/gpu_scene/geometry/spatial_order.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

namespace raygraph {
namespace {

constexpr uint32_t kAxisBits = 21;
constexpr double kLastStep = (1u << kAxisBits) - 1;
constexpr uint32_t kDigitBits = 9;  // 7 radix-sort digits
constexpr size_t kBlock = 64;       // points whose positions are computed at once

struct Keyed {
    uint64_t key = 0;
    uint32_t index = 0;
};

// Inserts two zeros between any two of the lowest 21 bits.
uint64_t SpreadBits(uint64_t bits) {
    bits = (bits | bits << 32) & 0x1f00000000ffffull;
    bits = (bits | bits << 16) & 0x1f0000ff0000ffull;
    bits = (bits | bits << 8) & 0x100f00f00f00f00full;
    bits = (bits | bits << 4) & 0x10c30c30c30c30c3ull;
    return (bits | bits << 2) & 0x1249249249249249ull;
}

// The cube around all finite points, in 2^21 steps per axis.
class Grid {
  public:
    explicit Grid(std::span<const glm::vec3> points) {
        glm::dvec3 highest = -m_lowest;
        for (const glm::vec3& point : points) {
            if (!glm::all(glm::lessThan(glm::abs(point), glm::vec3(std::numeric_limits<float>::infinity()))))
                continue;
            m_lowest = glm::min(m_lowest, glm::dvec3(point));
            highest = glm::max(highest, glm::dvec3(point));
        }
        const glm::dvec3 size = highest - m_lowest;
        const double extent = std::max({size.x, size.y, size.z, 0.0});
        m_scale = extent > 0.0 ? kLastStep / extent : 0.0;
    }

    uint32_t Step(const glm::vec3& point, int axis) const {
        const double step = (double(point[axis]) - m_lowest[axis]) * m_scale;
        return step >= 0.0 && step <= kLastStep ? static_cast<uint32_t>(step) : 0u;
    }

  private:
    glm::dvec3 m_lowest{std::numeric_limits<double>::infinity()};
    double m_scale = 0.0;
};

// Turns coordinates into bits of positions along a Hilbert curve, interleaved by SpreadBits with x first:
// Skilling 2004, "Programming the Hilbert curve". All points of a block are processed at once, without
// branches.
struct Block {
    std::array<std::array<uint32_t, kBlock>, 3> x{};  // by axis

    void ToCurve() {
        for (uint32_t bit = kAxisBits - 1; bit > 0; --bit) {
            const uint32_t below = (1u << bit) - 1u;
            for (auto& its : x)
                for (size_t i = 0; i < kBlock; ++i) {
                    const uint32_t isSet = 0u - (its[i] >> bit & 1u);  // all ones, or zero
                    const uint32_t swapped = (x[0][i] ^ its[i]) & below & ~isSet;
                    x[0][i] ^= swapped | (below & isSet);
                    its[i] ^= swapped;
                }
        }
        for (size_t i = 0; i < kBlock; ++i) {
            x[1][i] ^= x[0][i];
            x[2][i] ^= x[1][i];
            // Each bit of the last coordinate flips all bits below it
            uint32_t flips = x[2][i] >> 1;
            for (uint32_t shift = 1; shift < kAxisBits; shift *= 2) flips ^= flips >> shift;
            for (auto& its : x) its[i] ^= flips;
        }
    }
    uint64_t Key(size_t i) const {
        return SpreadBits(x[0][i]) << 2 | SpreadBits(x[1][i]) << 1 | SpreadBits(x[2][i]);
    }
};

std::vector<Keyed> KeysOf(std::span<const glm::vec3> points) {
    const Grid grid(points);
    std::vector<Keyed> keyed(points.size());
    Block block;
    for (size_t first = 0; first < points.size(); first += kBlock) {
        const size_t count = std::min(kBlock, points.size() - first);
        for (int axis = 0; axis < 3; ++axis)
            for (size_t i = 0; i < count; ++i) block.x[axis][i] = grid.Step(points[first + i], axis);
        block.ToCurve();
        for (size_t i = 0; i < count; ++i)
            keyed[first + i] = {block.Key(i), static_cast<uint32_t>(first + i)};
    }
    return keyed;
}

}  // namespace

std::vector<uint32_t> SpatialOrder(std::span<const glm::vec3> points) {
    std::vector<Keyed> keyed = KeysOf(points), sorted(points.size());
    // A radix sort by the digits of the keys, the lowest digit first
    for (uint32_t shift = 0; shift < 3 * kAxisBits; shift += kDigitBits) {
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
