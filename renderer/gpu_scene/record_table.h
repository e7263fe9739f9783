// A table of records on the device, of which a frame changes none, few, many or all. What is written, by the
// host and by the device, is in proportion to what has changed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "renderer/gpu_scene/streaming/frame_staging.h"
#include "renderer/graph/renderer.h"
#include "rhi/device.h"
#include "rhi/resources.h"

namespace raygraph {

struct RecordTableDesc {
    std::string name = "records";                     // of the buffer
    std::string passName = "Upload";                  // of the pass that writes to it
    uint32_t recordBytes = 0;                         // a multiple of 4
    size_t capacity = 0;                              // records
    rhi::BufferUsage usage = rhi::BufferUsage::None;  // besides what the upload needs
};

class RecordTable {
  public:
    class Writer {
      public:
        // Where the record of this place in the table is to be written, all of it, and never to be read.
        std::span<std::byte> At(uint32_t place) {
            if (m_places.empty()) return m_records.subspan(uint64_t{place} * m_bytes, m_bytes);
            m_places[m_count] = place;
            return m_records.subspan(m_bytes * m_count++, m_bytes);
        }

      private:
        friend class RecordTable;
        Writer(std::span<uint32_t> places, std::span<std::byte> records, uint64_t bytes)
            : m_places(places), m_records(records), m_bytes(bytes) {}
        std::span<uint32_t> m_places;  // of the records, one after another; none: each is in its place
        std::span<std::byte> m_records;
        uint64_t m_bytes;  // of one
        size_t m_count = 0;
    };
    // What the table's owner does while the pass is recorded, and after that.
    struct Source {
        std::function<void()> prepare = [] {};  // before all else
        size_t changed = 0;                     // records that have
        // Writes these, each once; or all, from the first to the last that there is.
        std::function<void(bool areAll, Writer& writer)> write;
        std::function<void()> done = [] {};  // when it has been submitted
    };

    RecordTable() = default;
    RecordTable(rhi::Device& device, const RecordTableDesc& desc);

    // All are to be written, as they are at first.
    void AddAll() { m_isAllDirty = true; }
    bool IsAllDirty() const { return m_isAllDirty; }
    // How many records there are, up to the capacity; those beyond are not written.
    void SetCount(size_t count) { m_count = count; }
    size_t Capacity() const { return m_desc.capacity; }
    // The same with another capacity and all still to be written.
    RecordTable WithCapacity(size_t capacity) const;

    const rhi::Buffer& Buffer() const { return m_buffer; }
    BufferId Import(Renderer& renderer) { return renderer.Import(m_desc.name, m_buffer, m_state); }
    // Declares the pass, if there are changes, and returns the table after it: a copy of everything, a copy a
    // record or, for many of them, a compute pass that scatters them. Changes stay due while the pass is
    // culled or its frame dropped. The table may not be moved between this and Execute.
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

}  // namespace raygraph
