#include "renderer/gpu_scene/light_bvh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <limits>
#include <numbers>

#include "base/check.h"

namespace raygraph {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr uint32_t kMaxDepth = 32;  // bits of a trail
constexpr uint32_t kBucketCount = 12;

// Bounds of lights: their box, and their emission within thetaE about directions within thetaO of the axis.
struct LightBounds {
    glm::vec3 min{std::numeric_limits<float>::infinity()};
    glm::vec3 max{-std::numeric_limits<float>::infinity()};
    glm::dvec3 axis{0.0, 0.0, 1.0};
    double thetaO = 0.0;
    double thetaE = 0.0;
    double power = 0.0;
    bool isTwoSided = false;

    bool IsEmpty() const { return power == 0.0; }
};

struct Box {
    glm::vec3 min, max;
};

Box BoxOf(const gpu::LightRecord& light) {
    Box box{light.p0, light.p0};
    if (light.kind != gpu::kLightTriangle) return box;
    for (const glm::vec3& corner : {light.p0 + light.e1, light.p0 + light.e2}) {
        box.min = glm::min(box.min, corner);
        box.max = glm::max(box.max, corner);
    }
    return box;
}

LightBounds BoundsOf(const gpu::LightRecord& light, float power) {
    const Box box = BoxOf(light);
    LightBounds bounds;
    bounds.power = power;
    bounds.min = box.min;
    bounds.max = box.max;
    bounds.thetaE = 0.5 * kPi;
    if (light.kind == gpu::kLightTriangle) {
        bounds.axis = glm::normalize(glm::cross(glm::dvec3(light.e1), glm::dvec3(light.e2)));
        if ((light.flags & gpu::kLightMirrored) != 0) bounds.axis = -bounds.axis;
        bounds.isTwoSided = (light.flags & gpu::kLightDoubleSided) != 0;
    } else if (light.kind == gpu::kLightPoint) {
        bounds.thetaO = kPi;
    } else {
        const double offset = light.spotOffsetOrClearance, scale = light.spotScale;
        const double outer = std::acos(std::clamp(-offset / scale, -1.0, 1.0));
        bounds.axis = glm::normalize(glm::dvec3(light.e1));
        bounds.thetaO = std::acos(std::clamp((1.0 - offset) / scale, -1.0, 1.0));
        bounds.thetaE = outer - bounds.thetaO;
    }
    return bounds;
}

// The narrowest cone about both; Conty Estevez and Kulla 2018, algorithm 1.
void UniteAxes(LightBounds& a, const LightBounds& b) {
    const double cosine = std::clamp(glm::dot(a.axis, b.axis), -1.0, 1.0);
    const double between = std::acos(cosine);
    if (std::min(between + b.thetaO, kPi) <= a.thetaO) return;
    if (std::min(between + a.thetaO, kPi) <= b.thetaO) {
        a.axis = b.axis;
        a.thetaO = b.thetaO;
        return;
    }
    const double theta = 0.5 * (a.thetaO + between + b.thetaO);
    const glm::dvec3 across = b.axis - cosine * a.axis;  // towards b, perpendicular to a
    const double length = glm::length(across);
    if (theta >= kPi || length < 1e-12) {
        a.thetaO = kPi;
        return;
    }
    const double turn = theta - a.thetaO;
    a.axis = glm::normalize(std::cos(turn) * a.axis + std::sin(turn) / length * across);
    a.thetaO = theta;
}

void Unite(LightBounds& a, const LightBounds& b) {
    if (b.IsEmpty()) return;
    if (a.IsEmpty()) {
        a = b;
        return;
    }
    a.min = glm::min(a.min, b.min);
    a.max = glm::max(a.max, b.max);
    UniteAxes(a, b);
    a.thetaE = std::max(a.thetaE, b.thetaE);
    a.power += b.power;
    a.isTwoSided |= b.isTwoSided;
}

// Power times the measure of directions times that of places. Boxes without area (points in a row) still
// differ in extent: hence the diagonal.
double Cost(const LightBounds& bounds) {
    const double o = bounds.thetaO;
    const double w = std::min(o + bounds.thetaE, kPi);
    double directions =
        2.0 * kPi * (1.0 - std::cos(o)) +
        0.5 * kPi * (2.0 * w * std::sin(o) - std::cos(o - 2.0 * w) - 2.0 * o * std::sin(o) + std::cos(o));
    if (bounds.isTwoSided) directions *= 2.0;
    const glm::dvec3 d(bounds.max - bounds.min);
    const double places = 2.0 * (d.x * d.y + d.y * d.z + d.z * d.x) + glm::dot(d, d);
    return bounds.power * directions * places;
}

// To 16 bits, never to a narrower angle, and one step beyond: a float's rounding must not exclude a light.
int16_t WidenedCosine(double angle) {
    return static_cast<int16_t>(
        std::max(std::floor(std::cos(std::min(angle, kPi)) * 32767.0) - 1.0, -32767.0));
}

gpu::LightNode NodeOf(const LightBounds& bounds, uint32_t link) {
    const auto o = static_cast<uint16_t>(WidenedCosine(bounds.thetaO));
    const auto e = static_cast<uint16_t>(WidenedCosine(bounds.thetaE));
    return {.boundsMin = bounds.min,
            .power = static_cast<float>(bounds.power),
            .boundsMax = bounds.max,
            .link = link | (bounds.isTwoSided ? gpu::kLightNodeTwoSided : 0u),
            .axis = glm::vec3(bounds.axis),
            .cones = o | (uint32_t{e} << 16u)};
}

struct Item {
    LightBounds bounds;
    glm::vec3 center{0.0f};
    uint32_t light = 0;
};

class TreeBuilder {
  public:
    explicit TreeBuilder(std::span<gpu::LightRecord> lights) : m_lights(lights) {}

    std::vector<gpu::LightNode> Build(std::vector<Item>& items) {
        if (items.empty()) return {};
        m_nodes.reserve(2 * items.size() - 1);
        m_nodes.emplace_back();
        BuildNode(0, items, 0, 0);
        return std::move(m_nodes);
    }

  private:
    LightBounds BuildNode(uint32_t node, std::span<Item> items, uint32_t depth, uint32_t trail) {
        if (items.size() == 1) {
            m_lights[items[0].light].bitTrail = trail;
            m_nodes[node] = NodeOf(items[0].bounds, gpu::kLightNodeLeaf | items[0].light);
            return items[0].bounds;
        }
        RG_CHECK_LT(depth, kMaxDepth);
        const size_t middle = Split(items, depth);
        const auto first = static_cast<uint32_t>(m_nodes.size());
        m_nodes.resize(m_nodes.size() + 2);
        LightBounds bounds = BuildNode(first, items.first(middle), depth + 1, trail);
        Unite(bounds, BuildNode(first + 1, items.subspan(middle), depth + 1, trail | (1u << depth)));
        m_nodes[node] = NodeOf(bounds, first);
        return bounds;
    }

    // Orders the items in two non-empty parts; returns the size of the first.
    static size_t Split(std::span<Item> items, uint32_t depth) {
        if (items.size() == 2) return 1;
        glm::vec3 low(std::numeric_limits<float>::infinity()), high = -low;
        for (const Item& item : items) {
            low = glm::min(low, item.center);
            high = glm::max(high, item.center);
        }
        const glm::vec3 extent = high - low;
        const int longest = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
        // Halving reaches the leaves within the depth that is left; anything else may not
        const bool mustHalve = depth + std::bit_width(items.size() - 1) >= kMaxDepth;
        if (!mustHalve && extent[longest] > 0.0f) {
            const size_t middle = SplitByCost(items, low, extent);
            if (middle > 0 && middle < items.size()) return middle;
        }
        const size_t middle = items.size() / 2;
        std::nth_element(
            items.begin(), items.begin() + static_cast<std::ptrdiff_t>(middle), items.end(),
            [longest](const Item& a, const Item& b) { return a.center[longest] < b.center[longest]; });
        return middle;
    }

    static uint32_t BucketOf(const Item& item, int axis, const glm::vec3& low, const glm::vec3& extent) {
        const float place = (item.center[axis] - low[axis]) / extent[axis] * float{kBucketCount};
        // A NaN, where the extent is beyond floats, goes to bucket 0
        return std::min(static_cast<uint32_t>(std::max(0.0f, place)), kBucketCount - 1);
    }

    static size_t SplitByCost(std::span<Item> items, const glm::vec3& low, const glm::vec3& extent) {
        const float longest = std::max({extent.x, extent.y, extent.z});
        double bestCost = std::numeric_limits<double>::infinity();
        int bestAxis = 0;
        uint32_t bestBucket = 0;  // the first of the second part
        for (int axis = 0; axis < 3; ++axis) {
            if (!(extent[axis] > 0.0f)) continue;
            std::array<LightBounds, kBucketCount> buckets;
            for (const Item& item : items) Unite(buckets[BucketOf(item, axis, low, extent)], item.bounds);
            std::array<double, kBucketCount> costBelow{};
            LightBounds below, above;
            for (uint32_t b = 1; b < kBucketCount; ++b) {
                Unite(below, buckets[b - 1]);
                costBelow[b] = Cost(below);
            }
            for (uint32_t b = kBucketCount - 1; b > 0; --b) {
                Unite(above, buckets[b]);
                const double cost = (costBelow[b] + Cost(above)) * longest / extent[axis];
                if (!above.IsEmpty() && cost < bestCost) {
                    bestCost = cost;
                    bestAxis = axis;
                    bestBucket = b;
                }
            }
        }
        const auto middle = std::partition(items.begin(), items.end(), [&](const Item& item) {
            return BucketOf(item, bestAxis, low, extent) < bestBucket;
        });
        return static_cast<size_t>(middle - items.begin());
    }

    std::span<gpu::LightRecord> m_lights;
    std::vector<gpu::LightNode> m_nodes;
};

}  // namespace

std::vector<gpu::LightNode> BuildLightTree(std::span<gpu::LightRecord> lights, std::span<const float> power) {
    RG_CHECK_EQ(lights.size(), power.size());
    std::vector<Item> items;
    for (uint32_t i = 0; i < lights.size(); ++i) {
        lights[i].bitTrail = 0;
        if (!(power[i] > 0.0f)) continue;
        Item item{.bounds = BoundsOf(lights[i], power[i]), .light = i};
        item.center = 0.5f * (item.bounds.min + item.bounds.max);
        items.push_back(item);
    }
    return TreeBuilder(lights).Build(items);
}

void RefitLightTree(std::span<gpu::LightNode> nodes, std::span<const gpu::LightRecord> lights) {
    // Children come after their parents
    for (size_t i = nodes.size(); i-- > 0;) {
        gpu::LightNode& node = nodes[i];
        const uint32_t index = node.link & gpu::kLightNodeIndex;
        if ((node.link & gpu::kLightNodeLeaf) != 0u) {
            const Box box = BoxOf(lights[index]);
            node.boundsMin = box.min;
            node.boundsMax = box.max;
        } else {
            node.boundsMin = glm::min(nodes[index].boundsMin, nodes[index + 1].boundsMin);
            node.boundsMax = glm::max(nodes[index].boundsMax, nodes[index + 1].boundsMax);
        }
    }
}

}  // namespace raygraph
