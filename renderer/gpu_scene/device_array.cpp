#include "renderer/gpu_scene/device_array.h"

#include "base/check.h"
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

DeviceArrayBuffer::DeviceArrayBuffer(rhi::Device& device, std::string name, std::string passName,
                                     uint64_t recordBytes)
    : m_device(&device),
      m_name(std::move(name)),
      m_passName(std::move(passName)),
      m_recordBytes(recordBytes),
      m_buffer(CreateTable(device, m_name.c_str(), 0, recordBytes)) {}

void DeviceArrayBuffer::Reserve(size_t count) {
    if (!m_device || count <= m_capacity) return;
    const size_t capacity = GrownCount(*m_device, m_name, count, m_capacity, m_recordBytes);
    m_buffer = CreateTable(*m_device, m_name.c_str(), capacity, m_recordBytes);
    m_capacity = capacity;
    m_state = {};
    Mark(0, static_cast<uint32_t>(count));
}

void DeviceArrayBuffer::Upload(rhi::Uploader& uploader, std::span<const std::byte> records) {
    RG_CHECK_LE(records.size(), m_capacity * m_recordBytes);
    if (!records.empty()) uploader.UploadBuffer(m_buffer, 0, records);
    m_state = {};
    m_firstDirty = m_endDirty = 0;
}

void DeviceArrayBuffer::Mark(uint32_t first, uint32_t count) {
    if (count == 0) return;
    m_firstDirty = m_firstDirty == m_endDirty ? first : std::min(m_firstDirty, first);
    m_endDirty = std::max(m_endDirty, first + count);
}

BufferId DeviceArrayBuffer::Declare(Renderer& renderer, std::span<const std::byte> records) {
    BufferId table = renderer.Import(m_name, m_buffer, m_state);
    if (m_firstDirty == m_endDirty) return table;
    renderer.AddPass(
        m_passName, PassKind::Transfer, [&](PassBuilder& pass) { table = pass.CopiesTo(table); },
        [this, records](CommandList& commands) {
            // The array may have shrunk since the records were marked
            const uint64_t end = std::min<uint64_t>(m_endDirty * m_recordBytes, records.size());
            const uint64_t offset = std::min<uint64_t>(m_firstDirty * m_recordBytes, end);
            const TableCopy copy{records.subspan(offset, end - offset), m_buffer, offset};
            RecordCopies(commands, *m_device, (m_name + " staging").c_str(), {&copy, 1});
            commands.OnSubmitted([this] { m_firstDirty = m_endDirty = 0; });
        });
    return table;
}

}  // namespace raygraph
