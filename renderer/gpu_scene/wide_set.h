// The wide trees of a scene on the device (shaders/shared/wide_bvh.h): those of meshes, which stay, and the
// one over the instances; or the one over all triangles. For renderer/gpu_scene alone. Threads: that of the
// Renderer.
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

    // Takes what has come and gone since the last call, and builds the tree over the instances, or all
    // triangles, again if anything that is visible has changed. Of two levels empties the resources' trees.
    void Follow(SceneResources& resources, const InstanceSet& instances);
    // Uploads what has changed. Without trees, leaves the ids as they are.
    void Declare(Renderer& renderer, SceneIds& ids);
    // Why rays cannot be traced by them; empty: they can.
    const std::string& WhyNone() const { return m_whyNone; }
    bool HasOneLevel() const { return m_isOneLevel; }
    uint64_t Bytes() const;

  private:
    struct Range {
        uint32_t first = 0, count = 0;
    };
    // A tree in the tables.
    struct Placed {
        std::shared_ptr<WideMesh> tree;  // null: nothing
        Range nodes, triangles;
        Box box;
        uint32_t depth = 0;
    };
    // What is visible: a group of the resources, and where.
    struct Part {
        std::shared_ptr<WideMesh> tree;
        uint32_t group = 0;
        glm::mat4x3 objectToWorld{1.0f};
        uint32_t number = 0;
        uint32_t flags = 0;  // gpu::kWideBackCulled, ...

        bool operator==(const Part&) const = default;
    };

    // Nothing, and m_whyNone, where there is no tree of one of them.
    std::vector<Part> VisibleParts(const SceneResources& resources, const InstanceSet& instances);
    // False: it has too many triangles, or the tree too many levels.
    bool BuildLevel(std::span<const Part> parts);
    void BuildInstances(const SceneResources& resources, std::span<const Part> parts);
    // Leaves room for so many more nodes.
    void FollowMeshes(const SceneResources& resources, size_t spareNodes);
    void Place(Placed& placed, const std::shared_ptr<WideMesh>& tree);
    void Free(Placed& placed);
    uint32_t TakeNodes(std::vector<gpu::WideNode>& nodes, uint32_t firstPrimitive, Range& range);
    void PutInstances(std::vector<gpu::WideInstance>&& instances);

    bool m_isOneLevel;  // once there were more triangles than that takes, never again
    Placed m_level;
    bool m_isBuilt = false;
    std::vector<Part> m_parts;     // of which it was
    std::vector<Placed> m_placed;  // by group: those of two levels
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
