// WideSet: the wide BVHs of a scene on the device (shaders/shared/wide_bvh.h). In two levels, these are one
// BVH per mesh, which does not change, and one over the instances; in one level, a single BVH is over all
// triangles. BoxTree models the driver's TLAS. For renderer/gpu_scene alone. Threads: WideSet: that of the
// Renderer, while a BVH that has decayed is rebuilt on another thread; BoxTree: as std::vector.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <future>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/large_pages.h"
#include "renderer/bvh/wide_bvh.h"
#include "renderer/bvh/wide_scene.h"
#include "renderer/gpu_scene/device_array.h"
#include "renderer/gpu_scene/record_table.h"
#include "renderer/gpu_scene/scene_ids.h"
#include "renderer/scene/model/mesh_data.h"

namespace raygraph {

class InstanceSet;
struct GroupKind;
struct SceneGeometry;

// Returns the flags of a group's triangles: gpu::kWideBackCulled, ...
uint32_t WideFlagsOf(const GroupKind& kind);

class WideSet {
  public:
    // `rebuildsDecayed`: a BVH that has decayed because instances have moved is rebuilt. Otherwise its
    // topology is that of the scene as it was set, and only its boxes follow, so that it is a function of
    // both alone, whatever poses came between.
    WideSet(rhi::Device& device, bool rebuildsDecayed);

    // Follows the changes since the last call. Where instances have only moved, the tree keeps its nodes and
    // their boxes are refitted; otherwise it is rebuilt. With two levels, this moves the trees out of the
    // geometry.
    void Follow(SceneGeometry& geometry, const InstanceSet& instances);
    // Uploads the changes and sets the ids. Without trees, the ids do not change.
    void Declare(Renderer& renderer, SceneIds& ids);
    // Says why rays cannot be traced by the trees; empty if they can be.
    const std::string& UnavailableReason() const { return m_unavailableReason; }
    bool HasOneLevel() const { return m_isOneLevel; }
    uint64_t Bytes() const;

  private:
    struct Range {
        uint32_t first = 0, count = 0;
    };
    // Holds the position of a mesh's tree in the tables.
    struct Placed {
        std::shared_ptr<WideMesh> tree;  // null: the group has no tree
        Range nodes, triangles;
        Box box;
        uint32_t depth = 0;
    };
    // Describes a visible placement of a group of the geometry.
    struct Part {
        std::shared_ptr<WideMesh> tree;
        uint32_t group = 0;
        glm::mat4x3 objectToWorld{1.0f};
        uint32_t number = 0;
        uint32_t flags = 0;  // gpu::kWideBackCulled, ...

        bool operator==(const Part&) const = default;
    };
    // Holds the tree that follows the instances: over all triangles (one level), or over the instances (two
    // levels).
    struct Top {
        // Indices of children and primitives count from the tree's own first ones.
        std::vector<gpu::WideNode> nodes;
        WideRefit refit;
        Range inTable, triangles;            // `triangles` is used with one level
        std::vector<uint32_t> firstEntries;  // by part: its first entry in `places`; one more at the end
        // Positions of a part's triangles, or of its instance, among the primitives.
        std::vector<uint32_t> places;
        // With one level, by primitive: the index of the triangle in its part.
        std::vector<uint32_t> sources;
        std::vector<Box> boxes;  // with two levels, by primitive: the instance's box
    };
    // Holds the result of a build: exactly one of the two is set.
    struct Built {
        std::vector<Part> parts;
        WideLevel level;
        WideInstances instances;
    };

    // Stores where the scene has its instances when it is set, for trees that keep their topology.
    void StoreInitialPlacements(const SceneGeometry& geometry, const InstanceSet& instances);
    // Returns the largest number of triangles for which a tree of one level may be built now.
    uint64_t MaxOneLevelTriangles() const;
    // Returns the visible parts. If one of them has no tree, returns none and sets m_unavailableReason.
    std::vector<Part> VisibleParts(const SceneGeometry& geometry, const InstanceSet& instances);
    static PlacedTriangles TrianglesOf(const Part& part);
    WidePlacement PlacementOf(const Part& part) const;
    std::vector<WidePlacement> PlacementsOf(std::span<const Part> parts) const;
    // Builds the trees, which is needed at first and where m_parts cannot become `parts` by moving alone.
    void Build(SceneGeometry& geometry, const std::vector<Part>& parts);
    void BuildFrom(SceneGeometry& geometry, std::vector<Part>&& parts);
    // Refits the boxes. Returns false if that is not possible and the tree has to be built.
    bool Refit(const std::vector<Part>& parts);
    bool MoveTriangles(const Part& part, uint32_t index, std::vector<uint32_t>& moved);
    bool MoveInstance(const Part& part, uint32_t index, std::vector<uint32_t>& moved);
    Box BoxOf(uint32_t primitive) const;
    // Replaces the tree by the one that has been built. Returns false if that has too many levels.
    bool Take(Built&& built);
    // Starts to rebuild a tree that has decayed, unless a rebuild is running.
    void StartRebuild();
    void FollowMeshes(const SceneGeometry& geometry, size_t spareNodes);
    void Place(Placed& placed, const std::shared_ptr<WideMesh>& tree);
    void Free(Placed& placed);
    void FreeTopLevel();
    Range StoreTriangles(std::span<const gpu::WideTriangle> triangles);
    Range StoreNodes(std::span<const gpu::WideNode> nodes, uint32_t firstPrimitive);
    void StoreNode(uint32_t place, gpu::WideNode node, uint32_t firstNode, uint32_t firstPrimitive);
    void StoreInstances(std::vector<gpu::WideInstance>&& instances);
    void ReleaseAll();

    bool m_rebuildsDecayed;
    std::vector<glm::mat4x3> m_initialTransforms;  // by Part::number: transforms when the scene was set
    bool m_hadFewTriangles = false;                // the scene as it was set, hidden instances included
    bool m_isOneLevel = true;  // false once the scene had more triangles than one level takes; it stays false
    bool m_isBuilt = false;
    std::vector<Part> m_parts;     // the parts for which the tree was built
    std::vector<Placed> m_placed;  // by group, with two levels
    Top m_top;
    std::future<Built> m_future;
    SlotRanges m_nodeSlots, m_triangleSlots;
    DeviceArray<gpu::WideNode> m_nodes;
    DeviceArray<gpu::WideTriangle> m_triangles;
    DeviceArray<gpu::WideInstance> m_instances;
    uint64_t m_version = 0;    // version of the instances
    bool m_hasFailed = false;  // permanent: memory ran out
    std::string m_unavailableReason;
};

// BoxTree: a balanced tree of boxes over leaves in a fixed order. It models the tree that a driver has built
// over the instances of a TLAS and has only updated since then: the order is the same, and each box fits
// what is below it now. The time of a change is in proportion to the number of leaves that have changed.
class BoxTree {
  public:
    static constexpr size_t kChildren = 8;

    // Replaces all leaves. Empty boxes are legal and are ignored.
    void Assign(std::span<const scene::Bounds> leaves);
    // Appends empty leaves up to `leafCount`. On an exception nothing has changed.
    void Grow(size_t leafCount);
    // The boxes above the leaf are updated by Refresh.
    void Set(size_t leaf, const scene::Bounds& box) noexcept;
    void Refresh() noexcept;
    // Fetches into the cache what the next Set of this leaf, and Refresh, will read.
    void Prefetch(size_t leaf) const {
        const auto* const family = reinterpret_cast<const char*>(&m_levels[0].families[leaf / kChildren]);
        for (size_t byte = 0; byte < sizeof(Family); byte += 64) __builtin_prefetch(family + byte);
    }

    size_t LeafCount() const { return m_levels.empty() ? 0 : m_levels[0].count; }
    // Returns the number of leaves that are not empty.
    size_t BoxCount() const { return m_boxCount; }
    // Returns the box around all leaves.
    scene::Bounds Root() const;
    // Returns the box around all leaves but these few, which may be in any order.
    scene::Bounds AroundAllBut(std::vector<size_t> leaves) const;
    // Returns the sum of the surface areas of the boxes between the leaves and the root, which is
    // proportional to how many of them a random ray meets. Another order of the leaves would change these
    // boxes alone. Each box stores the sum of what is below it, so that rounding errors do not accumulate
    // over changes.
    double Cost() const { return m_levels.size() < 2 ? 0.0 : m_levels[m_levels.size() - 2].CostOf(0); }

  private:
    // Holds the boxes of one parent. Missing children have empty boxes.
    struct alignas(64) Family {
        std::array<scene::Bounds, kChildren> boxes;
        scene::Bounds Around() const;
    };
    struct Level {
        size_t count = 0;  // number of boxes
        LargeArray<Family> families;
        std::vector<double> costs;     // by box: its area plus those of all boxes below it; empty for leaves
        std::vector<uint32_t> due;     // families with a changed box; its capacity is the number of families
        std::vector<uint8_t> isDirty;  // by family: whether it is listed in `due`
        scene::Bounds& Box(size_t i) { return families[i / kChildren].boxes[i % kChildren]; }
        const scene::Bounds& Box(size_t i) const { return families[i / kChildren].boxes[i % kChildren]; }
        double CostOf(size_t family) const;  // sum over the family's boxes
        void MarkDirty(size_t family) noexcept;
        void Reserve(size_t boxes);
        void Resize(size_t boxes, bool isLeaves);  // within the reserved capacity
    };

    std::vector<Level> m_levels;  // the leaves are first, the root is last
    size_t m_boxCount = 0;
};

}  // namespace raygraph
