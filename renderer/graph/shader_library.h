// ShaderLibrary: shaders by name, from the SPIR-V built into the library, from source files, or handed in.
//
// With a source root, a stage found there is compiled from source when it is first requested, and again by
// Reload when its source or an included file has changed: the file of its name, or the source of the variant
// of that name (shaders/CMakeLists.txt). A stage that no longer compiles keeps its last good SPIR-V.
//
// Threads: one at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rhi/reflection.h"
#include "rhi/shader_compiler.h"

namespace raygraph {

// One stage. Lives as long as its library, at one address.
struct Shader {
    std::string name;
    std::span<const uint32_t> words{};
    rhi::ShaderReflection reflection{};

    // The source of the words; empty for SPIR-V that was built in or handed in.
    std::vector<uint32_t> compiledWords{};
    rhi::GlslSource source{};                      // for rhi::CompileGlslFile
    std::vector<std::filesystem::path> sources{};  // the file and all it includes
    uint64_t sourceHash = 0;                       // hash of the sources' contents
    bool isBroken = false;                         // the current source does not compile
};

class ShaderLibrary {
  public:
    // `root`: folder of sources that names are relative to; empty: none. They may include files
    // of `includes`.
    explicit ShaderLibrary(std::filesystem::path root, std::vector<std::filesystem::path> includes = {});
    ~ShaderLibrary();

    // Takes a copy. A name that exists gets the new words.
    const Shader& Add(std::string_view name, std::span<const uint32_t> spirv);
    // The shader of that name, if it has been requested or added; null otherwise.
    const Shader* Known(std::string_view name) const;
    // Throws Error{Usage} naming the shaders of a similar name if there is none; as rhi::CompileGlsl for a
    // source that does not compile and has never done so.
    const Shader& Find(std::string_view name);

    struct ReloadResult {
        std::vector<const Shader*> changed;
        std::vector<std::string> messages;  // "file:line: text"
    };
    ReloadResult Reload();

  private:
    std::optional<rhi::GlslSource> FindInRoot(const std::string& name) const;
    Shader* LoadFromRoot(const std::string& name);
    Shader& Insert(Shader shader);
    std::string SimilarNames(std::string_view name) const;

    std::filesystem::path m_root;
    std::vector<std::filesystem::path> m_includes;
    std::map<std::string, std::unique_ptr<Shader>, std::less<>> m_shaders;
};

}  // namespace raygraph
