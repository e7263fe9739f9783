#include "renderer/gpu_scene/wide_set.h"

#include <algorithm>
#include <exception>
#include <span>
#include <utility>

#include "base/text.h"
#include "renderer/gpu_scene/instance_set.h"
#include "renderer/gpu_scene/scene_resources.h"

namespace raygraph {
namespace {

// A tree over more triangles takes longer to build than it saves: half a second.
constexpr size_t kMaxLevelTriangles = 1 << 19;

// Memory for a table of so many records, which are all there.
template <typename T>
void Grow(std::vector<T>& records, GrowingTable& table, size_t count) {
    if (count > records.size()) {
        table.Reserve(count);
        records.resize(count);
    }
}

uint32_t FlagsOf(const GroupKind& kind) {
    const bool isTested = !kind.isOpaque || kind.isThinWall;
    return (kind.isBackCulled ? gpu::kWideBackCulled : 0u) | (isTested ? gpu::kWideTested : 0u);
}

}  // namespace

WideSet::WideSet(rhi::Device& device, bool prefersOneLevel)
    : m_prefersOneLevel(prefersOneLevel),
      m_nodeTable(device, "wideNodes", "UploadWideNodes", sizeof(gpu::WideNode)),
      m_triangleTable(device, "wideTriangles", "UploadWideTriangles", sizeof(gpu::WideTriangle)),
      m_instanceTable(device, "wideInstances", "UploadWideInstances", sizeof(gpu::WideInstance)) {}

void WideSet::Follow(SceneResources& resources, const InstanceSet& instances) {
    if (m_hasFailed) return;
    try {
        // There are no more nodes above instances than instances, or one
        const bool areMeshesChanged = FollowMeshes(resources, instances.Placements().size() + 1);
        if (!areMeshesChanged && m_version == instances.Version()) return;
        m_whyNone.clear();
        FollowInstances(resources, instances);
        m_version = instances.Version();
    } catch (const std::exception& error) {
        // No memory, or a table that no shader can bind. Frames in flight may still read what there was
        m_whyNone = error.what();
        m_hasFailed = true;
        m_nodes = {};
        m_triangles = {};
        m_instances = {};
        m_placed = {};
        m_level = {};
    }
}

bool WideSet::FollowMeshes(SceneResources& resources, size_t spareNodes) {
    bool isChanged = false;
    m_placed.resize(std::max(m_placed.size(), resources.groups.size()));
    const auto treeOf = [&](size_t i) {
        return i < resources.groups.size() ? resources.groups[i].tree : std::shared_ptr<WideMesh>();
    };
    for (size_t i = 0; i < m_placed.size(); ++i) {
        if (m_placed[i].tree == treeOf(i)) continue;
        isChanged = true;
        Free(m_placed[i]);
    }
    size_t nodes = 0, triangles = 0;
    for (size_t i = 0; i < m_placed.size(); ++i)
        if (const std::shared_ptr<WideMesh> tree = treeOf(i); tree && tree != m_placed[i].tree) {
            nodes += tree->nodes.size();
            triangles += tree->triangles.size();
        }
    if (!isChanged) return false;
    m_nodeTable.Reserve(m_nodeSlots.End() + nodes + spareNodes);
    m_triangleTable.Reserve(m_triangleSlots.End() + triangles);
    for (size_t i = 0; i < m_placed.size(); ++i)
        if (const std::shared_ptr<WideMesh> tree = treeOf(i); tree != m_placed[i].tree)
            Place(m_placed[i], tree);
    return true;
}

void WideSet::Place(Placed& placed, const std::shared_ptr<WideMesh>& tree) {
    placed.box = tree->box;
    placed.depth = tree->depth;
    const auto count = static_cast<uint32_t>(tree->triangles.size());
    placed.triangles = {m_triangleSlots.Allocate(count), count};
    Grow(m_triangles, m_triangleTable, m_triangleSlots.End());
    std::ranges::copy(tree->triangles, m_triangles.begin() + placed.triangles.first);
    m_triangleTable.Mark(placed.triangles.first, count);
    TakeNodes(tree->nodes, placed.triangles.first, placed.nodes);
    tree->triangles = {};
    tree->nodes = {};
    placed.tree = tree;
}

uint32_t WideSet::TakeNodes(std::vector<gpu::WideNode>& nodes, uint32_t firstPrimitive, Range& range) {
    const auto count = static_cast<uint32_t>(nodes.size());
    range = {m_nodeSlots.Allocate(count), count};
    Grow(m_nodes, m_nodeTable, m_nodeSlots.End());
    MoveNodes(nodes, range.first, firstPrimitive);
    std::ranges::copy(nodes, m_nodes.begin() + range.first);
    m_nodeTable.Mark(range.first, count);
    return range.first;
}

void WideSet::Free(Placed& placed) {
    m_nodeSlots.Free(placed.nodes.first, placed.nodes.count);
    m_triangleSlots.Free(placed.triangles.first, placed.triangles.count);
    placed = {};
}

void WideSet::FollowInstances(const SceneResources& resources, const InstanceSet& instances) {
    std::vector<WidePlacement> placements;
    std::vector<uint32_t> groups;  // of these
    size_t triangles = 0;
    const std::span<const InstanceSet::Placement> all = instances.Placements();
    for (uint32_t i = 0; i < all.size(); ++i) {
        if (all[i].group == InstanceSet::kNoGroup || !instances.IsVisible(all[i].instance)) continue;
        const Placed& placed = m_placed[all[i].group];
        if (!placed.tree) {
            m_whyNone = "the scene has round primitives, meshes that deform, or others without a tree";
            return;
        }
        if (placed.depth > kMaxMeshDepth) {
            m_whyNone = Text("a mesh has a tree of {} levels, of {} at most", placed.depth, kMaxMeshDepth);
            return;
        }
        placements.push_back({.objectToWorld = instances.DeviceTransform(all[i].instance),
                              .box = placed.box,
                              .root = placed.nodes.first,
                              .number = i,
                              .flags = FlagsOf(resources.groups[all[i].group].kind)});
        groups.push_back(all[i].group);
        triangles += placed.triangles.count;
    }
    if (m_level.tree) Free(m_level);
    if (m_prefersOneLevel && triangles <= kMaxLevelTriangles)
        BuildLevel(placements, groups);
    else
        BuildInstances(placements);
}

void WideSet::BuildLevel(std::span<const WidePlacement> placements, std::span<const uint32_t> groups) {
    std::vector<PlacedTriangles> placed;
    for (size_t i = 0; i < placements.size(); ++i) {
        const Range& range = m_placed[groups[i]].triangles;
        placed.push_back({.triangles = std::span(m_triangles).subspan(range.first, range.count),
                          .objectToWorld = placements[i].objectToWorld,
                          .number = placements[i].number,
                          .flags = placements[i].flags});
    }
    const auto tree = std::make_shared<WideMesh>(BuildWideLevel(placed));
    if (tree->depth > kMaxMeshDepth) {
        BuildInstances(placements);
        return;
    }
    Place(m_level, tree);
    m_instanceTable.Reserve(1);
    m_instances.assign(1, {.root = m_level.nodes.first});
    m_instanceTable.Mark(0, 1);
}

void WideSet::BuildInstances(std::span<const WidePlacement> placements) {
    WideInstances tree = BuildWideInstances(placements);
    if (tree.depth > kMaxInstanceDepth) {
        m_whyNone =
            Text("the instances have a tree of {} levels, of {} at most", tree.depth, kMaxInstanceDepth);
        return;
    }
    m_nodeSlots.Free(m_instanceNodes.first, std::exchange(m_instanceNodes.count, 0));
    tree.instances[0].root = TakeNodes(tree.nodes, 0, m_instanceNodes);
    m_instanceTable.Reserve(tree.instances.size());
    m_instances = std::move(tree.instances);
    m_instanceTable.Mark(0, static_cast<uint32_t>(m_instances.size()));
}

void WideSet::Declare(Renderer& renderer, SceneIds& ids) {
    if (!m_whyNone.empty()) return;
    ids.hasOneWideLevel = HasOneLevel();
    ids.wideNodes = m_nodeTable.Declare(renderer, std::as_bytes(std::span<const gpu::WideNode>(m_nodes)));
    ids.wideTriangles =
        m_triangleTable.Declare(renderer, std::as_bytes(std::span<const gpu::WideTriangle>(m_triangles)));
    ids.wideInstances =
        m_instanceTable.Declare(renderer, std::as_bytes(std::span<const gpu::WideInstance>(m_instances)));
}

uint64_t WideSet::Bytes() const {
    return m_nodeTable.Buffer().Size() + m_triangleTable.Buffer().Size() + m_instanceTable.Buffer().Size();
}

}  // namespace raygraph
