// ShaderLibrary: shaders by name, from SPIR-V in the library, from source files, or from the host.
//
// With a source root, a stage that is found there is compiled from source when it is first requested, and
// again by Reload when its source or an included file has changed. The source is the file with its name, or
// that of the variant with its name (shaders/CMakeLists.txt). A stage that no longer compiles keeps its last
// good SPIR-V.
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

struct EmbeddedShader;

// Describes one stage. It lives as long as its library, at a fixed address.
struct Shader {
    std::string name;
    std::span<const uint32_t> words{};
    rhi::ShaderReflection reflection{};

    // Compiled from `source`; empty for SPIR-V of the library or of the host.
    std::vector<uint32_t> compiledWords{};
    rhi::GlslSource source{};                      // input of rhi::CompileGlslFile
    std::vector<std::filesystem::path> sources{};  // the file and all that it includes
    uint64_t sourceHash = 0;                       // hash of the sources' contents
    bool isBroken = false;                         // the current source does not compile
};

class ShaderLibrary {
  public:
    // `root` is the folder of the sources to which names are relative; empty: there is none. The sources may
    // include files of `includes`.
    explicit ShaderLibrary(std::filesystem::path root, std::vector<std::filesystem::path> includes = {});
    ~ShaderLibrary();

    // Copies the words. A shader with that name gets the new words.
    const Shader& Add(std::string_view name, std::span<const uint32_t> spirv);
    // Returns the shader with that name if it has been requested or added; null otherwise.
    const Shader* FindLoaded(std::string_view name) const;
    // Throws Error{Usage} naming shaders of similar names if there is none with that name. Throws as
    // rhi::CompileGlsl does for a source that does not compile and has never done so.
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

// Returns a hash of the names and the SPIR-V of the shaders. Threads: any.
uint64_t HashOf(std::span<const EmbeddedShader> shaders);
// Returns the hash of all shaders of the library. Threads: any.
uint64_t HashOfEmbeddedShaders();

}  // namespace raygraph
