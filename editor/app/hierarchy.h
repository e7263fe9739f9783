// The rows of the hierarchy as a list: of a tree of tens of thousands of nodes only visible rows are
// drawn. Pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace raygraph::editor {

class Hierarchy {
  public:
    Hierarchy() = default;
    // A single root node is open, all others are closed.
    Hierarchy(std::vector<std::vector<uint32_t>> children, std::vector<uint32_t> roots);

    struct Row {
        uint32_t node = 0;
        uint32_t depth = 0;
    };
    // The nodes that are not below a closed node, from the top.
    const std::vector<Row>& Rows() const;
    const std::vector<uint32_t>& Children(uint32_t node) const { return m_children.at(node); }
    bool IsOpen(uint32_t node) const { return m_isOpen.at(node); }
    void SetOpen(uint32_t node, bool isOpen);
    // Opens the node's ancestors, and returns its row. Rows().size() if it is not in the tree.
    size_t Reveal(uint32_t node);

  private:
    std::vector<std::vector<uint32_t>> m_children;  // by node
    std::vector<uint32_t> m_roots;
    std::vector<uint32_t> m_parents;  // by node; kNoParent
    std::vector<bool> m_isOpen;
    mutable std::vector<Row> m_rows;
    mutable bool m_isStale = true;
};

}  // namespace raygraph::editor
