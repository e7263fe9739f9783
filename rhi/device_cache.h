// Files that rhi/ keeps on disk between runs: a driver's pipeline cache (PipelineCacheFile) and numbers that
// were measured on a device (Measurements), with the checksum that guards such files. Threads: a
// PipelineCacheFile: one at a time; all else: any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "rhi/vulkan.h"

namespace raygraph::rhi {

// Returns `configured` if it is not empty, otherwise $XDG_CACHE_HOME/raygraph or ~/.cache/raygraph; empty if
// neither variable is set.
std::filesystem::path PipelineCacheFolder(const std::filesystem::path& configured);

// PipelineCacheFile keeps a driver's pipeline cache on disk between runs.
//
// There is one file per device model and driver version, named by vendor, device and pipelineCacheUUID. The
// driver's bytes are preceded by a header with their size and checksum, and the driver's own header is
// compared with the device, so that a damaged or foreign file never reaches the driver. Never throws.
class PipelineCacheFile {
  public:
    PipelineCacheFile() = default;  // without a file, Load returns nothing and Save fails
    PipelineCacheFile(const std::filesystem::path& folder, const VkPhysicalDeviceProperties& device);

    const std::filesystem::path& Path() const { return m_path; }

    struct Loaded {
        std::vector<std::byte> bytes;  // for VkPipelineCacheCreateInfo::pInitialData
        std::string problem;  // why an existing file was ignored; empty if it is valid or does not exist
    };
    Loaded Load();

    // Writes to a temporary name and renames; does nothing if the file has these bytes already. Returns the
    // reason for a failure, or an empty text.
    std::string Save(std::span<const std::byte> bytes);

  private:
    std::string Refusal(std::span<const std::byte> file) const;

    std::filesystem::path m_path;
    VkPipelineCacheHeaderVersionOne m_expected{};
    uint64_t m_savedChecksum = 0;
    uint64_t m_savedSize = 0;
};

// Measurements: numbers that are measured once on a device, and kept on disk for later processes.
//
// There is one text file per device model and driver version, named as that of the pipeline cache. Its lines
// have a name, a tab and the number. Never throws except for lack of memory.
class Measurements {
  public:
    // Numbers are kept in memory alone until a file is set.
    void SetFile(std::filesystem::path file);

    std::optional<double> Find(std::string_view name) const;
    // The name has neither a tab nor a line break. If processes write at the same time, the numbers of the
    // last one stay. A failure to write is ignored: the number is measured again next time.
    void Set(std::string_view name, double value);

  private:
    mutable std::mutex m_mutex;
    std::filesystem::path m_file;
    std::map<std::string, double, std::less<>> m_values;
};

// --- The checksum of files that are read back, and of the keys by which they are found ---

inline constexpr uint64_t kChecksumStart = 0xcbf29ce484222325ull;

// Returns the 64-bit FNV-1a checksum. For data in several parts, pass the checksum of the parts before as
// `before`.
inline uint64_t Checksum(std::span<const std::byte> bytes, uint64_t before = kChecksumStart) {
    uint64_t hash = before;
    for (const std::byte b : bytes) hash = (hash ^ static_cast<uint64_t>(b)) * 0x100000001b3ull;
    return hash;
}

}  // namespace raygraph::rhi
