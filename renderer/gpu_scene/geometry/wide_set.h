// The wide trees of a scene on the device (shaders/shared/wide_bvh.h): those of meshes, which stay, and the
// one over the instances; or the one over all triangles. For renderer/gpu_scene alone. Threads: that of the
// Renderer; trees that have decayed are built again on another.
#pragma once

#include <cstdint>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "renderer/bvh/wide_refit.h"
#include "renderer/bvh/wide_scene.h"
#include "renderer/gpu_scene/device_array.h"
#include "renderer/gpu_scene/scene_ids.h"
#include "renderer/gpu_scene/slot_ranges.h"

namespace raygraph {

class InstanceSet;
struct SceneGeometry;

class WideSet {
  public:
    // `rebuildsDecayed`: a tree that has become worse because instances have moved is built again. Else trees
    // are those of the scene as it was set, with the boxes of now: a function of both, whatever came between.
    WideSet(rhi::Device& device, bool rebuildsDecayed);

    // Takes what has come, gone and moved since the last call. Where instances have only moved, the tree
    // keeps its nodes, and their boxes follow; else it is built again. Of two levels empties the geometry's
    // trees.
    void Follow(SceneGeometry& geometry, const InstanceSet& instances);
    // Uploads what has changed. Without trees, leaves the ids as they are.
    void Declare(Renderer& renderer, SceneIds& ids);
    // Why rays cannot be traced by them; empty: they can.
    const std::string& UnavailableReason() const { return m_unavailableReason; }
    bool HasOneLevel() const { return m_isOneLevel; }
    uint64_t Bytes() const;

  private:
    struct Range {
        uint32_t first = 0, count = 0;
    };
    // The tree of a mesh in the tables.
    struct Placed {
        std::shared_ptr<WideMesh> tree;  // null: nothing
        Range nodes, triangles;
        Box box;
        uint32_t depth = 0;
    };
    // What is visible: a group of the geometry, and where.
    struct Part {
        std::shared_ptr<WideMesh> tree;
        uint32_t group = 0;
        glm::mat4x3 objectToWorld{1.0f};
        uint32_t number = 0;
        uint32_t flags = 0;  // gpu::kWideBackCulled, ...

        bool operator==(const Part&) const = default;
    };
    // The tree that follows the instances: over all triangles, or over the instances.
    struct Top {
        std::vector<gpu::WideNode> nodes;  // children and primitives count from its own first ones
        WideRefit refit;
        Range inTable, triangles;            // triangles: of one level
        std::vector<uint32_t> firstEntries;  // by part: its first one in `places`; one more for the end
        std::vector<uint32_t> places;        // of a part's triangles or its instance among the primitives
        std::vector<uint32_t> sources;       // of one level, by primitive: which triangle of the part
        std::vector<Box> boxes;              // of instances, by primitive
    };
    // What is built for parts: the one or the other is there.
    struct Built {
        std::vector<Part> parts;
        WideLevel level;
        WideInstances instances;
    };

    // Of a scene whose trees stay those of the scene as it was set.
    void StoreInitialPlacements(const SceneGeometry& geometry, const InstanceSet& instances);
    // How many triangles a tree of one level may have that is built now.
    uint64_t MaxOneLevelTriangles() const;
    // Nothing, and m_unavailableReason, where there is no tree of one of them.
    std::vector<Part> VisibleParts(const SceneGeometry& geometry, const InstanceSet& instances);
    static PlacedTriangles TrianglesOf(const Part& part);
    WidePlacement PlacementOf(const Part& part) const;
    std::vector<WidePlacement> PlacementsOf(std::span<const Part> parts) const;
    // Nothing has been built so far, or m_parts cannot become these parts by moving alone.
    void Build(SceneGeometry& geometry, const std::vector<Part>& parts);
    void BuildFrom(SceneGeometry& geometry, std::vector<Part>&& parts);
    // False: that is not possible; then the tree has to be built.
    bool Refit(const std::vector<Part>& parts);
    bool MoveTriangles(const Part& part, uint32_t index, std::vector<uint32_t>& moved);
    bool MoveInstance(const Part& part, uint32_t index, std::vector<uint32_t>& moved);
    Box BoxOf(uint32_t primitive) const;
    // What has been built takes the place of the tree. False: it has too many levels.
    bool Take(Built&& built);
    // Begins to build a tree that has decayed again, if none is being built.
    void Renew();
    void FollowMeshes(const SceneGeometry& geometry, size_t spareNodes);
    void Place(Placed& placed, const std::shared_ptr<WideMesh>& tree);
    void Free(Placed& placed);
    void FreeTopLevel();
    Range StoreTriangles(std::span<const gpu::WideTriangle> triangles);
    Range StoreNodes(std::span<const gpu::WideNode> nodes, uint32_t firstPrimitive);
    void StoreNode(uint32_t place, gpu::WideNode node, uint32_t firstNode, uint32_t firstPrimitive);
    void StoreInstances(std::vector<gpu::WideInstance>&& instances);
    void ForgetAll();

    bool m_rebuildsDecayed;
    std::vector<glm::mat4x3> m_initialTransforms;  // by Part::number: where the scene had it when it was set
    bool m_hadFewTriangles = false;                // the scene as it was set, hidden ones included
    bool m_isOneLevel = true;  // once there were more triangles than that takes, never again
    bool m_isBuilt = false;
    std::vector<Part> m_parts;     // of which it was
    std::vector<Placed> m_placed;  // by group: those of two levels
    Top m_top;
    std::future<Built> m_future;
    SlotRanges m_nodeSlots, m_triangleSlots;
    DeviceArray<gpu::WideNode> m_nodes;
    DeviceArray<gpu::WideTriangle> m_triangles;
    DeviceArray<gpu::WideInstance> m_instances;
    uint64_t m_version = 0;    // of the instances
    bool m_hasFailed = false;  // for good: there was no memory
    std::string m_unavailableReason;
};

}  // namespace raygraph
