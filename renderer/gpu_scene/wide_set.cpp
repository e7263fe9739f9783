#include "renderer/gpu_scene/wide_set.h"

#include <algorithm>
#include <exception>
#include <new>
#include <span>
#include <stdexcept>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "renderer/gpu_scene/instance_set.h"
#include "renderer/gpu_scene/scene_resources.h"

namespace raygraph {
namespace {

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

// No memory, or a table that no shader can bind.
bool IsTooLarge(const std::exception& error) {
    if (const auto* known = dynamic_cast<const Error*>(&error))
        return known->Kind() == ErrorKind::OutOfMemory || known->Kind() == ErrorKind::Usage;
    return dynamic_cast<const std::bad_alloc*>(&error) || dynamic_cast<const std::length_error*>(&error);
}

}  // namespace

WideSet::WideSet(rhi::Device& device, bool prefersOneLevel)
    : m_isOneLevel(prefersOneLevel),
      m_nodeTable(device, "wideNodes", "UploadWideNodes", sizeof(gpu::WideNode)),
      m_triangleTable(device, "wideTriangles", "UploadWideTriangles", sizeof(gpu::WideTriangle)),
      m_instanceTable(device, "wideInstances", "UploadWideInstances", sizeof(gpu::WideInstance)) {}

void WideSet::Follow(SceneResources& resources, const InstanceSet& instances) {
    if (m_hasFailed || m_version == instances.Version()) return;
    try {
        std::vector<Part> parts = VisibleParts(resources, instances);
        m_version = instances.Version();
        if (!m_whyNone.empty() || (m_isBuilt && parts == m_parts)) return;
        if (m_isOneLevel) m_isOneLevel = BuildLevel(parts);
        if (!m_isOneLevel) BuildInstances(resources, parts);
        m_isBuilt = m_whyNone.empty();
        m_parts = std::move(parts);
    } catch (const std::exception& error) {
        if (!IsTooLarge(error)) throw;
        // Frames in flight may still read what there was
        m_whyNone = error.what();
        m_hasFailed = true;
        m_nodes = {};
        m_triangles = {};
        m_instances = {};
        m_placed = {};
        m_level = {};
        m_parts = {};
    }
}

std::vector<WideSet::Part> WideSet::VisibleParts(const SceneResources& resources,
                                                 const InstanceSet& instances) {
    m_whyNone.clear();
    std::vector<Part> parts;
    const std::span<const InstanceSet::Placement> all = instances.Placements();
    for (uint32_t i = 0; i < all.size(); ++i) {
        if (all[i].group == InstanceSet::kNoGroup || !instances.IsVisible(all[i].instance)) continue;
        const GroupResources& group = resources.groups[all[i].group];
        if (!group.tree) {
            m_whyNone = "the scene has round primitives, meshes that deform, or others without a tree";
            return {};
        }
        parts.push_back({.tree = group.tree,
                         .group = all[i].group,
                         .objectToWorld = instances.DeviceTransform(all[i].instance),
                         .number = i,
                         .flags = FlagsOf(group.kind)});
    }
    return parts;
}

bool WideSet::BuildLevel(std::span<const Part> parts) {
    std::vector<PlacedTriangles> placed;
    uint64_t count = 0;
    for (const Part& part : parts) {
        placed.push_back({.triangles = part.tree->triangles,
                          .objectToWorld = part.objectToWorld,
                          .number = part.number,
                          .flags = part.flags});
        count += part.tree->triangles.size();
    }
    if (m_level.tree) Free(m_level);
    if (count > kMaxLevelTriangles) return false;
    const auto tree = std::make_shared<WideMesh>(BuildWideLevel(placed));
    if (tree->depth > kMaxMeshDepth) return false;
    Place(m_level, tree);
    PutInstances({{.root = m_level.nodes.first}});
    return true;
}

void WideSet::BuildInstances(const SceneResources& resources, std::span<const Part> parts) {
    // There are no more nodes above instances than instances, or one
    FollowMeshes(resources, parts.size() + 1);
    if (!m_whyNone.empty()) return;
    std::vector<WidePlacement> placements;
    for (const Part& part : parts) {
        const Placed& placed = m_placed[part.group];
        if (placed.depth > kMaxMeshDepth) {
            m_whyNone = Text("a mesh has a tree of {} levels, of {} at most", placed.depth, kMaxMeshDepth);
            return;
        }
        placements.push_back({.objectToWorld = part.objectToWorld,
                              .box = placed.box,
                              .root = placed.nodes.first,
                              .number = part.number,
                              .flags = part.flags});
    }
    WideInstances tree = BuildWideInstances(placements);
    if (tree.depth > kMaxInstanceDepth) {
        m_whyNone =
            Text("the instances have a tree of {} levels, of {} at most", tree.depth, kMaxInstanceDepth);
        return;
    }
    m_nodeSlots.Free(m_instanceNodes.first, std::exchange(m_instanceNodes.count, 0));
    tree.instances[0].root = TakeNodes(tree.nodes, 0, m_instanceNodes);
    PutInstances(std::move(tree.instances));
}

void WideSet::FollowMeshes(const SceneResources& resources, size_t spareNodes) {
    m_placed.resize(std::max(m_placed.size(), resources.groups.size()));
    const auto treeOf = [&](size_t i) {
        return i < resources.groups.size() ? resources.groups[i].tree : std::shared_ptr<WideMesh>();
    };
    size_t nodes = 0, triangles = 0;
    for (size_t i = 0; i < m_placed.size(); ++i) {
        const std::shared_ptr<WideMesh> tree = treeOf(i);
        if (m_placed[i].tree == tree) continue;
        Free(m_placed[i]);
        if (!tree) continue;
        if (tree->nodes.empty()) BuildTree(*tree);
        if (tree->nodes.empty()) {
            m_whyNone = "a mesh reaches too far for a tree";
            return;
        }
        nodes += tree->nodes.size();
        triangles += tree->triangles.size();
    }
    m_nodeTable.Reserve(m_nodeSlots.End() + nodes + spareNodes);
    m_triangleTable.Reserve(m_triangleSlots.End() + triangles);
    for (size_t i = 0; i < m_placed.size(); ++i)
        if (const std::shared_ptr<WideMesh> tree = treeOf(i); tree != m_placed[i].tree)
            Place(m_placed[i], tree);
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

void WideSet::PutInstances(std::vector<gpu::WideInstance>&& instances) {
    m_instanceTable.Reserve(instances.size());
    m_instances = std::move(instances);
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
