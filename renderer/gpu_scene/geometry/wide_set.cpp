#include "renderer/gpu_scene/geometry/wide_set.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <glm/glm.hpp>
#include <limits>
#include <new>
#include <numeric>
#include <span>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/text.h"
#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "renderer/gpu_scene/instances/instance_set.h"

namespace raygraph {
namespace {

// A tree is rebuilt when a ray costs more than this factor times the cost after the last build.
constexpr double kRebuildDecay = 1.3;

// Tells whether memory ran out, or a table is too large for a shader to bind.
bool IsTooLarge(const std::exception& error) {
    if (const auto* known = dynamic_cast<const Error*>(&error))
        return known->Kind() == ErrorKind::OutOfMemory || known->Kind() == ErrorKind::Usage;
    return dynamic_cast<const std::bad_alloc*>(&error) || dynamic_cast<const std::length_error*>(&error);
}

}  // namespace

uint32_t WideFlagsOf(const GroupKind& kind) {
    const bool isTested = !kind.isOpaque || kind.isThinWall;
    return (kind.isBackCulled ? gpu::kWideBackCulled : 0u) | (isTested ? gpu::kWideTested : 0u);
}

WideSet::WideSet(rhi::Device& device, bool rebuildsDecayed)
    : m_rebuildsDecayed(rebuildsDecayed),
      m_nodes(device, "wideNodes", "UploadWideNodes"),
      m_triangles(device, "wideTriangles", "UploadWideTriangles"),
      m_instances(device, "wideInstances", "UploadWideInstances") {}

void WideSet::Follow(SceneGeometry& geometry, const InstanceSet& instances) {
    const bool isBuildReady =
        m_future.valid() && m_future.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    if (m_hasFailed || (m_version == instances.Version() && !isBuildReady)) return;
    try {
        if (!m_rebuildsDecayed && m_initialTransforms.empty()) StoreInitialPlacements(geometry, instances);
        std::vector<Part> parts = VisibleParts(geometry, instances);
        m_version = instances.Version();
        if (!m_unavailableReason.empty()) return;
        if (isBuildReady) {
            Built built = m_future.get();
            const bool isCurrent = std::ranges::equal(built.parts, parts, [](const Part& a, const Part& b) {
                return a.tree == b.tree && a.number == b.number && a.flags == b.flags;
            });
            if (isCurrent) Take(std::move(built));
        }
        if (m_isBuilt && parts == m_parts) return;
        if (!m_isBuilt || !Refit(parts)) return Build(geometry, parts);
        m_parts = std::move(parts);
        if (m_rebuildsDecayed && m_top.refit.Decay() > kRebuildDecay) StartRebuild();
    } catch (const std::exception& error) {
        if (!IsTooLarge(error)) throw;
        // Frames in flight may still read the old tables
        m_unavailableReason = error.what();
        m_hasFailed = true;
        ReleaseAll();
    }
}

void WideSet::StoreInitialPlacements(const SceneGeometry& geometry, const InstanceSet& instances) {
    uint64_t triangles = 0;
    for (const InstanceSet::Placement& placement : instances.Placements()) {
        glm::mat4x3& placed = m_initialTransforms.emplace_back(1.0f);
        if (placement.group == InstanceSet::kNoGroup) continue;
        placed = instances.DeviceTransform(placement.instance);
        if (const auto& tree = geometry.groups[placement.group].tree) triangles += tree->triangles.size();
    }
    m_hadFewTriangles = triangles <= kMaxLevelTriangles;
}

uint64_t WideSet::MaxOneLevelTriangles() const {
    if (!m_rebuildsDecayed) return m_hadFewTriangles ? std::numeric_limits<uint64_t>::max() : 0;
    return m_isBuilt ? kMaxRebuiltTriangles : kMaxLevelTriangles;
}

void WideSet::ReleaseAll() {
    m_nodes.Clear();
    m_triangles.Clear();
    m_instances.Clear();
    m_placed = {};
    m_top = {};
    m_parts = {};
}

std::vector<WideSet::Part> WideSet::VisibleParts(const SceneGeometry& geometry,
                                                 const InstanceSet& instances) {
    m_unavailableReason.clear();
    std::vector<Part> parts;
    const std::span<const InstanceSet::Placement> all = instances.Placements();
    for (uint32_t i = 0; i < all.size(); ++i) {
        if (all[i].group == InstanceSet::kNoGroup || !instances.IsVisible(all[i].instance)) continue;
        const GroupResources& group = geometry.groups[all[i].group];
        if (!group.tree) {
            m_unavailableReason =
                "the scene has round primitives, meshes that deform, or others without a tree";
            return {};
        }
        parts.push_back({.tree = group.tree,
                         .group = all[i].group,
                         .objectToWorld = instances.DeviceTransform(all[i].instance),
                         .number = i,
                         .flags = WideFlagsOf(group.kind)});
    }
    return parts;
}

PlacedTriangles WideSet::TrianglesOf(const Part& part) {
    return {.triangles = part.tree->triangles,
            .objectToWorld = part.objectToWorld,
            .number = part.number,
            .flags = part.flags};
}

WidePlacement WideSet::PlacementOf(const Part& part) const {
    const Placed& placed = m_placed[part.group];
    return {.objectToWorld = part.objectToWorld,
            .box = placed.box,
            .root = placed.nodes.first,
            .number = part.number,
            .flags = part.flags};
}

std::vector<WidePlacement> WideSet::PlacementsOf(std::span<const Part> parts) const {
    std::vector<WidePlacement> placements;
    for (const Part& part : parts) placements.push_back(PlacementOf(part));
    return placements;
}

void WideSet::Build(SceneGeometry& geometry, const std::vector<Part>& parts) {
    std::vector<Part> asSet = parts;
    for (Part& part : asSet)
        if (part.number < m_initialTransforms.size()) part.objectToWorld = m_initialTransforms[part.number];
    BuildFrom(geometry, std::move(asSet));
    if (!m_unavailableReason.empty() || m_parts == parts) return;
    if (Refit(parts))
        m_parts = parts;
    else
        BuildFrom(geometry, std::vector(parts));
}

void WideSet::BuildFrom(SceneGeometry& geometry, std::vector<Part>&& parts) {
    m_future = {};  // waits for the thread that reads the triangles of parts
    if (m_isOneLevel) {
        uint64_t count = 0;
        std::vector<PlacedTriangles> placed;
        for (const Part& part : parts) {
            placed.push_back(TrianglesOf(part));
            count += part.tree->triangles.size();
        }
        FreeTopLevel();
        m_isOneLevel = count <= MaxOneLevelTriangles() &&
                       Take({.parts = parts, .level = BuildWideLevel(placed), .instances = {}});
    }
    m_isBuilt = true;
    if (m_isOneLevel) return;
    // The number of nodes above the instances is at most that of the instances, or one
    FollowMeshes(geometry, parts.size() + 1);
    for (size_t i = 0; m_unavailableReason.empty() && i < parts.size(); ++i)
        if (const uint32_t depth = m_placed[parts[i].group].depth; depth > kMaxMeshDepth)
            m_unavailableReason = Text("a mesh has a tree of {} levels, of {} at most", depth, kMaxMeshDepth);
    if (!m_unavailableReason.empty()) {
        m_isBuilt = false;
        return;
    }
    WideInstances tree = BuildWideInstances(PlacementsOf(parts));
    const uint32_t depth = tree.depth;
    if (Take({.parts = std::move(parts), .level = {}, .instances = std::move(tree)})) return;
    m_isBuilt = false;
    m_unavailableReason =
        Text("the instances have a tree of {} levels, of {} at most", depth, kMaxInstanceDepth);
}

bool WideSet::Take(Built&& built) {
    const bool isOneLevel = built.instances.instances.empty();
    if (isOneLevel ? built.level.mesh.depth > kMaxMeshDepth : built.instances.depth > kMaxInstanceDepth)
        return false;
    FreeTopLevel();
    Top top;
    // The indices of the primitives of each part
    std::vector<uint32_t> parts;
    if (isOneLevel) {
        for (const WideLevel::Source& source : built.level.sources) {
            parts.push_back(source.placed);
            top.sources.push_back(source.triangle);
        }
    } else {
        parts = built.instances.placements;
        top.boxes = std::move(built.instances.boxes);
    }
    top.firstEntries.assign(built.parts.size() + 1, 0);
    for (const uint32_t part : parts)
        if (part < built.parts.size()) ++top.firstEntries[part + 1];
    for (size_t i = 0; i < built.parts.size(); ++i) top.firstEntries[i + 1] += top.firstEntries[i];
    top.places.resize(top.firstEntries.back());
    std::vector<uint32_t> next = top.firstEntries;
    for (uint32_t i = 0; i < parts.size(); ++i)
        if (parts[i] < built.parts.size()) top.places[next[parts[i]]++] = i;

    top.nodes = std::move(isOneLevel ? built.level.mesh.nodes : built.instances.nodes);
    if (isOneLevel) top.triangles = StoreTriangles(built.level.mesh.triangles);
    top.inTable = StoreNodes(top.nodes, top.triangles.first);
    m_top = std::move(top);
    m_top.refit = WideRefit(m_top.nodes, [this](uint32_t primitive) { return BoxOf(primitive); });
    if (isOneLevel) built.instances.instances.emplace_back();
    built.instances.instances[0].root = m_top.inTable.first;
    StoreInstances(std::move(built.instances.instances));
    m_parts = std::move(built.parts);
    return true;
}

Box WideSet::BoxOf(uint32_t primitive) const {
    if (!m_isOneLevel) return m_top.boxes[primitive];
    const gpu::WideTriangle& triangle = m_triangles[m_top.triangles.first + primitive];
    Box box;
    for (const glm::vec3& corner : {triangle.p0, triangle.p1, triangle.p2}) box.Extend(corner);
    return box;
}

bool WideSet::Refit(const std::vector<Part>& parts) {
    if (parts.size() != m_parts.size()) return false;
    for (size_t i = 0; i < parts.size(); ++i) {
        Part moved = m_parts[i];
        moved.objectToWorld = parts[i].objectToWorld;
        if (!(moved == parts[i])) return false;
    }
    std::vector<uint32_t> moved;
    for (uint32_t i = 0; i < parts.size(); ++i) {
        if (parts[i].objectToWorld == m_parts[i].objectToWorld) continue;
        if (!(m_isOneLevel ? MoveTriangles(parts[i], i, moved) : MoveInstance(parts[i], i, moved)))
            return false;
    }
    for (const uint32_t node :
         m_top.refit.Refit(m_top.nodes, moved, [this](uint32_t primitive) { return BoxOf(primitive); }))
        StoreNode(m_top.inTable.first + node, m_top.nodes[node], m_top.inTable.first, m_top.triangles.first);
    return true;
}

bool WideSet::MoveTriangles(const Part& part, uint32_t index, std::vector<uint32_t>& moved) {
    const uint32_t first = m_top.firstEntries[index], end = m_top.firstEntries[index + 1];
    const std::optional<std::vector<gpu::WideTriangle>> triangles = PlaceTriangles(TrianglesOf(part));
    if (!triangles || triangles->size() != end - first) return false;
    for (uint32_t i = first; i < end; ++i) {
        const uint32_t primitive = m_top.places[i];
        m_triangles.Edit(m_top.triangles.first + primitive) = (*triangles)[m_top.sources[primitive]];
        moved.push_back(primitive);
    }
    return true;
}

bool WideSet::MoveInstance(const Part& part, uint32_t index, std::vector<uint32_t>& moved) {
    const std::optional<PlacedInstance> placed = PlaceInstance(PlacementOf(part));
    if (!placed || m_top.firstEntries[index] == m_top.firstEntries[index + 1]) return false;
    const uint32_t primitive = m_top.places[m_top.firstEntries[index]];
    m_instances.Edit(primitive) = placed->instance;
    m_top.boxes[primitive] = placed->box;
    moved.push_back(primitive);
    return true;
}

void WideSet::StartRebuild() {
    if (m_future.valid()) return;
    const auto build = [parts = m_parts,
                        placements = m_isOneLevel ? std::vector<WidePlacement>() : PlacementsOf(m_parts),
                        isOneLevel = m_isOneLevel]() mutable {
        Built built{.parts = std::move(parts), .level = {}, .instances = {}};
        if (!isOneLevel) {
            built.instances = BuildWideInstances(placements);
            return built;
        }
        std::vector<PlacedTriangles> placed;
        for (const Part& part : built.parts) placed.push_back(TrianglesOf(part));
        built.level = BuildWideLevel(placed);
        return built;
    };
    try {
        m_future = std::async(std::launch::async, build);
    } catch (const std::system_error&) {
        // If no thread can be started, the tree stays as it is
    }
}

void WideSet::FollowMeshes(const SceneGeometry& geometry, size_t spareNodes) {
    m_placed.resize(std::max(m_placed.size(), geometry.groups.size()));
    const auto treeOf = [&](size_t i) {
        return i < geometry.groups.size() ? geometry.groups[i].tree : std::shared_ptr<WideMesh>();
    };
    size_t nodes = 0, triangles = 0;
    for (size_t i = 0; i < m_placed.size(); ++i) {
        const std::shared_ptr<WideMesh> tree = treeOf(i);
        if (m_placed[i].tree == tree) continue;
        Free(m_placed[i]);
        if (!tree) continue;
        if (tree->nodes.empty()) BuildTree(*tree);
        if (tree->nodes.empty()) {
            m_unavailableReason = "a mesh reaches too far for a tree";
            return;
        }
        nodes += tree->nodes.size();
        triangles += tree->triangles.size();
    }
    m_nodes.Reserve(m_nodeSlots.End() + nodes + spareNodes);
    m_triangles.Reserve(m_triangleSlots.End() + triangles);
    for (size_t i = 0; i < m_placed.size(); ++i)
        if (const std::shared_ptr<WideMesh> tree = treeOf(i); tree != m_placed[i].tree)
            Place(m_placed[i], tree);
}

void WideSet::Place(Placed& placed, const std::shared_ptr<WideMesh>& tree) {
    placed.box = tree->box;
    placed.depth = tree->depth;
    placed.triangles = StoreTriangles(tree->triangles);
    placed.nodes = StoreNodes(tree->nodes, placed.triangles.first);
    tree->triangles = {};
    tree->nodes = {};
    placed.tree = tree;
}

WideSet::Range WideSet::StoreTriangles(std::span<const gpu::WideTriangle> triangles) {
    const auto count = static_cast<uint32_t>(triangles.size());
    const Range range{m_triangleSlots.Allocate(count), count};
    m_triangles.Grow(m_triangleSlots.End());
    m_triangles.Write(range.first, triangles);
    return range;
}

WideSet::Range WideSet::StoreNodes(std::span<const gpu::WideNode> nodes, uint32_t firstPrimitive) {
    const auto count = static_cast<uint32_t>(nodes.size());
    const Range range{m_nodeSlots.Allocate(count), count};
    m_nodes.Grow(m_nodeSlots.End());
    for (uint32_t i = 0; i < count; ++i) StoreNode(range.first + i, nodes[i], range.first, firstPrimitive);
    return range;
}

void WideSet::StoreNode(uint32_t place, gpu::WideNode node, uint32_t firstNode, uint32_t firstPrimitive) {
    MoveNodes({&node, 1}, firstNode, firstPrimitive);
    m_nodes.Edit(place) = node;
}

void WideSet::Free(Placed& placed) {
    m_nodeSlots.Free(placed.nodes.first, placed.nodes.count);
    m_triangleSlots.Free(placed.triangles.first, placed.triangles.count);
    placed = {};
}

void WideSet::FreeTopLevel() {
    m_nodeSlots.Free(m_top.inTable.first, m_top.inTable.count);
    m_triangleSlots.Free(m_top.triangles.first, m_top.triangles.count);
    m_top = {};
}

void WideSet::StoreInstances(std::vector<gpu::WideInstance>&& instances) {
    m_instances.Assign(std::move(instances));
}

void WideSet::Declare(Renderer& renderer, SceneIds& ids) {
    if (!m_unavailableReason.empty()) return;
    ids.hasOneWideLevel = HasOneLevel();
    ids.wideNodes = m_nodes.Declare(renderer);
    ids.wideTriangles = m_triangles.Declare(renderer);
    ids.wideInstances = m_instances.Declare(renderer);
}

uint64_t WideSet::Bytes() const {
    return m_nodes.DeviceBytes() + m_triangles.DeviceBytes() + m_instances.DeviceBytes();
}

// --- BoxTree ---

namespace {

double Area(const scene::Bounds& bounds) {
    if (bounds.IsEmpty()) return 0.0;
    const glm::dvec3 size = glm::dvec3(bounds.max) - glm::dvec3(bounds.min);
    return 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
}

bool AreSame(const scene::Bounds& a, const scene::Bounds& b) {
    return a.min == b.min && a.max == b.max;
}

size_t FamiliesOf(size_t boxes) {
    return (boxes + BoxTree::kChildren - 1) / BoxTree::kChildren;
}

}  // namespace

scene::Bounds BoxTree::Family::Around() const {
    scene::Bounds around = boxes[0];
    for (size_t i = 1; i < kChildren; ++i) {
        around.min = glm::min(around.min, boxes[i].min);
        around.max = glm::max(around.max, boxes[i].max);
    }
    return around;
}

void BoxTree::Level::Reserve(size_t boxes) {
    const size_t room = FamiliesOf(boxes);
    if (families.capacity() >= room) return;
    const size_t more = std::max(room, 2 * families.capacity());
    costs.reserve(more * kChildren);
    due.reserve(more);
    isDirty.reserve(more);
    families.reserve(more);
}

void BoxTree::Level::Resize(size_t boxes, bool isLeaves) {
    count = boxes;
    families.resize(FamiliesOf(boxes));
    isDirty.resize(families.size());
    if (!isLeaves) costs.resize(families.size() * kChildren);
}

void BoxTree::Level::MarkDirty(size_t family) noexcept {
    if (isDirty[family]) return;
    due.push_back(static_cast<uint32_t>(family));
    isDirty[family] = 1;
}

void BoxTree::Assign(std::span<const scene::Bounds> leaves) {
    BoxTree tree;
    tree.Grow(leaves.size());
    for (size_t i = 0; i < leaves.size(); ++i) tree.Set(i, leaves[i]);
    tree.Refresh();
    *this = std::move(tree);
}

void BoxTree::Grow(size_t leafCount) {
    if (leafCount <= LeafCount()) return;
    // All that may fail comes first; levels above the root are ignored until they have boxes
    size_t levels = 1;
    for (size_t count = leafCount; count > 1; count = FamiliesOf(count)) ++levels;
    std::vector<Level> added(levels - std::min(levels, m_levels.size()));
    m_levels.reserve(levels);
    size_t count = leafCount;
    for (size_t i = 0; i < levels; ++i, count = FamiliesOf(count))
        (i < m_levels.size() ? m_levels[i] : added[i - m_levels.size()]).Reserve(count);

    const size_t before = m_levels.size();
    for (Level& level : added) m_levels.push_back(std::move(level));
    count = leafCount;
    for (size_t i = 0; i < levels; ++i, count = FamiliesOf(count)) m_levels[i].Resize(count, i == 0);
    if (before == 0 || before == levels) return;
    Level& root = m_levels[before - 1];  // the root before the tree grew
    for (size_t family = 0; family < root.families.size(); ++family) root.MarkDirty(family);
}

void BoxTree::Set(size_t leaf, const scene::Bounds& box) noexcept {
    Level& leaves = m_levels[0];
    scene::Bounds& old = leaves.Box(leaf);
    if (AreSame(old, box)) return;
    m_boxCount += (box.IsEmpty() ? 0u : 1u);
    m_boxCount -= (old.IsEmpty() ? 0u : 1u);
    old = box;
    leaves.MarkDirty(leaf / kChildren);
}

double BoxTree::Level::CostOf(size_t family) const {
    if (costs.empty()) return 0.0;
    const auto first = costs.begin() + static_cast<ptrdiff_t>(family * kChildren);
    return std::accumulate(first, first + kChildren, 0.0);
}

void BoxTree::Refresh() noexcept {
    for (size_t i = 0; i < m_levels.size(); ++i) {
        Level& level = m_levels[i];
        for (const uint32_t family : level.due) {
            level.isDirty[family] = 0;
            if (i + 1 == m_levels.size()) continue;  // the root
            Level& above = m_levels[i + 1];
            const scene::Bounds box = level.families[family].Around();
            const double cost = Area(box) + level.CostOf(family);
            if (AreSame(above.Box(family), box) && above.costs[family] == cost) continue;
            above.Box(family) = box;
            above.costs[family] = cost;
            above.MarkDirty(family / kChildren);
        }
        level.due.clear();
    }
}

scene::Bounds BoxTree::Root() const {
    return m_levels.empty() ? scene::Bounds() : m_levels.back().Box(0);
}

scene::Bounds BoxTree::AroundAllBut(std::vector<size_t> leaves) const {
    if (leaves.empty()) return Root();
    scene::Bounds around;
    // On each level, `leaves` become the boxes that contain one of them; their siblings contain none
    for (const Level& level : m_levels) {
        std::ranges::sort(leaves);
        std::vector<size_t> parents;
        for (const size_t leaf : leaves)
            if (parents.empty() || parents.back() != leaf / kChildren) parents.push_back(leaf / kChildren);
        for (const size_t parent : parents)
            for (size_t i = parent * kChildren; i < std::min((parent + 1) * kChildren, level.count); ++i)
                if (!std::ranges::binary_search(leaves, i)) around.Extend(level.Box(i));
        leaves = std::move(parents);
    }
    return around;
}

}  // namespace raygraph
