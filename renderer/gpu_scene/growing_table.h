// A table on the device of records that the host has, too: it grows with them, and frames copy those that
// have changed. Threads: that of the Renderer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "renderer/gpu_scene/dirty_range.h"
#include "renderer/graph/renderer.h"
#include "rhi/device.h"
#include "rhi/upload.h"

namespace raygraph {

class GrowingTable {
  public:
    GrowingTable() = default;
    // Without records, and with room for none.
    GrowingTable(rhi::Device& device, std::string name, std::string passName, uint64_t recordBytes);

    // Room for as many records, at least: twice as many as before if it has to grow, and then all of them are
    // due. On an Error nothing has changed: Error{OutOfMemory} for more than a shader can bind.
    void Reserve(size_t count);
    // All records at once, by an uploader: nothing is due then.
    void Upload(rhi::Uploader& uploader, std::span<const std::byte> records);
    // They have changed on the host.
    void Mark(uint32_t record) { m_dirty.Add(record); }
    void Mark(uint32_t first, uint32_t count);

    // The table after all that is due, which stays due while the pass is culled or its frame dropped.
    // `records` are all that there are; neither they nor their place change until Execute.
    BufferId Declare(Renderer& renderer, std::span<const std::byte> records);
    const rhi::Buffer& Buffer() const { return m_buffer; }

  private:
    rhi::Device* m_device = nullptr;
    std::string m_name, m_passName;
    uint64_t m_recordBytes = 0;
    size_t m_capacity = 0;
    rhi::Buffer m_buffer;
    ResourceState m_state;
    DirtyRange m_dirty;
};

}  // namespace raygraph
