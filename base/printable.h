// Text that came out of a file or from a user, made fit for a one-line message: a terminal that shows it may
// act on control characters. Threads: pure functions, for any thread.
#pragma once

#include <cstddef>
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

}  // namespace raygraph
