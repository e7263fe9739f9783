// The private state of Device: only for the sources of Device and CommandList.
#pragma once

#include <atomic>
#include <list>
#include <mutex>
#include <set>
#include <vector>

#include "rhi/device.h"
#include "rhi/device_cache.h"
#include "rhi/message_sink.h"
#include "rhi/retire_queue.h"
#include "rhi/shader_specializer.h"
#include "rhi/vma_allocator.h"

namespace raygraph::rhi {

// Fills in DeviceInfo; `optional` is moved into it.
DeviceInfo ReadDeviceInfo(const InstanceFunctions& vk, VkPhysicalDevice device, uint32_t queueFamily,
                          const OptionalFeatures& optional);
// Returns the features that a device does not have, or was adopted without: "ray query, wireframe".
std::string MissingFeatures(const OptionalFeatures& features);
// Returns name, driver, type and refusals of an enumerated device.
DeviceReport ReportOn(uint32_t index, VkPhysicalDevice device, PFN_vkGetInstanceProcAddr loader,
                      VkInstance instance);
// Returns the name of a result: "VK_ERROR_DEVICE_LOST".
std::string ResultName(VkResult result);

// Returns the kind of Error for a call that failed while a device was created: exhausted memory and a lost
// device are not NoDevice.
ErrorKind KindOfCreationError(VkResult result);

// Holds a command buffer and its pool; they are reused once `until` has completed.
struct CommandSlot {
    VkCommandPool pool = VK_NULL_HANDLE;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    Submission until;
};

// A queue with its timeline.
struct QueueState {
    bool isUsed = false;  // false: the device lacks it, and the rest has no meaning
    VkQueue queue = VK_NULL_HANDLE;
    uint32_t family = 0;
    VkSemaphore timeline = VK_NULL_HANDLE;
    std::atomic<uint64_t> lastSubmitted{0};  // or handed over to the host
    std::atomic<uint64_t> lastSignaled{0};   // by own submissions
    std::atomic<uint64_t> lastCompleted{0};  // the value at the last query
    uint64_t joinedTransfers = 0;            // value of the transfer queue's timeline for which it waits
};

class MemoryCounter {
  public:
    // Returns true for the first memory that had to be placed in the host's.
    bool Add(const MemoryAllocation& memory, uint32_t heap) {
        const uint64_t used = m_used.fetch_add(memory.size) + memory.size;
        uint64_t peak = m_peak.load();
        while (peak < used && !m_peak.compare_exchange_weak(peak, used)) {
        }
        m_usedOfHeap[heap].fetch_add(memory.size);
        return memory.isFallback && m_fallback.fetch_add(memory.size) == 0;
    }
    void Remove(const MemoryAllocation& memory, uint32_t heap) {
        m_used.fetch_sub(memory.size);
        m_usedOfHeap[heap].fetch_sub(memory.size);
        if (memory.isFallback) m_fallback.fetch_sub(memory.size);
    }
    MemoryStatistics Statistics() const { return {m_used.load(), m_peak.load(), m_fallback.load()}; }
    uint64_t UsedOfHeap(uint32_t heap) const { return m_usedOfHeap[heap].load(); }

  private:
    std::atomic<uint64_t> m_used{0}, m_peak{0}, m_fallback{0};
    std::array<std::atomic<uint64_t>, VK_MAX_MEMORY_HEAPS> m_usedOfHeap{};
};

// The reporters of the last pass reached. Thread-safe; it is shared with them, as they may outlive the
// device.
class LastPassReports {
  public:
    using Report = std::function<std::string()>;
    std::list<Report>::iterator Add(Report report) {
        const std::lock_guard lock(m_mutex);
        return m_reports.insert(m_reports.end(), std::move(report));
    }
    void Remove(std::list<Report>::iterator entry) {
        const std::lock_guard lock(m_mutex);
        m_reports.erase(entry);
    }
    // Returns all their reports.
    std::string Text();

  private:
    std::mutex m_mutex;
    std::list<Report> m_reports;
};

struct Device::Impl {
    explicit Impl(raygraph::Log log) : messages(std::move(log)) {}
    ~Impl() { Close(); }

    // Makes a working device of the handles: functions, allocator, queues, pipeline cache. Used queues have
    // their family, and their handle if they are adopted. If it throws, Close() frees what was created.
    void Open(const OptionalFeatures& optional, const std::filesystem::path& cacheFolder,
              std::optional<std::chrono::milliseconds> requestedHangLimit);
    void CheckCreation(VkResult result, const char* what) const;
    void OpenAllocator();
    void OpenQueues();
    // Frees everything of a device that is idle or lost, and device and instance unless they are adopted.
    // Never throws.
    void Close() noexcept;
    // Waits until all own submissions have completed, or the device is lost. Returns false if it hangs.
    bool Drain() noexcept;
    // Waits for a queue's timeline. Returns VK_TIMEOUT when no submission to any queue has completed for
    // hangLimit, or at once if none has since another wait found the device to hang.
    VkResult Await(const Submission& submission) noexcept;
    // The value that the semaphore of the queue's timeline has now.
    VkResult QuerySignaled(QueueKind queue, uint64_t& value) noexcept;
    // The sum of these values over all queues: it grows with every submission that completes.
    VkResult QueryProgress(uint64_t& sum) noexcept;
    // The value up to which everything has completed, the host's buffers included.
    VkResult QueryCompleted(QueueKind queue, uint64_t& value) noexcept;
    // Queries all queues; gives 0 for those that the device lacks.
    VkResult QueryCompleted(QueueValues& values) noexcept;
    bool IsPendingInHost(const Submission& submission) const;
    // Completed, and not yet passed by the semaphore.
    bool IsCompletedInHost(const Submission& submission) const;
    Submission SubmitBatch(const Device& owner, QueueKind queue, VkCommandBuffer commands,
                           std::span<const SemaphoreUse> waits, std::span<const SemaphoreUse> signals);
    QueueState& Queue(QueueKind queue) { return queues[IndexOf(queue)]; }
    const QueueState& Queue(QueueKind queue) const { return queues[IndexOf(queue)]; }
    QueueValues LastCompleted() const;  // at the last queries
    // Ends the delivery of validation messages.
    void Silence() noexcept;
    void LockQueues();
    void UnlockQueues();

    std::shared_ptr<VulkanLoader> loader;  // null: the caller's own
    PFN_vkGetInstanceProcAddr getInstanceProcAddr = nullptr;
    std::string name;
    bool isOwned = false;  // created, not adopted
    bool hasDebugUtils = false;
    VkInstance instance = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
    VkPhysicalDevice physicalDevice = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    std::array<QueueState, kQueueKinds.size()> queues;
    std::vector<uint32_t> queueFamilies;  // distinct, the main queue's first
    uint32_t framesInFlight = 2;
    const VkAllocationCallbacks* allocation = nullptr;
    std::function<void()> lockQueues, unlockQueues;  // functions of the host, or empty

    InstanceFunctions instanceFunctions;
    DeviceFunctions vk;
    DeviceInfo info;
    MessageSink messages;
    VkPhysicalDeviceMemoryProperties memoryProperties{};
    std::unique_ptr<MemoryAllocator> ownAllocator;  // null: the host's is in use
    MemoryAllocator* allocator = nullptr;
    MemoryCounter memory;
    std::atomic<uint64_t> memoryLimit{0};  // 0: none

    std::mutex submitMutex;  // orders timeline values like submissions; taken before the host's queue lock
    // Values of HandOver, which the main semaphore skips. Completed ones are kept until it has passed them.
    mutable std::mutex handedMutex;
    std::set<uint64_t> pendingInHost, completedInHost;
    std::chrono::milliseconds hangLimit{0};            // 0: none
    std::atomic<uint64_t> hungProgress{~uint64_t{0}};  // when a wait found the device to hang
    std::mutex slotMutex;
    std::vector<CommandSlot> slots;  // not being recorded
    RetireQueue retired;

    std::shared_ptr<LastPassReports> lastPassReports = std::make_shared<LastPassReports>();

    bool savesPipelineCache = false;
    bool capturesStatistics = false;
    std::mutex pipelineCacheMutex;
    PipelineCacheFile pipelineCacheFile;
    Measurements measurements;
    VkPipelineCache pipelineCache = VK_NULL_HANDLE;
    std::optional<SpecializedShaders> specializedShaders;  // set by Open
    std::mutex tableLayoutMutex;
    VkDescriptorSetLayout tableLayout = VK_NULL_HANDLE;
};

}  // namespace raygraph::rhi
