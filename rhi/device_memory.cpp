// Device's memory accounting: use, budget, limit.
#include "base/text.h"
#include "rhi/device_impl.h"

namespace raygraph::rhi {
namespace {

// Marks allocations that had to go into the host's memory.
char fallbackMark = 0;

}  // namespace

MemoryStatistics Device::Memory() const {
    return m_impl->memory.Statistics();
}

std::vector<MemoryHeap> Device::MemoryHeaps() const {
    const VkPhysicalDeviceMemoryProperties* properties = nullptr;
    vmaGetMemoryProperties(Allocator(), &properties);
    // Makes the allocator query the driver, whose answers it caches for long.
    vmaSetCurrentFrameIndex(Allocator(), 0);
    std::vector<VmaBudget> budgets(VK_MAX_MEMORY_HEAPS);
    vmaGetHeapBudgets(Allocator(), budgets.data());
    std::vector<MemoryHeap> heaps;
    for (uint32_t i = 0; i < properties->memoryHeapCount; ++i) {
        const VkMemoryHeap& heap = properties->memoryHeaps[i];
        heaps.push_back({.isDeviceLocal = (heap.flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0,
                         .sizeBytes = heap.size,
                         .budgetBytes = budgets[i].budget,
                         .usedBytes = budgets[i].usage});
    }
    return heaps;
}

void Device::LimitMemory(uint64_t bytes) {
    m_impl->memoryLimit = bytes;
}

uint64_t Device::MemoryLimit() const {
    return m_impl->memoryLimit;
}

void Device::RequireMemory(const std::string& subject, uint64_t bytes) {
    const uint64_t limit = m_impl->memoryLimit;
    if (limit == 0) return;
    const uint64_t used = Memory().usedBytes;
    if (used <= limit && bytes <= limit - used) return;
    throw Error(ErrorKind::OutOfMemory,
                Text("{}: {} of the limit of {} bytes are in use", subject, used, limit),
                VK_ERROR_OUT_OF_DEVICE_MEMORY);
}

void Device::CheckMemory(VkResult result, const std::string& subject) {
    if (result != VK_ERROR_OUT_OF_DEVICE_MEMORY) return Check(result, subject);
    // Drivers return various errors for allocations on a lost device, and the allocator treats each as
    // full memory.
    uint64_t completed = 0;
    if (m_impl->QueryCompleted(completed) == VK_ERROR_DEVICE_LOST) Check(VK_ERROR_DEVICE_LOST, subject);
    std::string text;
    for (const MemoryHeap& heap : MemoryHeaps())
        if (heap.isDeviceLocal)
            text += (text.empty() ? " (device memory: " : ", ") + BytesText(heap.usedBytes) + " of " +
                    BytesText(heap.budgetBytes) + " in use";
    Check(result, subject + text + (text.empty() ? "" : ")"));
}

void Device::TrackMemory(VmaAllocation allocation, const std::string& subject, bool isForDevice) {
    VmaAllocationInfo allocated{};
    vmaGetAllocationInfo(Allocator(), allocation, &allocated);
    m_impl->memory.Add(allocated.size);
    if (!isForDevice) return;
    VkMemoryPropertyFlags flags = 0;
    vmaGetMemoryTypeProperties(Allocator(), allocated.memoryType, &flags);
    if ((flags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT) != 0) return;
    vmaSetAllocationUserData(Allocator(), allocation, &fallbackMark);
    if (m_impl->memory.AddFallback(allocated.size))
        Say(Log(), LogLevel::Warning, log_category::kMemory,
            "device memory is full: {} lies in the memory of the host, which is slow", subject);
}

void Device::FreeMemory(VmaAllocation allocation) noexcept {
    if (!allocation) return;
    VmaAllocationInfo info{};
    vmaGetAllocationInfo(Allocator(), allocation, &info);
    m_impl->memory.Remove(info.size);
    if (info.pUserData == &fallbackMark) m_impl->memory.RemoveFallback(info.size);
    vmaFreeMemory(Allocator(), allocation);
}

}  // namespace raygraph::rhi
