// Text that came out of a file, made fit for a one-line message.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace raygraph::scene {

// `text` with control characters and bytes that are not UTF-8 as '?', cut to `maxBytes` with "..." after it.
std::string Printable(std::string_view text, size_t maxBytes = 120);

// Printable text in double quotes.
std::string Quoted(std::string_view text, size_t maxBytes = 120);

}  // namespace raygraph::scene
