#include "renderer/graph/shader_library.h"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "base/text.h"
#include "renderer/graph/text.h"
#include "rhi/device_cache.h"
#include "shaders/embedded.h"

namespace raygraph {

namespace {

// Hashes the sources with FNV-1a; a file that cannot be read counts as empty.
uint64_t HashOf(std::span<const std::filesystem::path> files) {
    uint64_t hash = 0xcbf29ce484222325ull;
    const auto add = [&](unsigned char byte) { hash = (hash ^ byte) * 0x100000001b3ull; };
    for (const std::filesystem::path& file : files) {
        std::ifstream stream(file, std::ios::binary);
        for (std::istreambuf_iterator<char> c(stream), end; c != end; ++c)
            add(static_cast<unsigned char>(*c));
        add(0);
    }
    return hash;
}

void AppendLines(const std::string& text, std::vector<std::string>& lines) {
    for (size_t begin = 0; begin < text.size();) {
        const size_t end = std::min(text.find('\n', begin), text.size());
        if (end > begin) lines.push_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
}

std::string FileName(std::string_view path) {
    return std::filesystem::path(path).filename().string();
}

}  // namespace

ShaderLibrary::ShaderLibrary(std::filesystem::path root, std::vector<std::filesystem::path> includes)
    : m_root(std::move(root)), m_includes(std::move(includes)) {}
ShaderLibrary::~ShaderLibrary() = default;

Shader& ShaderLibrary::Insert(Shader shader) {
    auto owned = std::make_unique<Shader>(std::move(shader));
    if (!owned->compiledWords.empty()) owned->words = owned->compiledWords;
    Shader& inserted = *owned;
    m_shaders.emplace(inserted.name, std::move(owned));
    return inserted;
}

const Shader* ShaderLibrary::FindLoaded(std::string_view name) const {
    const auto known = m_shaders.find(name);
    return known == m_shaders.end() ? nullptr : known->second.get();
}

const Shader& ShaderLibrary::Add(std::string_view name, std::span<const uint32_t> spirv) {
    Shader shader{.name = std::string(name), .reflection = rhi::Reflect(spirv, name)};
    shader.compiledWords.assign(spirv.begin(), spirv.end());
    const auto known = m_shaders.find(name);
    if (known == m_shaders.end()) return Insert(std::move(shader));
    Shader& old = *known->second;
    old = std::move(shader);
    old.words = old.compiledWords;
    return old;
}

const Shader& ShaderLibrary::Find(std::string_view name) {
    if (const auto known = m_shaders.find(name); known != m_shaders.end()) return *known->second;
    if (!m_root.empty())
        if (const Shader* loaded = LoadFromRoot(std::string(name))) return *loaded;
    for (const EmbeddedShader& embedded : EmbeddedShaders())
        if (embedded.name == name)
            return Insert({.name = std::string(name),
                           .words = embedded.Words(),
                           .reflection = rhi::Reflect(embedded.Words(), name)});
    throw MakeError(ErrorKind::Usage, "no shader {}{}", Quoted(name), SimilarNames(name));
}

std::optional<rhi::GlslSource> ShaderLibrary::FindInRoot(const std::string& name) const {
    rhi::GlslSource source{.name = name, .includeRoot = m_root, .moreIncludes = m_includes};
    const auto exists = [&] {
        std::error_code failure;
        return std::filesystem::is_regular_file(m_root / source.name, failure);
    };
    if (exists()) return source;
    const auto shaders = EmbeddedShaders();
    const auto variant = std::ranges::find(shaders, name, &EmbeddedShader::name);
    if (variant == shaders.end()) return std::nullopt;
    source.name = variant->source;
    source.preamble = variant->preamble;
    source.stage = rhi::StageOfFile(name);
    return exists() ? std::optional(source) : std::nullopt;
}

Shader* ShaderLibrary::LoadFromRoot(const std::string& name) {
    std::optional<rhi::GlslSource> source = FindInRoot(name);
    if (!source) return nullptr;
    Shader shader{.name = name, .source = std::move(*source)};
    std::vector<std::filesystem::path> includes;
    shader.compiledWords = rhi::CompileGlslFile(shader.source, &includes);
    shader.reflection = rhi::Reflect(shader.compiledWords, name);
    shader.sources.push_back(m_root / shader.source.name);
    shader.sources.insert(shader.sources.end(), includes.begin(), includes.end());
    shader.sourceHash = HashOf(shader.sources);
    return &Insert(std::move(shader));
}

ShaderLibrary::ReloadResult ShaderLibrary::Reload() {
    ReloadResult result;
    for (auto& [name, shader] : m_shaders) {
        if (shader->sources.empty()) continue;
        const uint64_t hash = HashOf(shader->sources);
        // A broken shader is compiled again even if its sources are unchanged, because a missing file may
        // exist now.
        if (hash == shader->sourceHash && !shader->isBroken) continue;
        std::vector<std::filesystem::path> includes;
        try {
            std::vector<uint32_t> words = rhi::CompileGlslFile(shader->source, &includes);
            rhi::ShaderReflection reflection = rhi::Reflect(words, name);
            const bool isSame = std::ranges::equal(words, shader->words);
            shader->isBroken = false;
            if (!isSame) {
                shader->compiledWords = std::move(words);
                shader->words = shader->compiledWords;
                shader->reflection = std::move(reflection);
                result.changed.push_back(shader.get());
            }
        } catch (const Error& error) {
            shader->isBroken = true;
            AppendLines(error.what(), result.messages);
        }
        includes.insert(includes.begin(), shader->sources.front());
        // This is the hash from before the compilation, so that a source saved in between counts as changed
        // the next time.
        shader->sourceHash = includes == shader->sources ? hash : HashOf(includes);
        shader->sources = std::move(includes);
    }
    return result;
}

// Returns a hint, "; there are ...", with the shaders of the same file name or stage.
std::string ShaderLibrary::SimilarNames(std::string_view name) const {
    const std::string extension = std::filesystem::path(name).extension().string();
    std::vector<std::string> sameFile;
    std::vector<std::string> sameStage;
    const auto look = [&](std::string_view known) {
        if (FileName(known) == FileName(name)) sameFile.emplace_back(known);
        if (std::filesystem::path(known).extension() == extension) sameStage.emplace_back(known);
    };
    for (const EmbeddedShader& embedded : EmbeddedShaders()) look(embedded.name);
    for (const auto& [known, shader] : m_shaders) look(known);
    std::vector<std::string>& names = sameFile.empty() ? sameStage : sameFile;
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    std::string text = names.empty() ? "; there is none of its stage" : "; there is ";
    for (size_t i = 0; i < names.size(); ++i) text += (i == 0 ? "" : ", ") + names[i];
    return text;
}

uint64_t HashOf(std::span<const EmbeddedShader> shaders) {
    uint64_t hash = rhi::kChecksumStart;
    for (const EmbeddedShader& shader : shaders) {
        hash = rhi::Checksum(std::as_bytes(std::span(shader.name)), hash);
        hash = rhi::Checksum(shader.compressed, hash);
    }
    return hash;
}

uint64_t HashOfEmbeddedShaders() {
    static const uint64_t hash = HashOf(EmbeddedShaders());
    return hash;
}

}  // namespace raygraph
