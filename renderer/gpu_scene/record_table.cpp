#include "renderer/gpu_scene/record_table.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "rhi/command_list.h"

namespace raygraph {
namespace {

// More are scattered: each copy is a command of its own.
constexpr size_t kMaxCopies = 32;

// Of shaders/scene/scatter.comp.
struct ScatterConstants {
    uint32_t count;
    uint32_t words;  // of a record
};

}  // namespace

RecordTable::RecordTable(rhi::Device& device, const RecordTableDesc& desc)
    : m_device(&device),
      m_desc(desc),
      m_buffer(device.CreateBuffer(
          {.name = desc.name,
           .size = std::max<size_t>(1, desc.recordCount) * desc.recordBytes,
           .usage = desc.usage | rhi::BufferUsage::Storage | rhi::BufferUsage::CopyDestination})),
      m_changed(desc.itemCount),
      m_staging(device, desc.name + " staging") {}

BufferId RecordTable::DeclareUpload(Renderer& renderer, BufferId table, Source source) {
    if (!HasChanges()) return table;
    // Of more than half, one large copy writes little else
    if (m_changedRecords > m_desc.recordCount / 2) AddAll();
    if (!m_areAllDue && m_changedRecords > kMaxCopies)
        return DeclareScatter(renderer, table, std::move(source));
    renderer.AddPass(
        m_desc.passName, PassKind::Transfer, [&](PassBuilder& pass) { table = pass.CopiesTo(table); },
        [this, source = std::move(source)](CommandList& commands) {
            source.prepare();
            if (m_areAllDue)
                RecordCopyOfAll(commands, source);
            else
                RecordCopies(commands, source);
            NoteWritten(commands);
        });
    return table;
}

void RecordTable::RecordCopyOfAll(CommandList& commands, const Source& source) {
    // Freed by the device once this frame has completed
    const rhi::Buffer staging = m_device->CreateBuffer({.name = m_desc.name + " staging",
                                                        .size = m_desc.recordCount * m_desc.recordBytes,
                                                        .usage = rhi::BufferUsage::CopySource,
                                                        .memory = rhi::MemoryKind::Upload});
    Writer writer({}, staging.Mapped(), m_desc.recordBytes);
    std::array<uint32_t, 256> items;
    for (size_t first = 0; first < m_desc.itemCount; first += items.size()) {
        const size_t count = std::min(items.size(), m_desc.itemCount - first);
        std::iota(items.begin(), items.end(), static_cast<uint32_t>(first));
        source.write(std::span(items).first(count), writer);
    }
    commands.CopyBuffer(staging, 0, m_buffer, 0, staging.Size());
}

void RecordTable::RecordCopies(CommandList& commands, const Source& source) {
    const uint64_t bytes = m_desc.recordBytes;
    const rhi::Buffer& staging = m_staging.Take(m_changedRecords * bytes);
    std::array<uint32_t, kMaxCopies> places;
    Writer writer(places, staging.Mapped(), bytes);
    source.write(m_changed.List(), writer);
    for (size_t i = 0; i < m_changedRecords; ++i)
        commands.CopyBuffer(staging, i * bytes, m_buffer, places[i] * bytes, bytes);
    commands.OnSubmitted([this] { m_staging.NoteSubmitted(); });
}

// The staging memory has the places of all records, then the records.
BufferId RecordTable::DeclareScatter(Renderer& renderer, BufferId table, Source source) {
    const auto count = static_cast<uint32_t>(m_changedRecords);
    const uint64_t placeBytes = m_changedRecords * sizeof(uint32_t);
    const rhi::Buffer& staging = m_staging.Take(placeBytes + m_changedRecords * m_desc.recordBytes);
    m_scatteredState = {};
    const BufferId scattered = renderer.Import(m_desc.name + " scattered", staging, m_scatteredState);
    renderer.AddPass(
        m_desc.passName, PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("scene/scatter.comp");
            pass.Reads("scattered", scattered);
            table = pass.Updates("table", table);
            pass.Constants(ScatterConstants{count, m_desc.recordBytes / uint32_t{sizeof(uint32_t)}});
        },
        [this, count, placeBytes, &staging, source = std::move(source)](CommandList& commands) {
            source.prepare();
            const std::span<std::byte> mapped = staging.Mapped();
            Writer writer({reinterpret_cast<uint32_t*>(mapped.data()), count}, mapped.subspan(placeBytes),
                          m_desc.recordBytes);
            source.write(m_changed.List(), writer);
            commands.DispatchOver({count, 1});
            commands.OnSubmitted([this] { m_staging.NoteSubmitted(); });
            NoteWritten(commands);
        });
    return table;
}

void RecordTable::NoteWritten(CommandList& commands) {
    commands.OnSubmitted([this] {
        m_changed.Clear();
        m_changedRecords = 0;
        m_areAllDue = false;
    });
}

}  // namespace raygraph
