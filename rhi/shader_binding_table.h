// The layout of a shader binding table, as arithmetic without a device.
//
// clang-format off
//   buffer  +--------------------------------------------------------+
//   rayGen  | handle | data ...                         | padding    |  1 record, size == stride
//           +--------------------------------------------------------+  each region starts at baseAlignment
//   miss    | ray type 0: handle | data ... | padding                |
//           | ray type 1: handle | data ... | padding                |  one record a ray type
//           +--------------------------------------------------------+
//   hit     | set 0, ray type 0: handle | data ... | padding         |
//           | set 0, ray type 1: handle | data ... | padding         |  ray types adjacent: an instance
//           | set 1, ray type 0: handle | data ... | padding         |  points at the first record of its hit
//           | set 1, ray type 1: handle | data ... | padding         |  set; traceRayEXT adds the ray type
//           +--------------------------------------------------------+
//   call    | callable 0: handle | data ... | padding                |
//           +--------------------------------------------------------+
// clang-format on
//
// All records of a region have the same stride: handle plus the largest data of the region, rounded up
// to handleAlignment.
//
// In shaders, sbtRecordOffset and missIndex are the ray type. With an sbtRecordStride of 0, every geometry of
// an instance uses the hit set of the instance. With the number of ray types instead, geometry g of a BLAS
// uses the g-th hit set after that of the instance, and each of these sets must exist: reading past the table
// is undefined behavior. Threads: plain values and pure functions, for any thread.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>

#include "base/error.h"

namespace raygraph::rhi {

// Properties from VkPhysicalDeviceRayTracingPipelinePropertiesKHR; alignments are powers of two.
struct TableProperties {
    uint32_t handleSize = 32;
    uint32_t handleAlignment = 32;
    uint32_t baseAlignment = 64;
    uint32_t maxStride = 4096;
};

// Records of one kind; offsets count from the start of the table. An empty region is all zeros.
struct TableRegion {
    uint64_t offset = 0;
    uint64_t stride = 0;
    uint64_t size = 0;
    uint32_t recordCount = 0;

    constexpr uint64_t RecordOffset(uint32_t record) const { return offset + stride * record; }
    bool operator==(const TableRegion&) const = default;
};

struct TableLayout {
    TableRegion rayGen;
    TableRegion miss;
    TableRegion hit;
    TableRegion callable;
    uint64_t size = 0;  // bytes of the whole table, whose start must be aligned to baseAlignment
};

// Holds the number of bytes of data in each record. `rayGen` is a single record.
struct TableRecords {
    uint32_t rayGen = 0;
    std::span<const uint32_t> miss{};
    std::span<const uint32_t> hit{};
    std::span<const uint32_t> callable{};
};

constexpr uint64_t AlignUp(uint64_t value, uint64_t alignment) {
    return (value + alignment - 1) / alignment * alignment;
}

// Throws Error{Usage} if a record is longer than maxStride.
constexpr TableLayout LayOutTable(const TableProperties& properties, const TableRecords& records) {
    uint64_t end = 0;
    auto place = [&](std::span<const uint32_t> dataBytes) {
        TableRegion region;
        if (dataBytes.empty()) return region;
        uint32_t largest = *std::max_element(dataBytes.begin(), dataBytes.end());
        region.offset = AlignUp(end, properties.baseAlignment);
        region.stride = AlignUp(uint64_t{properties.handleSize} + largest, properties.handleAlignment);
        region.recordCount = static_cast<uint32_t>(dataBytes.size());
        region.size = region.stride * region.recordCount;
        if (region.stride > properties.maxStride)
            throw Error(ErrorKind::Usage,
                        "shader binding table: a record of " + std::to_string(region.stride) +
                            " bytes exceeds maxShaderGroupStride " + std::to_string(properties.maxStride));
        end = region.offset + region.size;
        return region;
    };
    TableLayout layout;
    layout.rayGen = place(std::span(&records.rayGen, 1));
    layout.miss = place(records.miss);
    layout.hit = place(records.hit);
    layout.callable = place(records.callable);
    layout.size = end;
    return layout;
}

}  // namespace raygraph::rhi
