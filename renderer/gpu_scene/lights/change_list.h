// ChangeList: the indices of changed objects, each listed once. Threads: as std::vector.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace raygraph {

// Makes room for `count` more elements, at least doubling the capacity.
template <typename Value>
void ReserveMore(std::vector<Value>& list, size_t count) {
    if (list.capacity() - list.size() < count)
        list.reserve(std::max(list.size() + count, 2 * list.capacity()));
}

class ChangeList {
  public:
    explicit ChangeList(size_t count = 0) : m_isListed(count) {}
    // Adds an index. Returns false if it is listed already.
    bool Add(uint32_t index) {
        if (m_isListed[index]) return false;
        m_list.push_back(index);
        m_isListed[index] = true;
        return true;
    }
    // Makes room for `count` more indices, so that adding them does not throw.
    void Reserve(size_t count) { ReserveMore(m_list, count); }
    void Clear() {
        for (const uint32_t index : m_list) m_isListed[index] = false;
        m_list.clear();
    }
    bool IsEmpty() const { return m_list.empty(); }
    // Returns the indices in the order in which they were added.
    std::span<const uint32_t> List() const { return m_list; }

  private:
    std::vector<uint32_t> m_list;
    std::vector<bool> m_isListed;
};

}  // namespace raygraph
