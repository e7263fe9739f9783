#include "renderer/gpu_scene/record_table.h"

#include <algorithm>
#include <array>
#include <utility>

#include "rhi/command_list.h"

namespace raygraph {
namespace {

// Above this number, records are scattered by a shader: each copy is a command of its own.
constexpr size_t kMaxCopies = 32;
// Above this number, the whole table is copied: any device dispatches 65,535 workgroups of scatter.comp.
constexpr size_t kMaxScattered = 65'535 * 128;

// The push constants of shaders/scene/scatter.comp.
struct ScatterConstants {
    uint32_t count;
    uint32_t words;  // per record
};

}  // namespace

RecordTable::RecordTable(rhi::Device& device, const RecordTableDesc& desc)
    : m_device(&device),
      m_desc(desc),
      m_buffer(device.CreateBuffer(
          {.name = desc.name,
           .size = std::max<size_t>(1, desc.capacity) * desc.recordBytes,
           .usage = desc.usage | rhi::BufferUsage::Storage | rhi::BufferUsage::CopyDestination})),
      m_staging(device, desc.name + " staging") {}

RecordTable RecordTable::WithCapacity(size_t capacity) const {
    RecordTableDesc desc = m_desc;
    desc.capacity = capacity;
    RecordTable table(*m_device, desc);
    table.m_count = m_count;
    return table;
}

BufferId RecordTable::DeclareUpload(Renderer& renderer, BufferId table, Source source) {
    if (m_count == 0 || (!m_isAllDirty && source.changed == 0)) return table;
    // If more than half have changed, one large copy writes hardly more
    if (source.changed > std::min(m_count / 2, kMaxScattered)) AddAll();
    if (!m_isAllDirty && source.changed > kMaxCopies)
        return DeclareScatter(renderer, table, std::move(source));
    renderer.AddPass(
        m_desc.passName, PassKind::Transfer, [&](PassBuilder& pass) { table = pass.CopiesTo(table); },
        [this, source = std::move(source)](CommandList& commands) {
            source.prepare();
            if (m_isAllDirty)
                RecordCopyOfAll(commands, source);
            else
                RecordCopies(commands, source);
            MarkWritten(commands, source);
        });
    return table;
}

void RecordTable::RecordCopyOfAll(CommandList& commands, const Source& source) {
    // The device frees it once this frame has completed
    const rhi::Buffer staging = m_device->CreateBuffer({.name = m_desc.name + " staging",
                                                        .size = m_count * m_desc.recordBytes,
                                                        .usage = rhi::BufferUsage::CopySource,
                                                        .memory = rhi::MemoryKind::Upload});
    Writer writer({}, staging.Mapped(), m_desc.recordBytes);
    source.write(true, writer);
    commands.CopyBuffer(staging, 0, m_buffer, 0, staging.Size());
}

void RecordTable::RecordCopies(CommandList& commands, const Source& source) {
    const uint64_t bytes = m_desc.recordBytes;
    const rhi::Buffer& staging = m_staging.Take(source.changed * bytes);
    std::array<uint32_t, kMaxCopies> places;
    Writer writer(places, staging.Mapped(), bytes);
    source.write(false, writer);
    for (size_t i = 0; i < source.changed; ++i)
        commands.CopyBuffer(staging, i * bytes, m_buffer, places[i] * bytes, bytes);
    commands.OnSubmitted([this] { m_staging.MarkSubmitted(); });
}

// The staging memory holds the positions of all records, then the records.
BufferId RecordTable::DeclareScatter(Renderer& renderer, BufferId table, Source source) {
    const auto count = static_cast<uint32_t>(source.changed);
    const uint64_t placeBytes = source.changed * sizeof(uint32_t);
    const rhi::Buffer& staging = m_staging.Take(placeBytes + source.changed * m_desc.recordBytes);
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
            source.write(false, writer);
            commands.DispatchOver({count, 1});
            commands.OnSubmitted([this] { m_staging.MarkSubmitted(); });
            MarkWritten(commands, source);
        });
    return table;
}

void RecordTable::MarkWritten(CommandList& commands, const Source& source) {
    commands.OnSubmitted([this, done = source.done] {
        m_isAllDirty = false;
        done();
    });
}

}  // namespace raygraph
