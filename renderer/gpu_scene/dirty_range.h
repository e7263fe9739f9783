// Which records of a table have to be uploaded again.
#pragma once

#include <algorithm>
#include <cstdint>

namespace raygraph {

// From the first to the last record that has changed since the last upload.
struct DirtyRange {
    uint32_t first = 0, end = 0;
    bool IsEmpty() const { return first == end; }
    uint32_t Count() const { return end - first; }
    void Add(uint32_t index) {
        first = IsEmpty() ? index : std::min(first, index);
        end = std::max(end, index + 1);
    }
};

}  // namespace raygraph
