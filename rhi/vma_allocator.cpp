#include "rhi/vma_allocator.h"

#include "rhi/vma.h"

namespace raygraph::rhi {
namespace {

VmaAllocationCreateInfo AllocationInfo(const MemoryRequest& request) {
    VmaAllocationCreateInfo info{};
    info.usage = VMA_MEMORY_USAGE_AUTO;
    if (request.isDedicated) info.flags |= VMA_ALLOCATION_CREATE_DEDICATED_MEMORY_BIT;
    if (request.kind == MemoryKind::Device) {
        info.usage = VMA_MEMORY_USAGE_AUTO_PREFER_DEVICE;
        // The allocator might place it in other memory permanently.
        if (request.mustBeDeviceLocal) info.requiredFlags = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
        return info;
    }
    // Little of the device's own memory can be mapped. The allocator cannot know that a buffer is only
    // copied, because every buffer has an address that shaders might use.
    if (request.isOnlyCopied) info.usage = VMA_MEMORY_USAGE_AUTO_PREFER_HOST;
    info.flags |= VMA_ALLOCATION_CREATE_MAPPED_BIT |
                  (request.kind == MemoryKind::Upload ? VMA_ALLOCATION_CREATE_HOST_ACCESS_SEQUENTIAL_WRITE_BIT
                                                      : VMA_ALLOCATION_CREATE_HOST_ACCESS_RANDOM_BIT);
    info.requiredFlags = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    return info;
}

class VmaMemoryAllocator final : public MemoryAllocator {
  public:
    explicit VmaMemoryAllocator(VmaAllocator allocator) : m_allocator(allocator) {}
    ~VmaMemoryAllocator() override { vmaDestroyAllocator(m_allocator); }

    VkResult CreateBuffer(const VkBufferCreateInfo& info, const MemoryRequest& request, VkBuffer& buffer,
                          MemoryAllocation& memory) override {
        const VmaAllocationCreateInfo allocate = AllocationInfo(request);
        VkBuffer created = VK_NULL_HANDLE;  // undefined after a failure
        VmaAllocation allocation = nullptr;
        VmaAllocationInfo allocated{};
        const VkResult result = vmaCreateBufferWithAlignment(m_allocator, &info, &allocate, request.alignment,
                                                             &created, &allocation, &allocated);
        if (result != VK_SUCCESS) return result;
        buffer = created;
        memory = Describe(allocation, allocated);
        return result;
    }

    VkResult CreateImage(const VkImageCreateInfo& info, const MemoryRequest& request, VkImage& image,
                         MemoryAllocation& memory) override {
        const VmaAllocationCreateInfo allocate = AllocationInfo(request);
        VkImage created = VK_NULL_HANDLE;
        VmaAllocation allocation = nullptr;
        VmaAllocationInfo allocated{};
        const VkResult result =
            vmaCreateImage(m_allocator, &info, &allocate, &created, &allocation, &allocated);
        if (result != VK_SUCCESS) return result;
        image = created;
        memory = Describe(allocation, allocated);
        return result;
    }

    VkResult Allocate(const VkMemoryRequirements& requirements, const MemoryRequest& request,
                      MemoryAllocation& memory) override {
        VmaAllocationCreateInfo allocate{};  // the automatic usages need a resource
        allocate.preferredFlags = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
        VmaAllocation allocation = nullptr;
        VmaAllocationInfo allocated{};
        const VkResult result =
            vmaAllocateMemory(m_allocator, &requirements, &allocate, &allocation, &allocated);
        if (result != VK_SUCCESS) return result;
        vmaSetAllocationName(m_allocator, allocation, request.name);
        memory = Describe(allocation, allocated);
        return result;
    }

    void Free(const MemoryAllocation& memory) noexcept override {
        vmaFreeMemory(m_allocator, static_cast<VmaAllocation>(memory.handle));
    }

  private:
    static MemoryAllocation Describe(VmaAllocation allocation, const VmaAllocationInfo& allocated) {
        return {.memory = allocated.deviceMemory,
                .offset = allocated.offset,
                .size = allocated.size,
                .memoryType = allocated.memoryType,
                .mapped = static_cast<std::byte*>(allocated.pMappedData),
                .handle = allocation};
    }

    VmaAllocator m_allocator;
};

}  // namespace

VkResult CreateVmaAllocator(const VmaAllocatorDesc& desc, std::unique_ptr<MemoryAllocator>& allocator) {
    VmaVulkanFunctions functions{};
    functions.vkGetInstanceProcAddr = desc.getInstanceProcAddr;
    functions.vkGetDeviceProcAddr = desc.getDeviceProcAddr;
    VmaAllocatorCreateInfo info{};
    info.flags = VMA_ALLOCATOR_CREATE_BUFFER_DEVICE_ADDRESS_BIT;
    if (desc.hasMemoryBudget) info.flags |= VMA_ALLOCATOR_CREATE_EXT_MEMORY_BUDGET_BIT;
    info.physicalDevice = desc.physicalDevice;
    info.device = desc.device;
    info.instance = desc.instance;
    info.pAllocationCallbacks = desc.callbacks;
    info.pVulkanFunctions = &functions;
    // A frame that needs another block waits for its allocation: 256 MiB, the default, take 6 ms on an H200.
    info.preferredLargeHeapBlockSize = uint64_t{64} << 20;
    info.vulkanApiVersion = VK_API_VERSION_1_3;
    VmaAllocator created = nullptr;
    const VkResult result = vmaCreateAllocator(&info, &created);
    if (result == VK_SUCCESS) allocator = std::make_unique<VmaMemoryAllocator>(created);
    return result;
}

}  // namespace raygraph::rhi
