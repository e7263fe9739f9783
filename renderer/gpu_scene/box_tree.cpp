#include "renderer/gpu_scene/box_tree.h"

#include <algorithm>
#include <glm/glm.hpp>
#include <utility>

namespace raygraph {
namespace {

double Area(const scene::Bounds& bounds) {
    if (bounds.IsEmpty()) return 0.0;
    const glm::dvec3 size = glm::dvec3(bounds.max) - glm::dvec3(bounds.min);
    return 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
}

scene::Bounds Around(std::span<const scene::Bounds> boxes, size_t parent) {
    const size_t begin = parent * BoxTree::kChildren;
    const size_t end = std::min(begin + BoxTree::kChildren, boxes.size());
    scene::Bounds around = boxes[begin];
    for (size_t i = begin + 1; i < end; ++i) {
        around.min = glm::min(around.min, boxes[i].min);
        around.max = glm::max(around.max, boxes[i].max);
    }
    return around;
}

bool AreSame(const scene::Bounds& a, const scene::Bounds& b) {
    return a.min == b.min && a.max == b.max;
}

}  // namespace

void BoxTree::Assign(std::vector<scene::Bounds> leaves) {
    m_levels.clear();
    m_cost = 0.0;
    m_levels.push_back({.boxes = std::move(leaves), .isDue = {}, .due = {}});
    while (m_levels.back().boxes.size() > 1) {
        const std::vector<scene::Bounds>& below = m_levels.back().boxes;
        Level level;
        level.boxes.resize((below.size() + kChildren - 1) / kChildren);
        level.isDue.resize(level.boxes.size());
        for (size_t i = 0; i < level.boxes.size(); ++i) level.boxes[i] = Around(below, i);
        m_levels.push_back(std::move(level));
    }
    for (size_t i = 0; i < m_levels.size(); ++i)
        if (IsCounted(i))
            for (const scene::Bounds& box : m_levels[i].boxes) m_cost += Area(box);
}

void BoxTree::MarkDue(Level& level, size_t box) {
    if (level.isDue[box]) return;
    level.due.push_back(static_cast<uint32_t>(box));
    level.isDue[box] = true;
}

void BoxTree::Set(size_t leaf, const scene::Bounds& box) {
    scene::Bounds& old = m_levels[0].boxes[leaf];
    if (AreSame(old, box)) return;
    if (m_levels.size() > 1) MarkDue(m_levels[1], leaf / kChildren);
    old = box;
}

void BoxTree::Prefetch(size_t leaf) const {
    const scene::Bounds* const siblings = &m_levels[0].boxes[leaf / kChildren * kChildren];
    for (size_t byte = 0; byte < kChildren * sizeof(scene::Bounds); byte += 64)
        __builtin_prefetch(reinterpret_cast<const char*>(siblings) + byte);
}

void BoxTree::Refresh() {
    for (size_t i = 1; i < m_levels.size(); ++i) {
        Level& level = m_levels[i];
        for (const uint32_t index : level.due) {
            level.isDue[index] = false;
            const scene::Bounds box = Around(m_levels[i - 1].boxes, index);
            if (AreSame(level.boxes[index], box)) continue;
            if (i + 1 < m_levels.size()) MarkDue(m_levels[i + 1], index / kChildren);
            if (IsCounted(i)) m_cost += Area(box) - Area(level.boxes[index]);
            level.boxes[index] = box;
        }
        level.due.clear();
    }
}

scene::Bounds BoxTree::Root() const {
    return LeafCount() == 0 ? scene::Bounds() : m_levels.back().boxes[0];
}

}  // namespace raygraph
