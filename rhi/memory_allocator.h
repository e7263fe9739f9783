// MemoryAllocator: where a Device gets device memory. A host that manages all memory itself implements it
// (AdoptedDeviceDesc::memoryAllocator); other Devices have one on the Vulkan Memory Allocator. Threads: its
// functions are called from any thread, several at once.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/api.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

enum class MemoryKind : uint8_t {
    Device,    // fast on the device, not mapped
    Upload,    // mapped, written by the CPU in order, read by the device
    Readback,  // mapped and cached, written by the device, read by the CPU
};

// Describes the memory of one resource, or of a block that several share.
struct MemoryRequest {
    const char* name = "";  // of the resource or block
    // Mapped kinds need HOST_VISIBLE and HOST_COHERENT memory. Device should be DEVICE_LOCAL, but may be
    // other memory when that is full.
    MemoryKind kind = MemoryKind::Device;
    uint64_t alignment = 1;          // bytes, beside the alignment of the requirements
    bool mustBeDeviceLocal = false;  // never other memory
    bool isOnlyCopied = false;  // no shader accesses it, so that mapped memory need not be near the device
    bool isDedicated = false;   // the resource is large and lives long: an allocation of its own
};

struct MemoryAllocation {
    VkDeviceMemory memory = VK_NULL_HANDLE;
    uint64_t offset = 0;  // bytes in `memory`
    uint64_t size = 0;    // bytes
    uint32_t memoryType = 0;
    std::byte* mapped = nullptr;  // of mapped kinds
    void* handle = nullptr;       // for the allocator's own use
    bool isFallback = false;      // for the Device's own use

    explicit operator bool() const { return memory != VK_NULL_HANDLE; }
};

// The first three functions return the result of the Vulkan call that failed, and have then created nothing.
// Memory of buffers and blocks is allocated with VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT.
class RAYGRAPH_API MemoryAllocator {
  public:
    virtual ~MemoryAllocator() = default;
    // Creates the resource and binds it. The Device destroys the resource before it calls Free: both use
    // AdoptedDeviceDesc::allocationCallbacks.
    virtual VkResult CreateBuffer(const VkBufferCreateInfo& info, const MemoryRequest& request,
                                  VkBuffer& buffer, MemoryAllocation& memory) = 0;
    virtual VkResult CreateImage(const VkImageCreateInfo& info, const MemoryRequest& request, VkImage& image,
                                 MemoryAllocation& memory) = 0;
    // Allocates a block, to which the Device binds images and buffers at its offset.
    virtual VkResult Allocate(const VkMemoryRequirements& requirements, const MemoryRequest& request,
                              MemoryAllocation& memory) = 0;
    virtual void Free(const MemoryAllocation& memory) noexcept = 0;
};

}  // namespace raygraph::rhi
