// Compiles GLSL to SPIR-V at run time, for shader hot reload and for tests. Threads: any, also several at
// once.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/api.h"
#include "rhi/shader_stage.h"

namespace raygraph::rhi {

struct GlslSource {
    std::string name{};      // path relative to includeRoot, "pathtrace/pathtrace.rgen"; appears in errors
    std::string text{};      // the whole GLSL source, starting with #version
    std::string preamble{};  // inserted before the text and not counted in lines: "#define COUNT 4\n"
    std::optional<StageKind> stage{};     // nullopt: given by the suffix of the name
    std::filesystem::path includeRoot{};  // searched after the including file's folder; empty: no includes
    std::vector<std::filesystem::path> moreIncludes{};  // further roots, which are searched after includeRoot
};

// Compiles for Vulkan 1.3 (SPIR-V 1.6). The words equal the output of `glslangValidator -V --target-env
// vulkan1.3 -I<root>` of the same glslang version, by which the build makes the embedded shaders.
// `includedFiles`, if given, receives every file that was included, also when the compilation fails; a hot
// reload has to watch these files and the source itself. Throws Error{BadInput} with one line for each of the
// first five findings, "pathtrace/pathtrace.rgen:12: 'x' : undeclared identifier"; Error{Usage} if neither
// stage nor suffix names a stage. Callable from any thread.
RAYGRAPH_API std::vector<uint32_t> CompileGlsl(const GlslSource& source,
                                               std::vector<std::filesystem::path>* includedFiles = nullptr);

// Compiles the text of the file `name` of `includeRoot`. Throws Error{Io} if it cannot be read.
RAYGRAPH_API std::vector<uint32_t> CompileGlslFile(
    GlslSource source, std::vector<std::filesystem::path>* includedFiles = nullptr);

}  // namespace raygraph::rhi
