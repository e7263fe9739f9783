#include "rhi/specialized_shaders.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <system_error>

#include "base/atomic_file.h"
#include "base/path_text.h"
#include "base/read_file.h"
#include "base/text.h"
#include "rhi/checksum.h"
#include "rhi/shader_specializer.h"

namespace raygraph::rhi {
namespace {

namespace fs = std::filesystem;

// Of these, the pipelines of a scene take a few hundred kilobytes to a megabyte.
constexpr uint64_t kMaxFolderBytes = uint64_t{64} << 20;
constexpr uint64_t kMaxKeptBytes = uint64_t{64} << 20;
constexpr uint64_t kMaxFileBytes = uint64_t{16} << 20;
constexpr std::string_view kSuffix = ".spv";

// The header that precedes the words in the file, in the byte order of the machine.
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
    Say(m_log, LogLevel::Warning, log_category::kCache, "specialized shader {} is made again: {}", path,
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
        Say(m_log, LogLevel::Info, log_category::kCache, "specialized shader is not saved: {}", error.what());
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
