#include "rhi/device_cache.h"

#include <array>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <span>
#include <system_error>

#include "base/files.h"
#include "base/text.h"

namespace raygraph::rhi {
namespace {

// Holds the header before the driver's bytes in the file, in the machine's byte order.
struct FileHeader {
    std::array<char, 8> magic{'R', 'G', 'P', 'I', 'P', 'E', '0', '2'};
    uint64_t size = 0;
    uint64_t checksum = 0;
};

// No cache should be larger than this; NVIDIA's limit for its disk cache is of this order.
constexpr uint64_t kMaxFileBytes = uint64_t{1} << 30;

std::string Hex(std::span<const uint8_t> bytes) {
    constexpr char kDigits[] = "0123456789abcdef";
    std::string text;
    for (const uint8_t b : bytes) text += {kDigits[b >> 4], kDigits[b & 15]};
    return text;
}

std::string Hex(uint32_t value) {
    const std::array<uint8_t, 4> bytes{static_cast<uint8_t>(value >> 24), static_cast<uint8_t>(value >> 16),
                                       static_cast<uint8_t>(value >> 8), static_cast<uint8_t>(value)};
    return Hex(std::span<const uint8_t>(bytes));
}

}  // namespace

std::filesystem::path PipelineCacheFolder(const std::filesystem::path& configured) {
    if (!configured.empty()) return configured;
    return CacheFolder();
}

PipelineCacheFile::PipelineCacheFile(const std::filesystem::path& folder,
                                     const VkPhysicalDeviceProperties& device) {
    m_expected.headerSize = sizeof(VkPipelineCacheHeaderVersionOne);
    m_expected.headerVersion = VK_PIPELINE_CACHE_HEADER_VERSION_ONE;
    m_expected.vendorID = device.vendorID;
    m_expected.deviceID = device.deviceID;
    std::memcpy(m_expected.pipelineCacheUUID, device.pipelineCacheUUID, VK_UUID_SIZE);
    if (!folder.empty())
        m_path = folder / ("pipelines-" + Hex(device.vendorID) + "-" + Hex(device.deviceID) + "-" +
                           Hex(std::span<const uint8_t>(device.pipelineCacheUUID)) + ".bin");
}

std::string PipelineCacheFile::Refusal(std::span<const std::byte> file) const {
    FileHeader header;
    const FileHeader ours;
    if (file.size() < sizeof(header)) return "it is shorter than its header";
    std::memcpy(&header, file.data(), sizeof(header));
    if (header.magic != ours.magic) return "it is no pipeline cache of this version";
    const std::span<const std::byte> bytes = file.subspan(sizeof(header));
    if (bytes.size() != header.size) return Text("it has {} bytes instead of {}", bytes.size(), header.size);
    if (Checksum(bytes) != header.checksum) return "its checksum is wrong";
    if (bytes.size() < sizeof(m_expected) || std::memcmp(bytes.data(), &m_expected, sizeof(m_expected)) != 0)
        return "it is of another device or driver";
    return {};
}

PipelineCacheFile::Loaded PipelineCacheFile::Load() {
    Loaded loaded;
    std::error_code failure;
    if (m_path.empty() || !std::filesystem::exists(m_path, failure)) return loaded;
    try {
        std::vector<std::byte> file = ReadFile(m_path, kMaxFileBytes);
        loaded.problem = Refusal(file);
        if (loaded.problem.empty()) {
            FileHeader header;
            std::memcpy(&header, file.data(), sizeof(header));
            m_savedChecksum = header.checksum;
            m_savedSize = header.size;
            loaded.bytes.assign(file.begin() + sizeof(FileHeader), file.end());
        } else {
            loaded.problem = Text("pipeline cache {} is ignored: {}", m_path, loaded.problem);
        }
    } catch (const Error& error) {
        loaded.problem = std::string("pipeline cache is ignored: ") + error.what();
    }
    return loaded;
}

std::string PipelineCacheFile::Save(std::span<const std::byte> bytes) {
    if (m_path.empty()) return "there is no folder for the pipeline cache";
    FileHeader header;
    header.size = bytes.size();
    header.checksum = Checksum(bytes);
    if (header.size == m_savedSize && header.checksum == m_savedChecksum) return {};
    std::error_code failure;
    std::filesystem::create_directories(m_path.parent_path(), failure);
    if (failure) return Text("{}: {}", m_path.parent_path(), failure.message());
    try {
        AtomicFile file(m_path);
        file.Write(std::as_bytes(std::span(&header, 1)));
        file.Write(bytes);
        file.Commit();
    } catch (const Error& error) {
        return error.what();
    }
    m_savedSize = header.size;
    m_savedChecksum = header.checksum;
    return {};
}

// --- Measurements ---

namespace {

std::map<std::string, double, std::less<>> ReadLines(const std::filesystem::path& file) {
    std::map<std::string, double, std::less<>> values;
    std::ifstream stream(file);
    for (std::string text; std::getline(stream, text);) {
        const size_t tab = text.find('\t');
        if (tab == std::string::npos) continue;
        double value = 0.0;
        const char* const end = text.data() + text.size();
        const auto [parsed, error] = std::from_chars(text.data() + tab + 1, end, value);
        if (error == std::errc{} && parsed == end) values[text.substr(0, tab)] = value;
    }
    return values;
}

}  // namespace

void Measurements::SetFile(std::filesystem::path file) {
    const std::lock_guard lock(m_mutex);
    m_file = std::move(file);
    m_values.merge(ReadLines(m_file));
}

std::optional<double> Measurements::Find(std::string_view name) const {
    const std::lock_guard lock(m_mutex);
    const auto found = m_values.find(name);
    return found != m_values.end() ? std::optional(found->second) : std::nullopt;
}

void Measurements::Set(std::string_view name, double value) {
    const std::lock_guard lock(m_mutex);
    m_values.insert_or_assign(std::string(name), value);
    if (m_file.empty()) return;
    std::string text;
    for (const auto& [known, number] : m_values) text += Text("{}\t{}\n", known, number);
    try {
        std::filesystem::create_directories(m_file.parent_path());
        AtomicFile file(m_file);
        file.Write(std::as_bytes(std::span(text)));
        file.Commit();
    } catch (const std::exception&) {
        // The number is measured again
    }
}

}  // namespace raygraph::rhi
