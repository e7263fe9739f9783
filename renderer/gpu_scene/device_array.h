// Arrays of records on the device, and how frames change them. Threads: that of the Renderer.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "renderer/graph/renderer.h"
#include "rhi/command_list.h"
#include "rhi/device.h"
#include "rhi/transfer.h"

namespace raygraph {

// Creates a buffer that shaders read, and that copies write and tests read. It has room for at least one
// record, because an empty buffer cannot be bound. Throws Error{OutOfMemory} if a shader cannot bind `count`
// records.
rhi::Buffer CreateTable(rhi::Device& device, const char* name, uint64_t count, uint64_t recordBytes);

// Returns the capacity of a table that has to grow to `count` records: twice its capacity, as far as shaders
// can bind that. Throws Error{OutOfMemory} naming the table if they cannot bind `count`.
uint64_t GrownCount(const rhi::Device& device, const std::string& name, uint64_t count, uint64_t capacity,
                    uint64_t recordBytes);

struct TableCopy {
    std::span<const std::byte> bytes;
    const rhi::Buffer& target;
    uint64_t offset = 0;  // in the target
};
// Copies through staging memory, which the device frees once the list has completed.
void RecordCopies(rhi::CommandList& commands, rhi::Device& device, const char* stagingName,
                  std::span<const TableCopy> copies);

// The device's half of a DeviceArray.
class DeviceArrayBuffer {
  public:
    DeviceArrayBuffer() = default;
    DeviceArrayBuffer(rhi::Device& device, std::string name, std::string passName, uint64_t recordBytes);

    // Makes room for at least `count` records. If the buffer has to grow, all records become dirty.
    void Reserve(size_t count);
    void Upload(rhi::Uploader& uploader, std::span<const std::byte> records);
    void Mark(uint32_t first, uint32_t count);
    BufferId Declare(Renderer& renderer, std::span<const std::byte> records);
    uint64_t Bytes() const { return m_buffer.Size(); }

  private:
    rhi::Device* m_device = nullptr;
    std::string m_name, m_passName;
    uint64_t m_recordBytes = 0;
    size_t m_capacity = 0;
    rhi::Buffer m_buffer;
    ResourceState m_state;
    uint32_t m_firstDirty = 0, m_endDirty = 0;  // from the first to the last record that has changed
};

// Records that both the host and the device have. Both copies grow, and a frame copies the range from the
// first to the last dirty record to the device. RecordTable is for records that the host does not keep, or of
// which scattered ones change.
template <typename T>
class DeviceArray {
  public:
    // Makes an array that the host alone has: it cannot be uploaded or declared.
    DeviceArray() = default;
    DeviceArray(rhi::Device& device, std::string name, std::string passName)
        : m_onDevice(device, std::move(name), std::move(passName), sizeof(T)) {}

    size_t Size() const { return m_records.size(); }
    const T& operator[](size_t index) const { return m_records[index]; }
    std::span<const T> Records() const { return m_records; }

    // Returns the record and marks it dirty.
    T& Edit(size_t index) {
        m_onDevice.Mark(static_cast<uint32_t>(index), 1);
        return m_records[index];
    }
    void Write(uint32_t first, std::span<const T> records) {
        m_onDevice.Mark(first, static_cast<uint32_t>(records.size()));
        std::ranges::copy(records, m_records.begin() + first);
    }
    // Makes the array at least `count` records long; new records are T{}. Here and below, an Error leaves the
    // array unchanged: Error{OutOfMemory} for more than a shader can bind, or than memory has.
    void Grow(size_t count) {
        if (count <= m_records.size()) return;
        m_onDevice.Reserve(count);
        m_records.resize(count);
    }
    // Replaces all records.
    void Assign(std::vector<T>&& records) {
        m_onDevice.Reserve(records.size());
        m_records = std::move(records);
        m_onDevice.Mark(0, static_cast<uint32_t>(m_records.size()));
    }
    // Makes room on the device for `count` records before Grow or Assign.
    void Reserve(size_t count) { m_onDevice.Reserve(count); }
    // Frees the host's records, not the device's.
    void Clear() { m_records = {}; }

    // Uploads all records at once, after which none is dirty.
    void Upload(rhi::Uploader& uploader) { m_onDevice.Upload(uploader, std::as_bytes(Records())); }
    // Returns the array with all dirty records copied. They stay dirty while the pass is culled or its frame
    // is dropped. No record may be changed or added until Execute.
    BufferId Declare(Renderer& renderer) { return m_onDevice.Declare(renderer, std::as_bytes(Records())); }
    uint64_t DeviceBytes() const { return m_onDevice.Bytes(); }

  private:
    std::vector<T> m_records;
    DeviceArrayBuffer m_onDevice;
};

}  // namespace raygraph
