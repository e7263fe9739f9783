#include "renderer/gpu_scene/geometry/box_tree.h"

#include <algorithm>
#include <glm/glm.hpp>
#include <numeric>
#include <utility>

namespace raygraph {
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
    isDue.reserve(more);
    families.reserve(more);
}

void BoxTree::Level::Resize(size_t boxes, bool isLeaves) {
    count = boxes;
    families.resize(FamiliesOf(boxes));
    isDue.resize(families.size());
    if (!isLeaves) costs.resize(families.size() * kChildren);
}

void BoxTree::Level::MarkDirty(size_t family) noexcept {
    if (isDue[family]) return;
    due.push_back(static_cast<uint32_t>(family));
    isDue[family] = 1;
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
            level.isDue[family] = 0;
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

}  // namespace raygraph
