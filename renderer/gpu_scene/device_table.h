// Tables of records on the device, and how frames change them. Threads: as rhi::Device says.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "rhi/command_list.h"
#include "rhi/device.h"

namespace raygraph {

// For shaders to read and copies to write, and to read in tests; one record at least, because an empty buffer
// cannot be bound. Error{OutOfMemory} if a shader cannot bind so many.
rhi::Buffer CreateTable(rhi::Device& device, const char* name, uint64_t count, uint64_t recordBytes);

// How many records a table gets that has to grow to `count`: twice what it has, as far as shaders can bind
// them.
// Error{OutOfMemory} naming it if they cannot bind `count`.
uint64_t GrownCount(const rhi::Device& device, const std::string& name, uint64_t count, uint64_t capacity,
                    uint64_t recordBytes);

struct TableCopy {
    std::span<const std::byte> bytes;
    const rhi::Buffer& target;
    uint64_t offset = 0;  // in the target
};
// Through staging memory, which the device frees once the list has completed.
void RecordCopies(rhi::CommandList& commands, rhi::Device& device, const char* stagingName,
                  std::span<const TableCopy> copies);

}  // namespace raygraph
