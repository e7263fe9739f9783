// Parts of one-line messages: text that came out of a file or from a user, made printable, because a
// terminal that shows it may act on control characters; and counts with their nouns. Threads: pure
// functions, for any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/api.h"

namespace raygraph {

// Returns the bytes of the well-formed UTF-8 sequence at the start of `text`; 0 if there is none.
RAYGRAPH_API size_t Utf8Length(std::string_view text);

// Returns `text` with control characters and bytes that are not UTF-8 as '?', cut to `maxBytes` with "..."
// after it.
RAYGRAPH_API std::string Printable(std::string_view text, size_t maxBytes = 120);

// Returns the printable text in double quotes.
RAYGRAPH_API std::string Quoted(std::string_view text, size_t maxBytes = 120);

// Returns "1 key", "2 keys" or "0 keys"; or "1 vertex follows", "2 vertices follow" with the verb that agrees
// with what is counted. The plural is the singular with an s, or the one given.
inline std::string Counted(uint64_t count, std::string_view one, std::string_view many = {}) {
    std::string text = std::to_string(count) + ' ';
    if (count != 1 && !many.empty()) return text.append(many);
    text += one;
    return count == 1 ? text : text + 's';
}

}  // namespace raygraph
