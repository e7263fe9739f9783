// The three things glTF does with a URI: tell its scheme, undo percent-encoding, unpack a data URI.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace raygraph::scene {

// Returns "data" for "data:...", by the grammar of RFC 3986; nullopt if the text has no scheme.
std::optional<std::string_view> UriScheme(std::string_view uri);

bool IsDataUri(std::string_view uri);

// Replaces "%20" by a space and so on; a '%' without two hexadecimal digits stays.
std::string PercentDecode(std::string_view text);

// The bytes of a data URI, base64 or percent-encoded (RFC 2397). Throws Error{BadInput} with the reason alone
// (the caller puts the place before it) if it is malformed or has more than `maxBytes`.
std::vector<std::byte> DecodeDataUri(std::string_view uri, uint64_t maxBytes);

}  // namespace raygraph::scene
