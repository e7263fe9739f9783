#include "renderer/gpu_scene/growing_table.h"

#include <algorithm>
#include <utility>

#include "base/check.h"
#include "renderer/gpu_scene/device_table.h"

namespace raygraph {

GrowingTable::GrowingTable(rhi::Device& device, std::string name, std::string passName, uint64_t recordBytes)
    : m_device(&device),
      m_name(std::move(name)),
      m_passName(std::move(passName)),
      m_recordBytes(recordBytes),
      m_buffer(CreateTable(device, m_name.c_str(), 0, recordBytes)) {}

void GrowingTable::Reserve(size_t count) {
    if (count <= m_capacity) return;
    const size_t capacity = GrownCount(*m_device, m_name, count, m_capacity, m_recordBytes);
    m_buffer = CreateTable(*m_device, m_name.c_str(), capacity, m_recordBytes);
    m_capacity = capacity;
    m_state = {};
    Mark(0, static_cast<uint32_t>(count));
}

void GrowingTable::Upload(rhi::Uploader& uploader, std::span<const std::byte> records) {
    RG_CHECK_LE(records.size(), m_capacity * m_recordBytes);
    if (!records.empty()) uploader.UploadBuffer(m_buffer, 0, records);
    m_state = {};
    m_dirty = {};
}

void GrowingTable::Mark(uint32_t first, uint32_t count) {
    if (count == 0) return;
    m_dirty.Add(first);
    m_dirty.Add(first + count - 1);
}

BufferId GrowingTable::Declare(Renderer& renderer, std::span<const std::byte> records) {
    BufferId table = renderer.Import(m_name, m_buffer, m_state);
    if (m_dirty.IsEmpty()) return table;
    renderer.AddPass(
        m_passName, PassKind::Transfer, [&](PassBuilder& pass) { table = pass.CopiesTo(table); },
        [this, records](CommandList& commands) {
            // There may be fewer than when they were marked
            const uint64_t end = std::min<uint64_t>(m_dirty.end * m_recordBytes, records.size());
            const uint64_t offset = std::min<uint64_t>(m_dirty.first * m_recordBytes, end);
            const TableCopy copy{records.subspan(offset, end - offset), m_buffer, offset};
            RecordCopies(commands, *m_device, (m_name + " staging").c_str(), {&copy, 1});
            commands.OnSubmitted([this] { m_dirty = {}; });
        });
    return table;
}

}  // namespace raygraph
