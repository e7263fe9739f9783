#include "renderer/gpu_scene/record_table.h"

#include <algorithm>
#include <array>
#include <bit>
#include <stdexcept>
#include <utility>

#include "rhi/command_list.h"

namespace raygraph {
namespace {

// Above this number, records are scattered by a shader: each copy is a command of its own.
constexpr size_t kMaxCopies = 32;
// Above this number, the whole table is copied: any device dispatches 65,535 workgroups of scatter.comp.
constexpr size_t kMaxScattered = 65'535 * 128;

// Holds the push constants of shaders/scene/scatter.comp.
struct ScatterConstants {
    uint32_t count;
    uint32_t words;  // per record
};

}  // namespace

RecordTable::RecordTable(rhi::Device& device, const RecordTableDesc& desc)
    : m_device(&device),
      m_desc(desc),
      m_buffer(
          device.CreateBuffer({.name = desc.name,
                               .size = std::max<size_t>(1, desc.capacity) * desc.recordBytes,
                               .usage = desc.usage | rhi::BufferUsage::Storage |
                                        rhi::BufferUsage::CopySource | rhi::BufferUsage::CopyDestination})),
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

// --- SlotRanges ---

namespace {

constexpr uint32_t kMaxSlots = 1u << 31;

}  // namespace

size_t SlotRanges::ListOf(uint32_t count) {
    static_assert(kExact + 32 - std::bit_width(kExact) < kLists);
    return count <= kExact ? count - 1 : kExact + static_cast<size_t>(std::bit_width(count - 1) - 5);
}

void SlotRanges::Link(uint32_t first, uint32_t count) noexcept {
    uint32_t& head = m_lists[ListOf(count)];
    m_slots[first + count - 1].count = count;
    m_slots[first] = {.count = count, .next = head, .previous = kNone};
    if (head != kNone) m_slots[head].previous = first;
    head = first;
}

void SlotRanges::Unlink(uint32_t first) noexcept {
    const Slot range = m_slots[first];
    if (range.next != kNone) m_slots[range.next].previous = range.previous;
    (range.previous != kNone ? m_slots[range.previous].next : m_lists[ListOf(range.count)]) = range.next;
    m_slots[first].count = m_slots[first + range.count - 1].count = 0;
}

// Finds a free range of at least `count` slots. Every range in the lists after that of `count` is large
// enough.
uint32_t SlotRanges::Find(uint32_t count) const {
    for (size_t list = ListOf(count); list < kLists; ++list)
        for (uint32_t first = m_lists[list]; first != kNone; first = m_slots[first].next)
            if (m_slots[first].count >= count) return first;
    return kNone;
}

uint32_t SlotRanges::Allocate(uint32_t count) {
    if (count == 0) return 0;
    uint32_t first = Find(count);
    if (first != kNone) {
        const uint32_t there = m_slots[first].count;
        Unlink(first);
        if (there > count) Link(first + count, there - count);
    } else {
        if (count > kMaxSlots - m_end) throw std::length_error("more than 2^31 slots");
        first = m_end;
        const size_t end = size_t{m_end} + count;
        if (m_slots.size() < end) m_slots.resize(end);
        m_end += count;
    }
    m_taken += count;
    return first;
}

void SlotRanges::Free(uint32_t first, uint32_t count) noexcept {
    if (count == 0) return;
    m_taken -= count;
    if (first > 0 && m_slots[first - 1].count > 0) {  // the slot before is the last one of a free range
        const uint32_t before = m_slots[first - 1].count;
        first -= before;
        count += before;
        Unlink(first);
    }
    if (const uint32_t end = first + count; end == m_end) {
        m_end = first;
        return;
    }
    if (const uint32_t after = m_slots[first + count].count; after > 0) {
        Unlink(first + count);
        count += after;
    }
    Link(first, count);
}

}  // namespace raygraph
