#include "rhi/shader_compiler.h"

#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>

#include <fstream>
#include <iterator>
#include <sstream>

#include "base/text.h"

namespace raygraph::rhi {
namespace {

namespace fs = std::filesystem;

// Creates glslang's process-wide tables at the first use, on whichever thread comes first.
void InitializeGlslang() {
    static const bool isReady = glslang::InitializeProcess();
    if (!isReady) throw Error(ErrorKind::Usage, "shader compiler: glslang does not initialize");
}

EShLanguage ToGlslang(StageKind stage) {
    switch (stage) {
        case StageKind::RayGen:
            return EShLangRayGen;
        case StageKind::Miss:
            return EShLangMiss;
        case StageKind::ClosestHit:
            return EShLangClosestHit;
        case StageKind::AnyHit:
            return EShLangAnyHit;
        case StageKind::Intersection:
            return EShLangIntersect;
        case StageKind::Callable:
            return EShLangCallable;
        case StageKind::Compute:
            return EShLangCompute;
        case StageKind::Vertex:
            return EShLangVertex;
        case StageKind::Fragment:
            return EShLangFragment;
    }
    return EShLangCount;
}

std::optional<std::string> ReadText(const fs::path& path) {
    std::error_code ignored;
    if (!fs::is_regular_file(path, ignored)) return std::nullopt;
    std::ifstream file(path, std::ios::binary);
    if (!file) return std::nullopt;
    return std::string(std::istreambuf_iterator<char>(file), {});
}

// Finds included files beside the including one, then in the roots. Messages name them relative to the root
// in which they are.
class FolderIncluder : public glslang::TShader::Includer {
  public:
    FolderIncluder(const GlslSource& source, std::vector<fs::path>* files) : m_files(files) {
        if (!source.includeRoot.empty()) m_roots.push_back(source.includeRoot);
        m_roots.insert(m_roots.end(), source.moreIncludes.begin(), source.moreIncludes.end());
    }

    IncludeResult* includeLocal(const char* header, const char* includer, size_t) override {
        IncludeResult* result = Open(fs::path(includer).parent_path() / header);
        return result ? result : Open(header);
    }

    IncludeResult* includeSystem(const char* header, const char*, size_t) override { return Open(header); }

    void releaseInclude(IncludeResult* result) override {
        if (!result) return;
        delete static_cast<std::string*>(result->userData);
        delete result;
    }

  private:
    IncludeResult* Open(const fs::path& relative) {
        const fs::path name = relative.lexically_normal();
        for (const fs::path& root : m_roots) {
            std::optional<std::string> text = ReadText(root / name);
            if (!text) continue;
            if (m_files) m_files->push_back(root / name);
            auto* owned = new std::string(std::move(*text));
            return new IncludeResult(name.generic_string(), owned->data(), owned->size(), owned);
        }
        return nullptr;
    }

    std::vector<fs::path> m_roots;
    std::vector<fs::path>* m_files;
};

// glslang writes "ERROR: file:line: text" lines, followed by their number.
std::string FirstErrors(const std::string& log, const std::string& name) {
    constexpr int kMaxErrors = 5;
    constexpr std::string_view kPrefix = "ERROR: ";
    std::istringstream lines(log);
    std::string errors;
    int count = 0;
    for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with(kPrefix) || line.ends_with("No code generated.")) continue;
        if (line.find("'' : compilation terminated") != std::string::npos) continue;
        line.erase(0, kPrefix.size());
        while (!line.empty() && line.back() == ' ') line.pop_back();
        if (++count > kMaxErrors) continue;
        // Errors of linking name no file.
        if (line.find(".") == std::string::npos || line.starts_with("Linking")) line = name + ": " + line;
        errors += (errors.empty() ? "" : "\n") + line;
    }
    if (count > kMaxErrors) errors += Text("\n{}: and {} more errors", name, count - kMaxErrors);
    return errors.empty() ? name + ": does not compile" : errors;
}

}  // namespace

std::vector<uint32_t> CompileGlsl(const GlslSource& source, std::vector<fs::path>* includedFiles) {
    const std::optional<StageKind> stage = source.stage ? source.stage : StageOfFile(source.name);
    if (!stage)
        throw MakeError(ErrorKind::Usage, "{}: neither a stage nor a suffix that names one is given",
                        source.name);
    InitializeGlslang();

    const EShLanguage language = ToGlslang(*stage);
    const char* text = source.text.data();
    const int length = static_cast<int>(source.text.size());
    const char* name = source.name.c_str();
    constexpr int kInputSemanticsVersion = 100;  // the value of glslangValidator -V
    constexpr int kDefaultGlslVersion = 100;
    const auto messages = static_cast<EShMessages>(EShMsgDefault | EShMsgSpvRules | EShMsgVulkanRules);

    glslang::TShader shader(language);
    shader.setStringsWithLengthsAndNames(&text, &length, &name, 1);
    shader.setPreamble(source.preamble.c_str());
    shader.setEnvInput(glslang::EShSourceGlsl, language, glslang::EShClientVulkan, kInputSemanticsVersion);
    shader.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_3);
    shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_6);
    FolderIncluder includer(source, includedFiles);
    if (!shader.parse(GetDefaultResources(), kDefaultGlslVersion, false, messages, includer))
        throw Error(ErrorKind::BadInput, FirstErrors(shader.getInfoLog(), source.name));

    glslang::TProgram program;
    program.addShader(&shader);
    if (!program.link(messages) || !program.mapIO())
        throw Error(ErrorKind::BadInput, FirstErrors(program.getInfoLog(), source.name));

    std::vector<uint32_t> words;
    glslang::SpvOptions options;
    options.disableOptimizer = false;  // as glslangValidator without -Od
    glslang::GlslangToSpv(*program.getIntermediate(language), words, &options);
    return words;
}

std::vector<uint32_t> CompileGlslFile(GlslSource source, std::vector<fs::path>* includedFiles) {
    const fs::path file = source.includeRoot / source.name;
    std::optional<std::string> text = ReadText(file);
    if (!text) throw MakeError(ErrorKind::Io, "{}: cannot be read", file);
    source.text = std::move(*text);
    return CompileGlsl(source, includedFiles);
}

}  // namespace raygraph::rhi
