// PipelineCacheFile: keeps a driver's pipeline cache on disk between runs.
//
// One file a device model and driver version, named by vendor, device and pipelineCacheUUID. The driver's
// bytes are wrapped in an additional header with their size and checksum, and the driver's own header is
// compared with the device, so that a damaged or foreign file never reaches the driver. Not thread-safe.
// Never throws.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "rhi/vulkan.h"

namespace raygraph::rhi {

// Returns `configured` if it is not empty, else $XDG_CACHE_HOME/raygraph, else ~/.cache/raygraph; empty if
// there is neither.
std::filesystem::path PipelineCacheFolder(const std::filesystem::path& configured);

class PipelineCacheFile {
  public:
    PipelineCacheFile() = default;  // no file: Load returns nothing, Save fails
    PipelineCacheFile(const std::filesystem::path& folder, const VkPhysicalDeviceProperties& device);

    const std::filesystem::path& Path() const { return m_path; }

    struct Loaded {
        std::vector<std::byte> bytes;  // for VkPipelineCacheCreateInfo::pInitialData
        std::string problem;           // why an existing file was ignored; empty: no file, or a good one
    };
    Loaded Load();

    // Writes to a temporary name and renames; does nothing if the bytes are those on disk already. Returns
    // the reason for a failure, or an empty text.
    std::string Save(std::span<const std::byte> bytes);

  private:
    std::string Refusal(std::span<const std::byte> file) const;

    std::filesystem::path m_path;
    VkPipelineCacheHeaderVersionOne m_expected{};
    uint64_t m_savedChecksum = 0;
    uint64_t m_savedSize = 0;
};

}  // namespace raygraph::rhi
