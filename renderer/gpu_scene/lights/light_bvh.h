// The light tree of shaders/lights/light_bvh.glsl, built over position, orientation and power, and refitted
// to lights that change. Needs no device. Threads: as std::vector.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "renderer/gpu_scene/lights/light_bounds.h"
#include "shaders/shared/light_records.h"

namespace raygraph {

struct LightLeaf {
    LightBounds bounds;  // power included
    uint32_t light = 0;
    glm::vec3 center{0.0f};
};

class LightTree {
  public:
    // Builds the tree, and writes the bitTrail of the leaves' records. Each light has one leaf and node 0 is
    // the root; the tree is empty if there are no leaves. Splits by the surface area orientation heuristic of
    // Conty Estevez and Kulla 2018 over buckets along each axis. Takes O(n log n); the depth is at most 32.
    void Build(std::vector<LightLeaf> leaves, std::span<gpu::LightRecord> lights);

    const std::vector<gpu::LightNode>& Nodes() const { return m_nodes; }
    bool Has(uint32_t light) const { return light < m_leafOf.size() && m_leafOf[light] != kNoNode; }
    // Sets the bounds of a light that the tree has; Refit must be called afterwards. The power may be 0.
    void Set(uint32_t light, const LightBounds& bounds);
    // Updates the nodes above the changed leaves; the topology stays. Appends all nodes that have changed to
    // `changed`, leaves included. Takes time in proportion to these, except for sorting them.
    void Refit(std::vector<uint32_t>& changed);
    // Returns the cost of a descent: the sum of Cost over all inner nodes, divided by that of the root.
    double RelativeCost() const;

  private:
    static constexpr uint32_t kNoNode = 0xFFFFFFFFu;
    // Holds the values of a node that the device does not have, or has rounded.
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
    std::vector<uint32_t> m_leafOf;  // by light: its leaf
    std::vector<uint32_t> m_set;     // leaves that were set since the last Refit
    double m_cost = 0.0;             // sum over all inner nodes
    // The highest m_cost since it was last summed up, which bounds its rounding error.
    double m_highestCost = 0.0;
};

// Builds the tree over the bounded lights (triangles, points, spots) whose power is above 0.
LightTree BuildLightTree(std::span<gpu::LightRecord> lights, std::span<const float> power);

}  // namespace raygraph
