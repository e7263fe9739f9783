// Holds the program's version, from the build.
#pragma once

namespace raygraph::cli {

inline constexpr const char* kVersion = RAYGRAPH_VERSION;

}  // namespace raygraph::cli
