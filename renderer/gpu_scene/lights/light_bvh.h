// The light tree of shaders/lights/light_bvh.glsl: built over position, orientation and power, and refitted
// to lights that change. Needs no device.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/gpu_scene/lights/light_bounds.h"
#include "shaders/shared/light_records.h"

namespace raygraph {

struct LightLeaf {
    LightBounds bounds;  // with power
    uint32_t light = 0;
    glm::vec3 center{0.0f};
};

class LightTree {
  public:
    // Builds the tree, and writes the bitTrail of the leaves' records. One leaf a light, node 0 the root;
    // empty if there are no leaves. Splits by the surface area orientation heuristic of Conty Estevez and
    // Kulla 2018 over buckets along each axis; O(n log n), depth at most 32.
    void Build(std::vector<LightLeaf> leaves, std::span<gpu::LightRecord> lights);

    const std::vector<gpu::LightNode>& Nodes() const { return m_nodes; }
    bool Has(uint32_t light) const { return light < m_leafOf.size() && m_leafOf[light] != kNoNode; }
    // The light, which the tree has, is now within these bounds; Refit has to follow. Power may be 0.
    void Set(uint32_t light, const LightBounds& bounds);
    // Brings the nodes above up to date; their order stays. Appends those that have changed, leaves as well.
    // Takes time in proportion to these, but for their sorting.
    void Refit(std::vector<uint32_t>& changed);
    // What a descent costs: the sum of Cost over all inner nodes, over that of the root.
    double RelativeCost() const;

  private:
    static constexpr uint32_t kNoNode = 0xFFFFFFFFu;
    // What the node on the device does not have, or has rounded.
    struct Rest {
        float thetaO = 0.0f;
        float thetaE = 0.0f;
        uint32_t parent = kNoNode;
    };
    class Builder;

    LightBounds BoundsAt(uint32_t node) const;
    void Write(uint32_t node, const LightBounds& bounds, uint32_t link);
    double InnerCost(uint32_t node) const;
    void SumCosts();

    std::vector<gpu::LightNode> m_nodes;
    std::vector<Rest> m_rest;
    std::vector<uint32_t> m_leafOf;  // by light
    std::vector<uint32_t> m_set;     // leaves, since the last Refit
    double m_cost = 0.0;             // of all inner nodes
    double m_highestCost = 0.0;      // since they were summed up: how much m_cost has lost in rounding
};

// The tree over the bounded lights (triangles, points, spots) whose power is above 0.
LightTree BuildLightTree(std::span<gpu::LightRecord> lights, std::span<const float> power);

}  // namespace raygraph
