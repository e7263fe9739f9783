// Binary data as text. Threads: pure functions, for any thread.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "base/api.h"

namespace raygraph {

// Returns the bytes in base64 with padding (RFC 4648, section 4).
RAYGRAPH_API std::string EncodeBase64(std::span<const std::byte> bytes);

}  // namespace raygraph
