// The SPIR-V of every shader stage, compiled with the library. Threads: any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "base/api.h"

namespace raygraph {

struct RAYGRAPH_API EmbeddedShader {
    std::string_view name;      // the name by which passes ask for it, such as
                                // "pathtrace/pathtrace.rgen"
    std::string_view source;    // path relative to shaders/: the name, or the source of which it is a variant
    std::string_view preamble;  // "#define SOFTWARE_TRAVERSAL\n": what goes before the text of the source.
    std::span<const std::byte> compressed;  // the SPIR-V module, a frame of zstd

    // Returns the module, which is decompressed by the first call and lives as long as the program.
    std::span<const uint32_t> Words() const;
};

// All embedded stages, in the order of shaders/CMakeLists.txt. Callable from any thread.
RAYGRAPH_API std::span<const EmbeddedShader> EmbeddedShaders();

}  // namespace raygraph
