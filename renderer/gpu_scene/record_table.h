// RecordTable: a table of records on the device, of which a frame changes none, few, many or all. The host
// and the device write amounts in proportion to what has changed. SlotRanges allocates the slots of such
// tables. Threads: a table: that of the Renderer; SlotRanges: as std::vector.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "renderer/gpu_scene/streaming/frame_staging.h"
#include "renderer/graph/renderer.h"
#include "rhi/device.h"
#include "rhi/resources.h"

namespace raygraph {

struct RecordTableDesc {
    std::string name = "records";                     // name of the buffer
    std::string passName = "Upload";                  // name of the pass that writes to it
    uint32_t recordBytes = 0;                         // a multiple of 4
    size_t capacity = 0;                              // records
    rhi::BufferUsage usage = rhi::BufferUsage::None;  // added to the usage that the upload needs
};

class RecordTable {
  public:
    class Writer {
      public:
        // Returns where to write the whole record with index `place`. That memory must never be read.
        std::span<std::byte> At(uint32_t place) {
            if (m_places.empty()) return m_records.subspan(uint64_t{place} * m_bytes, m_bytes);
            m_places[m_count] = place;
            return m_records.subspan(m_bytes * m_count++, m_bytes);
        }

      private:
        friend class RecordTable;
        Writer(std::span<uint32_t> places, std::span<std::byte> records, uint64_t bytes)
            : m_places(places), m_records(records), m_bytes(bytes) {}
        std::span<uint32_t> m_places;  // indices of the records; empty if each is written at its own index
        std::span<std::byte> m_records;
        uint64_t m_bytes;  // bytes per record
        size_t m_count = 0;
    };
    // Holds the callbacks of the table's owner for one upload.
    struct Source {
        std::function<void()> prepare = [] {};  // called before everything else
        size_t changed = 0;                     // number of changed records
        // Writes the changed records, each once; or all of them, from the first to the last, if `writesAll`.
        std::function<void(bool writesAll, Writer& writer)> write;
        std::function<void()> done = [] {};  // called when the pass has been submitted
    };

    RecordTable() = default;
    RecordTable(rhi::Device& device, const RecordTableDesc& desc);

    // Marks all records dirty, which they are at first.
    void AddAll() { m_isAllDirty = true; }
    bool IsAllDirty() const { return m_isAllDirty; }
    // Sets the number of records, at most the capacity; no record beyond it is written.
    void SetCount(size_t count) { m_count = count; }
    size_t Capacity() const { return m_desc.capacity; }
    // Returns a table with the same description, another capacity, and all records dirty.
    RecordTable WithCapacity(size_t capacity) const;

    const rhi::Buffer& Buffer() const { return m_buffer; }
    BufferId Import(Renderer& renderer) { return renderer.Import(m_desc.name, m_buffer, m_state); }
    // Declares the pass, if there are changes, and returns the table after it. The pass makes one copy of
    // everything, one copy per record or, for many records, dispatches a compute shader that scatters them.
    // Changes stay dirty while the pass is culled or its frame is dropped. The table must not be moved
    // between this call and Execute.
    BufferId DeclareUpload(Renderer& renderer, BufferId table, Source source);

  private:
    void RecordCopyOfAll(CommandList& commands, const Source& source);
    void RecordCopies(CommandList& commands, const Source& source);
    BufferId DeclareScatter(Renderer& renderer, BufferId table, Source source);
    void MarkWritten(CommandList& commands, const Source& source);

    rhi::Device* m_device = nullptr;
    RecordTableDesc m_desc;
    rhi::Buffer m_buffer;
    ResourceState m_state;
    size_t m_count = 0;
    bool m_isAllDirty = true;
    FrameStaging m_staging;
    ResourceState m_scatteredState;
};

// SlotRanges allocates ranges of neighboring slots in a growing table: the instances of a scene, the groups
// of a mesh. Freed slots are reused before the table grows.
class SlotRanges {
  public:
    // Takes `count` neighboring slots and returns the first. They lie beyond End() only if no free range
    // before it is large enough. Takes nothing and returns 0 for a count of 0. Throws std::bad_alloc, or
    // std::length_error beyond 2^31 slots, and has then changed nothing.
    uint32_t Allocate(uint32_t count);
    // Frees slots that are taken: those of one Allocate, of several, or a part of them.
    void Free(uint32_t first, uint32_t count) noexcept;

    // Returns the index after the last slot that is taken; 0 if none is.
    uint32_t End() const { return m_end; }
    uint32_t TakenCount() const { return m_taken; }

  private:
    static constexpr uint32_t kNone = ~0u;
    // Free ranges are listed by size: one list for each size up to kExact, then one for each power of two.
    static constexpr uint32_t kExact = 16;
    static constexpr size_t kLists = 48;
    // The first slot of a free range has all fields, its last one `count` alone, and the others none.
    struct Slot {
        uint32_t count = 0;  // 0: taken
        uint32_t next = kNone, previous = kNone;
    };

    static size_t ListOf(uint32_t count);
    void Link(uint32_t first, uint32_t count) noexcept;
    void Unlink(uint32_t first) noexcept;
    uint32_t Find(uint32_t count) const;

    std::vector<Slot> m_slots;  // up to the greatest end so far; slots beyond m_end count as taken
    std::array<uint32_t, kLists> m_lists = Empty();
    uint32_t m_end = 0;
    uint32_t m_taken = 0;

    static constexpr std::array<uint32_t, kLists> Empty() {
        std::array<uint32_t, kLists> lists{};
        lists.fill(kNone);
        return lists;
    }
};

}  // namespace raygraph
