// Hierarchy lists the tree of nodes as rows, so that of tens of thousands of nodes only visible rows are
// drawn. It draws nothing itself. Threads: one at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace raygraph::editor {

class Hierarchy {
  public:
    Hierarchy() = default;
    // Starts with a single root node open, and all others closed.
    Hierarchy(std::vector<std::vector<uint32_t>> children, std::vector<uint32_t> roots);

    // Takes another hierarchy of the same nodes, and of new ones; what was open stays open. Ends the filter.
    void Update(std::vector<std::vector<uint32_t>> children, std::vector<uint32_t> roots);

    struct Row {
        uint32_t node = 0;
        uint32_t depth = 0;
    };
    // Returns the nodes without a closed ancestor, from the top; while there is a filter, all that it lists.
    const std::vector<Row>& Rows() const;
    const std::vector<uint32_t>& Children(uint32_t node) const { return m_children.at(node); }
    std::optional<uint32_t> Parent(uint32_t node) const;
    // Returns whether rows below the node are listed, or would be if it were open.
    bool HasRowsBelow(uint32_t node) const;
    bool IsOpen(uint32_t node) const { return IsFiltered() || m_isOpen.at(node); }
    void SetOpen(uint32_t node, bool isOpen);
    // Lists only the nodes that match (indexed by node) and their ancestors, as if all were open.
    void SetFilter(const std::vector<bool>& isMatch);
    void EndFilter();
    bool IsFiltered() const { return !m_isListed.empty(); }
    // Opens the node's ancestors, and returns its row; Rows().size() if the node is not in the tree, or not
    // listed by the filter.
    size_t Reveal(uint32_t node);

  private:
    std::vector<std::vector<uint32_t>> m_children;  // indexed by node
    std::vector<uint32_t> m_roots;
    std::vector<uint32_t> m_parents;  // indexed by node; kNoParent: a root
    std::vector<bool> m_isOpen;
    std::vector<bool> m_isListed;  // indexed by node; empty: there is no filter
    mutable std::vector<Row> m_rows;
    mutable bool m_isStale = true;
};

}  // namespace raygraph::editor
