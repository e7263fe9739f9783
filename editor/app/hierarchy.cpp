#include "editor/app/hierarchy.h"

#include <algorithm>
#include <utility>

namespace raygraph::editor {

namespace {

constexpr uint32_t kNoParent = ~0u;

}  // namespace

Hierarchy::Hierarchy(std::vector<std::vector<uint32_t>> children, std::vector<uint32_t> roots) {
    Update(std::move(children), std::move(roots));
    if (m_roots.size() == 1) m_isOpen[m_roots[0]] = true;
}

void Hierarchy::Update(std::vector<std::vector<uint32_t>> children, std::vector<uint32_t> roots) {
    m_children = std::move(children);
    m_roots = std::move(roots);
    m_isOpen.resize(m_children.size(), false);
    m_parents.assign(m_children.size(), kNoParent);
    for (uint32_t node = 0; node < m_children.size(); ++node)
        for (const uint32_t child : m_children[node]) m_parents[child] = node;
    EndFilter();
}

void Hierarchy::SetFilter(const std::vector<bool>& isMatch) {
    m_isListed.assign(m_children.size(), false);
    for (uint32_t node = 0; node < isMatch.size(); ++node)
        for (uint32_t above = isMatch[node] ? node : kNoParent; above != kNoParent && !m_isListed[above];
             above = m_parents[above])
            m_isListed[above] = true;
    m_isStale = true;
}

void Hierarchy::EndFilter() {
    m_isListed.clear();
    m_isStale = true;
}

std::optional<uint32_t> Hierarchy::Parent(uint32_t node) const {
    const uint32_t parent = m_parents.at(node);
    return parent == kNoParent ? std::nullopt : std::optional(parent);
}

bool Hierarchy::HasRowsBelow(uint32_t node) const {
    const std::vector<uint32_t>& children = m_children.at(node);
    return IsFiltered() ? std::ranges::any_of(children, [&](uint32_t child) { return m_isListed[child]; })
                        : !children.empty();
}

const std::vector<Hierarchy::Row>& Hierarchy::Rows() const {
    if (!std::exchange(m_isStale, false)) return m_rows;
    m_rows.clear();
    std::vector<Row> stack;
    for (size_t i = m_roots.size(); i-- > 0;) stack.push_back({m_roots[i], 0});
    while (!stack.empty()) {
        const Row row = stack.back();
        stack.pop_back();
        if (IsFiltered() && !m_isListed[row.node]) continue;
        m_rows.push_back(row);
        if (!IsOpen(row.node)) continue;
        const std::vector<uint32_t>& children = m_children[row.node];
        for (size_t i = children.size(); i-- > 0;) stack.push_back({children[i], row.depth + 1});
    }
    return m_rows;
}

void Hierarchy::SetOpen(uint32_t node, bool isOpen) {
    m_isStale |= m_isOpen.at(node) != isOpen;
    m_isOpen[node] = isOpen;
}

size_t Hierarchy::Reveal(uint32_t node) {
    for (uint32_t above = m_parents.at(node); above != kNoParent; above = m_parents[above])
        SetOpen(above, true);
    const std::vector<Row>& rows = Rows();
    const auto row = std::ranges::find_if(rows, [&](const Row& of) { return of.node == node; });
    return static_cast<size_t>(row - rows.begin());
}

}  // namespace raygraph::editor
