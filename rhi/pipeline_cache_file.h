// PipelineCacheFile: keeps a driver's pipeline cache on disk between runs.
//
// There is one file per device model and driver version, named by vendor, device and pipelineCacheUUID. The
// driver's bytes are preceded by a header with their size and checksum, and the driver's own header is
// compared with the device, so that a damaged or foreign file never reaches the driver. Never throws.
// Threads: one at a time.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "rhi/vulkan.h"

namespace raygraph::rhi {

// Returns `configured` if it is not empty, otherwise $XDG_CACHE_HOME/raygraph or ~/.cache/raygraph; empty if
// neither variable is set.
std::filesystem::path PipelineCacheFolder(const std::filesystem::path& configured);

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

}  // namespace raygraph::rhi
