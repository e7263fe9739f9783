#include "rhi/shader_specializer.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <spirv.hpp>
#include <system_error>
#include <unordered_map>
#include <unordered_set>

#include "base/files.h"
#include "base/text.h"
#include "rhi/device_cache.h"

#ifdef RAYGRAPH_HAS_SPIRV_TOOLS
#include <spirv-tools/libspirv.h>
#include <spirv-tools/optimizer.hpp>
#endif

namespace raygraph::rhi {
namespace {

constexpr size_t kHeaderWords = 5;

// Calls visit(opcode, words of the instruction) for each instruction; stops at one that is truncated.
template <typename Words, typename Visit>
void ForEachInstruction(Words spirv, Visit visit) {
    for (size_t at = kHeaderWords; at < spirv.size();) {
        const size_t count = spirv[at] >> spv::WordCountShift;
        if (count == 0 || count > spirv.size() - at) return;
        visit(static_cast<spv::Op>(spirv[at] & spv::OpCodeMask), spirv.subspan(at, count));
        at += count;
    }
}

}  // namespace

std::vector<SpecializationValue> ValuesOf(std::span<const uint32_t> spirv,
                                          std::span<const SpecializationValue> values) {
    std::vector<SpecializationValue> own;
    ForEachInstruction(spirv, [&](spv::Op op, std::span<const uint32_t> words) {
        if (op != spv::OpDecorate || words.size() != 4 || words[2] != spv::DecorationSpecId) return;
        const auto value =
            std::find_if(values.begin(), values.end(), [&](const auto& v) { return v.id == words[3]; });
        if (value != values.end()) own.push_back(*value);
    });
    return own;
}

#ifndef RAYGRAPH_HAS_SPIRV_TOOLS

std::string SpecializerVersion() {
    return {};
}

std::vector<uint32_t> SpecializeSpirv(std::span<const uint32_t>, std::span<const SpecializationValue>) {
    return {};
}

#else

namespace {

// Returns the functions that do nothing except return a constant of the module, with that constant.
std::unordered_map<uint32_t, uint32_t> ConstantFunctions(std::span<const uint32_t> spirv) {
    std::unordered_map<uint32_t, uint32_t> found;
    std::unordered_set<uint32_t> constants;
    uint32_t function = 0;
    uint32_t returned = 0;  // no id is 0
    bool isPlain = false;
    ForEachInstruction(spirv, [&](spv::Op op, std::span<const uint32_t> words) {
        switch (op) {
            case spv::OpConstant:
            case spv::OpConstantTrue:
            case spv::OpConstantFalse:
            case spv::OpConstantComposite:
            case spv::OpConstantNull:
                constants.insert(words[2]);
                break;
            case spv::OpFunction:
                function = words[2];
                returned = 0;
                isPlain = true;
                break;
            case spv::OpReturnValue:
                if (constants.count(words[1]) == 0) isPlain = false;
                returned = words[1];
                break;
            case spv::OpFunctionEnd:
                if (isPlain && returned != 0) found[function] = returned;
                function = 0;
                break;
            case spv::OpFunctionParameter:
            case spv::OpLabel:
            case spv::OpBranch:
                break;
            default:
                isPlain = false;
        }
    });
    return found;
}

// Replaces each call of such a function by a copy of its result, through which constants propagate as they do
// not through calls. Returns false if there was no such call.
bool FoldConstantCalls(std::vector<uint32_t>& spirv) {
    const std::unordered_map<uint32_t, uint32_t> functions = ConstantFunctions(spirv);
    if (functions.empty()) return false;
    std::vector<uint32_t> folded(spirv.begin(), spirv.begin() + kHeaderWords);
    folded.reserve(spirv.size());
    ForEachInstruction(std::span<const uint32_t>(spirv), [&](spv::Op op, std::span<const uint32_t> words) {
        const auto called = op == spv::OpFunctionCall ? functions.find(words[3]) : functions.end();
        if (called == functions.end()) {
            folded.insert(folded.end(), words.begin(), words.end());
            return;
        }
        const uint32_t copy[]{4u << spv::WordCountShift | spv::OpCopyObject, words[1], words[2],
                              called->second};
        folded.insert(folded.end(), std::begin(copy), std::end(copy));
    });
    spirv = std::move(folded);
    return true;
}

bool Optimize(std::vector<uint32_t>& spirv, std::vector<spvtools::Optimizer::PassToken> passes) {
    spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_3);
    for (spvtools::Optimizer::PassToken& pass : passes) optimizer.RegisterPass(std::move(pass));
    spvtools::OptimizerOptions options;
    options.set_run_validator(false);  // glslang has validated the shaders
    options.set_preserve_bindings(true);
    std::vector<uint32_t> optimized;
    if (!optimizer.Run(spirv.data(), spirv.size(), &optimized, options)) return false;
    spirv = std::move(optimized);
    return true;
}

// Removes code that constants decide. Expressions that short-circuit on a constant become constant themselves
// once branches are gone, so that a round on branches comes first; the propagation is the slowest pass, and
// then has half as much to do.
std::vector<spvtools::Optimizer::PassToken> Pruning() {
    std::vector<spvtools::Optimizer::PassToken> passes;
    passes.push_back(spvtools::CreateDeadBranchElimPass());
    passes.push_back(spvtools::CreateEliminateDeadFunctionsPass());
    passes.push_back(spvtools::CreateCCPPass());
    passes.push_back(spvtools::CreateDeadBranchElimPass());
    passes.push_back(spvtools::CreateEliminateDeadFunctionsPass());
    constexpr bool kPreservesInterface = true;
    passes.push_back(spvtools::CreateAggressiveDCEPass(kPreservesInterface));
    return passes;
}

}  // namespace

std::string SpecializerVersion() {
    return RAYGRAPH_SPECIALIZER_HASH " " + std::string(spvSoftwareVersionDetailsString());
}

std::vector<uint32_t> SpecializeSpirv(std::span<const uint32_t> spirv,
                                      std::span<const SpecializationValue> values) {
    if (spirv.size() < kHeaderWords) return {};
    std::unordered_map<uint32_t, std::vector<uint32_t>> bits;
    for (const SpecializationValue& value : values) bits[value.id] = {value.value};

    std::vector<spvtools::Optimizer::PassToken> passes;
    passes.push_back(spvtools::CreateStripDebugInfoPass());
    passes.push_back(spvtools::CreateSetSpecConstantDefaultValuePass(bits));
    passes.push_back(spvtools::CreateFreezeSpecConstantValuePass());
    passes.push_back(spvtools::CreateFoldSpecConstantOpAndCompositePass());
    for (spvtools::Optimizer::PassToken& pass : Pruning()) passes.push_back(std::move(pass));
    std::vector<uint32_t> words(spirv.begin(), spirv.end());
    if (!Optimize(words, std::move(passes))) return {};

    // Each round makes more functions constant. Values that pass through variables are followed only when
    // less code is left, because that takes long.
    constexpr int kMaxRounds = 3;
    for (int round = 0; round < kMaxRounds; ++round) {
        if (!FoldConstantCalls(words) && round > 0) break;
        passes.clear();
        passes.push_back(spvtools::CreateSSARewritePass());
        for (spvtools::Optimizer::PassToken& pass : Pruning()) passes.push_back(std::move(pass));
        passes.push_back(spvtools::CreateEliminateDeadConstantPass());
        if (!Optimize(words, std::move(passes))) return {};
    }
    return words;
}

#endif

// --- SpecializedShaders ---

namespace {

namespace fs = std::filesystem;

// Limits of the cache folder; the pipelines of one scene take a few hundred kilobytes to a megabyte.
constexpr uint64_t kMaxFolderBytes = uint64_t{64} << 20;
constexpr uint64_t kMaxKeptBytes = uint64_t{64} << 20;
constexpr uint64_t kMaxFileBytes = uint64_t{16} << 20;
constexpr std::string_view kSuffix = ".spv";

// Holds the header that precedes the words in the file, in the byte order of the machine.
struct FileHeader {
    std::array<char, 8> magic{'R', 'G', 'S', 'P', 'V', 'S', '0', '1'};
    std::array<uint64_t, 2> key{};
    uint64_t size = 0;
    uint64_t checksum = 0;
};

uint64_t HashOf(std::span<const uint32_t> spirv, std::span<const SpecializationValue> values,
                const std::string& version, uint64_t start) {
    uint64_t hash = Checksum(std::as_bytes(std::span(version)), start);
    for (const SpecializationValue& value : values)
        hash = Checksum(std::as_bytes(std::span(&value, 1)), hash);
    return Checksum(std::as_bytes(spirv), hash);
}

// Returns why these bytes are not the words of that key; empty if they are.
std::string Refusal(std::span<const std::byte> file, const std::array<uint64_t, 2>& key) {
    FileHeader header;
    const FileHeader ours;
    if (file.size() < sizeof(header)) return "it is shorter than its header";
    std::memcpy(&header, file.data(), sizeof(header));
    if (header.magic != ours.magic) return "it is no specialized shader of this version";
    if (header.key != key) return "it is of another shader";
    const std::span<const std::byte> bytes = file.subspan(sizeof(header));
    if (bytes.size() != header.size) return Text("it has {} bytes instead of {}", bytes.size(), header.size);
    if (Checksum(bytes) != header.checksum) return "its checksum is wrong";
    if (bytes.empty() || bytes.size() % sizeof(uint32_t) != 0) return "it has no whole words";
    return {};
}

}  // namespace

SpecializedShaders::SpecializedShaders(const fs::path& folder, Log log, std::string version)
    : m_log(std::move(log)), m_version(std::move(version)) {
    if (!folder.empty()) m_folder = folder / "shaders";
}

SpecializedShaders::Words SpecializedShaders::Find(std::span<const uint32_t> spirv,
                                                   std::span<const SpecializationValue> values) {
    const std::vector<SpecializationValue> own = ValuesOf(spirv, values);
    if (own.empty() || m_version.empty()) return nullptr;
    const Key key{HashOf(spirv, own, m_version, kChecksumStart),
                  HashOf(spirv, own, m_version, ~kChecksumStart)};
    std::unique_lock lockOfMap(m_mutex);
    Shader& shader = m_shaders[key];
    lockOfMap.unlock();
    const std::lock_guard lock(shader.mutex);
    if (Words known = shader.words.lock()) return known;
    Words words = Load(key);
    if (!words) {
        std::vector<uint32_t> made = SpecializeSpirv(spirv, own);
        if (made.empty()) return nullptr;
        Save(key, made);
        words = std::make_shared<const std::vector<uint32_t>>(std::move(made));
    }
    shader.words = words;
    if (m_folder.empty() && (m_keptBytes += words->size() * sizeof(uint32_t)) <= kMaxKeptBytes)
        shader.kept = words;
    return words;
}

fs::path SpecializedShaders::FileOf(const Key& key) const {
    return m_folder / (Text("{:016x}", key.first) + std::string(kSuffix));
}

SpecializedShaders::Words SpecializedShaders::Load(const Key& key) const {
    std::error_code failure;
    if (m_folder.empty()) return nullptr;
    const fs::path path = FileOf(key);
    if (!fs::exists(path, failure)) return nullptr;
    std::string problem;
    try {
        const std::vector<std::byte> file = ReadFile(path, kMaxFileBytes);
        problem = Refusal(file, {key.first, key.second});
        if (problem.empty()) {
            // The most recently used file is kept longest.
            fs::last_write_time(path, fs::file_time_type::clock::now(), failure);
            std::vector<uint32_t> words((file.size() - sizeof(FileHeader)) / sizeof(uint32_t));
            std::memcpy(words.data(), file.data() + sizeof(FileHeader), words.size() * sizeof(uint32_t));
            return std::make_shared<const std::vector<uint32_t>>(std::move(words));
        }
    } catch (const Error& error) {
        problem = error.what();
    }
    WriteLog(m_log, LogLevel::Warning, log_category::kCache, "specialized shader {} is made again: {}", path,
             problem);
    return nullptr;
}

void SpecializedShaders::Save(const Key& key, const std::vector<uint32_t>& words) const {
    if (m_folder.empty()) return;
    const std::span<const std::byte> bytes = std::as_bytes(std::span(words));
    FileHeader header;
    header.key = {key.first, key.second};
    header.size = bytes.size();
    header.checksum = Checksum(bytes);
    std::error_code failure;
    fs::create_directories(m_folder, failure);  // writing the file reports a failure
    try {
        AtomicFile file(FileOf(key));
        file.Write(std::as_bytes(std::span(&header, 1)));
        file.Write(bytes);
        file.Commit();
    } catch (const Error& error) {
        // The pipeline cache warns once about the same folder.
        WriteLog(m_log, LogLevel::Info, log_category::kCache, "specialized shader is not saved: {}",
                 error.what());
        return;
    }
    RemoveOldFiles();
}

// Another process may do the same; failures are left for the next time.
void SpecializedShaders::RemoveOldFiles() const {
    struct File {
        fs::file_time_type time;
        uint64_t bytes = 0;
        fs::path path;
    };
    std::vector<File> files;
    uint64_t total = 0;
    std::error_code failure;
    for (fs::directory_iterator entry(m_folder, failure), end; !failure && entry != end;
         entry.increment(failure)) {
        std::error_code ignored;
        if (entry->path().extension() != kSuffix || !entry->is_regular_file(ignored)) continue;
        const uint64_t bytes = entry->file_size(ignored);
        if (ignored) continue;
        files.push_back({entry->last_write_time(ignored), bytes, entry->path()});
        total += bytes;
    }
    std::sort(files.begin(), files.end(), [](const File& a, const File& b) { return a.time < b.time; });
    for (const File& file : files) {
        if (total <= kMaxFolderBytes) return;
        if (fs::remove(file.path, failure)) total -= file.bytes;
    }
}

}  // namespace raygraph::rhi
