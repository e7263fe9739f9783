#include "renderer/gpu_scene/device_table.h"

#include <algorithm>

#include "renderer/gpu_scene/device_limits.h"

namespace raygraph {

rhi::Buffer CreateTable(rhi::Device& device, const char* name, uint64_t count, uint64_t recordBytes) {
    RequireBindable(device, name, count, recordBytes);
    return device.CreateBuffer({.name = name,
                                .size = std::max<uint64_t>(1, count) * recordBytes,
                                .usage = rhi::BufferUsage::Storage | rhi::BufferUsage::CopySource |
                                         rhi::BufferUsage::CopyDestination});
}

uint64_t GrownCount(const rhi::Device& device, const std::string& name, uint64_t count, uint64_t capacity,
                    uint64_t recordBytes) {
    RequireBindable(device, name, count, recordBytes);
    return std::max(count, std::min(2 * capacity, device.Info().maxStorageBufferBytes / recordBytes));
}

void RecordCopies(rhi::CommandList& commands, rhi::Device& device, const char* stagingName,
                  std::span<const TableCopy> copies) {
    uint64_t bytes = 0;
    for (const TableCopy& copy : copies) bytes += copy.bytes.size();
    if (bytes == 0) return;
    rhi::Buffer staging = device.CreateBuffer({.name = stagingName,
                                               .size = bytes,
                                               .usage = rhi::BufferUsage::CopySource,
                                               .memory = rhi::MemoryKind::Upload});
    uint64_t offset = 0;
    for (const TableCopy& copy : copies) {
        if (copy.bytes.empty()) continue;
        std::ranges::copy(copy.bytes, staging.Mapped().begin() + static_cast<ptrdiff_t>(offset));
        commands.CopyBuffer(staging, offset, copy.target, copy.offset, copy.bytes.size());
        offset += copy.bytes.size();
    }
}

}  // namespace raygraph
