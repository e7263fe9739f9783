// The wide trees of a scene on the device (shaders/shared/wide_bvh.h): those of meshes, which stay, and the
// one over the instances. For renderer/gpu_scene alone. Threads: that of the Renderer.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "renderer/bvh/wide_scene.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/gpu_scene/growing_table.h"
#include "renderer/gpu_scene/slot_ranges.h"

namespace raygraph {

class InstanceSet;
struct SceneResources;

class WideSet {
  public:
    // `prefersOneLevel`: see GpuSceneDesc.
    WideSet(rhi::Device& device, bool prefersOneLevel);

    // Takes what has come and gone since the last call, and builds the tree over the instances again if
    // anything of them has changed. Empties trees of the resources that it takes.
    void Follow(SceneResources& resources, const InstanceSet& instances);
    // Uploads what has changed. Without trees, leaves the ids as they are.
    void Declare(Renderer& renderer, SceneIds& ids);
    // Why rays cannot be traced by them; empty: they can.
    const std::string& WhyNone() const { return m_whyNone; }
    bool HasOneLevel() const { return m_level.tree != nullptr; }
    uint64_t Bytes() const;

  private:
    struct Range {
        uint32_t first = 0, count = 0;
    };
    // Of a group of the resources.
    struct Placed {
        std::shared_ptr<WideMesh> tree;  // null: nothing
        Range nodes, triangles;
        Box box;
        uint32_t depth = 0;
    };

    // True if something has changed. Leaves room for so many nodes.
    bool FollowMeshes(SceneResources& resources, size_t spareNodes);
    void Place(Placed& placed, const std::shared_ptr<WideMesh>& tree);
    void Free(Placed& placed);
    void FollowInstances(const SceneResources& resources, const InstanceSet& instances);
    void BuildLevel(std::span<const WidePlacement> placements, std::span<const uint32_t> groups);
    void BuildInstances(std::span<const WidePlacement> placements);
    uint32_t TakeNodes(std::vector<gpu::WideNode>& nodes, uint32_t firstPrimitive, Range& range);

    std::vector<Placed> m_placed;  // by group
    Placed m_level;                // over the triangles of all instances
    bool m_prefersOneLevel;
    SlotRanges m_nodeSlots, m_triangleSlots;
    Range m_instanceNodes;
    std::vector<gpu::WideNode> m_nodes;
    std::vector<gpu::WideTriangle> m_triangles;
    std::vector<gpu::WideInstance> m_instances;
    GrowingTable m_nodeTable, m_triangleTable, m_instanceTable;
    uint64_t m_version = 0;    // of the instances
    bool m_hasFailed = false;  // for good: there was no memory
    std::string m_whyNone;
};

}  // namespace raygraph
