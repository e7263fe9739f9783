// Texts of counts, for messages. Threads: any.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace raygraph {

// Returns "1 key", "2 keys" or "0 keys"; or "1 vertex follows", "2 vertices follow" with the verb that agrees
// with what is counted. The plural is the singular with an s, or the one given.
inline std::string Counted(uint64_t count, std::string_view one, std::string_view many = {}) {
    std::string text = std::to_string(count) + ' ';
    if (count != 1 && !many.empty()) return text.append(many);
    text += one;
    return count == 1 ? text : text + 's';
}

}  // namespace raygraph
