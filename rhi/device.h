// Device: one Vulkan device, created by Raygraph or adopted from a host engine, with its memory, its queues
// and their timelines.
//
// There are no globals: a process may have any number of devices, each with its own function table. Nothing
// here exits or prints; messages go to DeviceDesc::log. Threads: Create*, Retire, CompletedValue and WaitFor
// may be called from any thread; Submit takes the queue lock (the host's, when adopted). A CommandList
// belongs to one thread at a time.
#pragma once

#include <array>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "base/error.h"
#include "base/log.h"
#include "rhi/device_requirements.h"
#include "rhi/functions.h"
#include "rhi/memory_allocator.h"
#include "rhi/resources.h"
#include "rhi/submission.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

class CommandList;
class Tlas;
struct SpecializationValue;  // rhi/shader_stage.h

// The longest time that a wait may last without any submission completing; see hangLimit.
inline constexpr std::chrono::milliseconds kDefaultHangLimit = std::chrono::minutes(2);

struct DeviceDesc {
    std::string name = "raygraph";
    // Selects the device: "" is the most suitable one, "1" an index, and any other text a case-insensitive
    // part of the name.
    std::string select = {};
    // Enables core and synchronization validation; Error{NoDevice} if the layers are not installed.
    bool validation = false;
    bool debugNames = true;  // object names and labels, where VK_EXT_debug_utils exists
    raygraph::Log log = {};  // for messages of the device and of all objects created with it; see base/log.h
    // Instance extensions that the window system requires: with any, the device can present in windows
    // (rhi/swapchain.h). Error{NoDevice} if one of them or VK_KHR_swapchain is missing.
    std::vector<std::string> surfaceExtensions = {};
    uint32_t framesInFlight = 2;
    // False: all work goes to the main queue, even where the device has others.
    bool usesOtherQueues = true;
    // A wait in which no submission completes for this long ends in Error{DeviceLost}, which names the last
    // pass reached. 0: waits are unlimited. nullopt: kDefaultHangLimit, or 0 on a CPU device, whose frames
    // may take that long.
    std::optional<std::chrono::milliseconds> hangLimit = {};
    bool savePipelineCache = true;              // keep the pipeline cache on disk between runs
    std::filesystem::path cacheDirectory = {};  // "": $XDG_CACHE_HOME/raygraph, else ~/.cache/raygraph
    // True: pipelines record what rhi/pipeline.h reports, if the device can.
    bool capturesStatistics = false;
    PFN_vkGetInstanceProcAddr getInstanceProcAddr = nullptr;  // null: the system's libvulkan.so.1
};

// A queue of a host; null: it has none of the kind.
struct AdoptedQueue {
    VkQueue queue = VK_NULL_HANDLE;
    uint32_t family = 0;
};

// Holds the objects of a host, all of which outlive the Device. The host has enabled what
// rhi/device_requirements.h requires.
struct AdoptedDeviceDesc {
    std::string name = "host";
    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physicalDevice = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;  // graphics, compute and transfer
    uint32_t queueFamily = 0;
    // Optional queues for passes that may run beside others, and for uploads (QueueFamilyFor). Each may be
    // the main queue itself, of the same family: then its work is submitted on its own, in order.
    AdoptedQueue computeQueue = {};
    AdoptedQueue transferQueue = {};
    PFN_vkGetInstanceProcAddr getInstanceProcAddr = nullptr;  // the host's loader
    std::vector<std::string> enabledExtensions = {};          // device extensions the host enabled
    // The optional features that the host has enabled. No other is used, because Vulkan cannot be queried for
    // them. A device that was created with FeaturesFor has OptionalFeaturesOf.
    OptionalFeatures enabledFeatures = {};
    bool debugUtilsEnabled = false;                              // instance has VK_EXT_debug_utils
    const VkAllocationCallbacks* allocationCallbacks = nullptr;  // for the host memory of the driver
    MemoryAllocator* memoryAllocator = nullptr;  // for device memory; null: an allocator of the Device's own
    std::function<void()> lockQueue = {};  // called around every access to any queue, if the host shares them
    std::function<void()> unlockQueue = {};  // both or neither
    raygraph::Log log = {};                  // as in DeviceDesc
    uint32_t framesInFlight = 2;
    std::optional<std::chrono::milliseconds> hangLimit = {};  // as in DeviceDesc
    bool savePipelineCache = false;
    std::filesystem::path cacheDirectory = {};
};

enum class DeviceType : uint8_t { Cpu, Integrated, Discrete, Virtual, Other };
RAYGRAPH_API const char* Name(DeviceType type);

// Holds the constant properties of a device.
struct DeviceInfo {
    std::string name;    // "llvmpipe (LLVM 15.0.6, 256 bits)"
    std::string driver;  // "llvmpipe Mesa 25.0.7 ..."
    DeviceType type = DeviceType::Other;
    uint32_t apiVersion = 0;
    uint32_t vendorId = 0;
    bool isLavapipe = false;
    // Shader binding table and tracing
    uint32_t shaderGroupHandleSize = 0;
    uint32_t shaderGroupHandleAlignment = 0;
    uint32_t shaderGroupBaseAlignment = 0;
    uint32_t maxShaderGroupStride = 0;
    uint32_t maxRayRecursionDepth = 0;
    uint64_t maxRayInvocationCount = 0;        // width * height of one TraceRays
    float maxAnisotropy = 1.0f;                // limit of samplers; 1: the device lacks samplerAnisotropy
    std::array<uint32_t, 3> maxGroupCounts{};  // limits of one Dispatch
    // Acceleration structures
    uint32_t scratchAlignment = 0;
    uint64_t maxInstanceCount = 0;
    // Others
    double timestampPeriodNs = 0.0;   // nanoseconds a tick; 0: no timestamps
    uint32_t timestampValidBits = 0;  // bits of the queue family's timestamps; 0: none
    uint32_t maxPushConstantBytes = 0;
    uint32_t maxPushDescriptors = 0;
    uint64_t storageAlignment = 0;  // bytes, minStorageBufferOffsetAlignment
    uint64_t uniformAlignment = 0;
    uint64_t maxBufferBytes = 0;
    // Limits of what a shader binds: maxStorageBufferRange of a buffer, maxUniformBufferRange of a block
    uint64_t maxStorageBufferBytes = 0;
    uint64_t maxUniformBufferBytes = 0;
    uint32_t maxTextureExtent = 0;  // texels a side
    uint32_t maxTextureLayers = 0;
    uint32_t subgroupSize = 0;
    OptionalFeatures optional;
};

// A device found by enumeration, with every reason for which it cannot be used (none: it is suitable).
struct DeviceReport {
    uint32_t index = 0;
    std::string name;
    std::string driver;
    DeviceType type = DeviceType::Other;
    uint32_t apiVersion = 0;
    std::vector<std::string>
        refusals;  // "lacks VK_KHR_ray_tracing_pipeline", "maxPushDescriptors is 8, needs 32"
};

// Describes a semaphore to wait for or to signal with a submission; value is for timeline semaphores, 0 for
// binary ones.
struct SemaphoreUse {
    VkSemaphore semaphore = VK_NULL_HANDLE;
    uint64_t value = 0;
    VkPipelineStageFlags2 stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
};

struct MemoryStatistics {
    uint64_t usedBytes = 0;  // bytes of live resources
    uint64_t peakBytes = 0;  // the largest usedBytes so far
    // The part of usedBytes that should be in the device's own memory but had to be placed in the host's,
    // which is slow. A warning reports the first time.
    uint64_t fallbackBytes = 0;
};

// One of the device's memory heaps. With VK_EXT_memory_budget (OptionalFeatures::memoryBudget), budget and
// use come from the driver; without it, they are 80 % of the size and the allocations of this Device.
struct MemoryHeap {
    bool isDeviceLocal = false;  // false: host memory
    uint64_t sizeBytes = 0;
    uint64_t budgetBytes = 0;  // bytes that this process may use
    uint64_t usedBytes = 0;    // bytes that this process uses, over all its devices
};

class RAYGRAPH_API Device {
  public:
    // Throws Error{NoDevice} naming every device found and why it was refused. If a device is found but
    // cannot be created, throws the Error of that call: OutOfMemory, DeviceLost or Vulkan.
    static std::unique_ptr<Device> Create(const DeviceDesc& desc = {});
    // Checks the host's device against the requirements; throws Error{NoDevice} naming what is missing.
    static std::unique_ptr<Device> Adopt(const AdoptedDeviceDesc& desc);
    // Returns every Vulkan device of the machine, in the loader's order; empty without a loader. A null
    // `loader` stands for libvulkan.so.1.
    static std::vector<DeviceReport> Enumerate(PFN_vkGetInstanceProcAddr loader = nullptr);

    // Waits until the device is idle. If it hangs for longer than DeviceDesc::hangLimit, nothing is freed,
    // because it may still be in use; a message reports this.
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    const DeviceInfo& Info() const;
    const DeviceFunctions& Vk() const;  // the function tables: only for rhi/
    const InstanceFunctions& InstanceVk() const;
    VkDevice Handle() const;
    VkPhysicalDevice PhysicalDevice() const;
    VkInstance Instance() const;
    // Tells whether work for this queue is submitted apart from the main queue's.
    bool HasQueue(QueueKind queue) const;
    // Returns the family of a queue that the device has.
    uint32_t QueueFamily(QueueKind queue = QueueKind::Main) const;
    // Returns the distinct families of its queues, the main one's first. With more than one, all can access
    // the buffers and textures that are shared (IsShared).
    std::span<const uint32_t> QueueFamilies() const;
    VkPipelineCache PipelineCache() const;
    VkPipelineCreateFlags PipelineFlags() const;  // flags of all pipelines
    uint32_t FramesInFlight() const;
    std::chrono::milliseconds HangLimit() const;  // 0: unlimited
    const VkAllocationCallbacks* AllocationCallbacks() const;

    // These functions throw Error{OutOfMemory} or Error{Vulkan} with the object's name, and Error{Usage} for
    // an invalid Desc.
    Buffer CreateBuffer(const BufferDesc& desc);
    Buffer CreateBuffer(const BufferDesc& desc, const MemoryBlock& memory);
    Texture CreateTexture(const TextureDesc& desc);
    Texture CreateTexture(const TextureDesc& desc, const MemoryBlock& memory);
    // Wraps an image that the host owns, and creates a view of it. With six layers or more, a view as cube
    // map requires VK_IMAGE_CREATE_CUBE_COMPATIBLE_BIT.
    Texture WrapTexture(const TextureDesc& desc, VkImage image);
    // Wraps a buffer in device memory that the host owns; `desc` gives its size and usage. It needs
    // VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT only if its address is used (Buffer::Address, passes that
    // read it by address, builds).
    Buffer WrapBuffer(const BufferDesc& desc, VkBuffer buffer);
    // Wraps a TLAS that the host owns, builds and destroys; see rhi/tlas.h.
    Tlas WrapTlas(const std::string& name, VkAccelerationStructureKHR structure);
    Sampler CreateSampler(const SamplerDesc& desc);
    MemoryBlock CreateMemoryBlock(const std::string& name, const MemoryRequirements& requirements);
    MemoryRequirements RequirementsOf(const TextureDesc& desc);
    MemoryRequirements RequirementsOf(const BufferDesc& desc);
    // Returns whether mip levels of such a texture can be generated (CommandList::BlitMip).
    bool CanGenerateMips(Format format) const;
    // Returns whether textures of the format can be filled and sampled with linear filters; of one of blocks,
    // too.
    bool CanSample(Format format) const;
    MemoryStatistics Memory() const;
    std::vector<MemoryHeap> MemoryHeaps() const;
    // Sets a limit: resources that would take MemoryStatistics::usedBytes above `bytes` are then refused with
    // Error{OutOfMemory}, as if the device had no more memory. 0: no limit. Threads that create resources at
    // the same time may exceed it by these resources.
    void LimitMemory(uint64_t bytes);
    uint64_t MemoryLimit() const;  // 0: none

    // --- The timelines: every submission signals the next value of its queue's. Threads: any.
    // Returns a command list in the recording state, for a queue that the device has; its pool is recycled
    // once its submission has completed.
    CommandList BeginCommands(const std::string& name, QueueKind queue = QueueKind::Main);
    // Ends the list and submits it to its queue. The main and the compute queue wait for all that the
    // transfer queue was given before; other waits between queues are the caller's (After). Throws
    // Error{DeviceLost} (see AddLastPassReport) or Error{Vulkan}.
    Submission Submit(CommandList&& commands, std::span<const SemaphoreUse> waits = {},
                      std::span<const SemaphoreUse> signals = {});
    // Submits no commands to the main queue: the signals follow the waits. For work that failed before its
    // submission, whose semaphores others wait for. Throws as Submit does.
    Submission Forward(std::span<const SemaphoreUse> waits, std::span<const SemaphoreUse> signals);
    // Returns a command list that records into a primary command buffer of the host, of the device's queue
    // family, in the recording state and outside of rendering. What the host has bound is lost.
    CommandList RecordInto(VkCommandBuffer commands);
    // Ends a list of RecordInto without ending the host's buffer, which the host then submits exactly once,
    // to the main queue. Returns the next point of its timeline, which counts as reached when the host has
    // said so by Complete. What is retired meanwhile waits for it.
    Submission HandOver(CommandList&& commands);
    // The host's submission of what HandOver returned this for has completed: its fence or semaphore says so.
    // Throws Error{Usage} if there is none, or if it has been completed.
    void Complete(const Submission& submission);

    // Returns the value up to which everything has completed, buffers of the host included.
    uint64_t CompletedValue(QueueKind queue = QueueKind::Main) const;
    // Tells whether this one submission, or buffer of the host, has completed; earlier ones may not have.
    bool HasCompleted(const Submission& submission) const;
    // Returns the value of the last submission, or of the last buffer that was handed over to the host.
    uint64_t LastSubmittedValue(QueueKind queue = QueueKind::Main) const;
    VkSemaphore Timeline(QueueKind queue = QueueKind::Main) const;
    // Returns the wait for a submission, for a later submission to any queue of this VkDevice, the host's
    // included. The semaphore never tells of buffers that were handed over to the host.
    SemaphoreUse After(const Submission& submission) const;
    // Waits until HasCompleted. Throws Error{DeviceLost} for a device that is lost or hangs
    // (DeviceDesc::hangLimit), and Error{Usage} for a buffer that the host has not completed.
    void WaitFor(const Submission& submission);
    // Makes the main queue wait for all that the transfer queue was given, without a list of its own: for
    // commands in a buffer that the host submits.
    void JoinTransfers();
    // Waits for Raygraph's own submissions, not for a host's on the same queues.
    void WaitIdle();

    // Calls vkQueuePresentKHR under the queue's lock; only for Swapchain. The caller handles its result.
    VkResult Present(const VkPresentInfoKHR& info);
    // Calls WaitIdle, then vkQueueWaitIdle under the queue's lock: presentation has no timeline to wait for.
    void WaitQueueIdle();

    // Calls `destroy` once all work submitted so far, to any queue, and every command list that is being
    // recorded, has completed; if there is none, it calls it at once. A list that is kept open delays
    // everything that is retired meanwhile.
    void Retire(std::function<void()> destroy);
    // Frees retired objects that the timelines have passed. Submit and WaitFor call it.
    void CollectGarbage();

    // Gives a Vulkan object its debug name. Does nothing without VK_EXT_debug_utils.
    void SetName(VkObjectType type, uint64_t handle, const std::string& name);
    // The log of DeviceDesc, which renderers and scenes on this device use, too.
    const raygraph::Log& Log() const;
    // Throws the Error for `result` unless that is a success; `what` names object and call.
    void Check(VkResult result, std::string_view what) const;
    // Registers a function that reports which pass was reached when the device is lost. All non-empty reports
    // are put into the Error. `report` may be called from any thread, but never after the returned object has
    // been destroyed, and must not call back into the Device.
    [[nodiscard]] std::shared_ptr<const void> AddLastPassReport(std::function<std::string()> report);
    // Returns the number of validation messages so far, core and synchronization. An adopted device has none:
    // the messages of a host's instance reach the host's own messenger.
    uint64_t ValidationMessageCount() const;
    // Writes the pipeline cache to disk now (also done on destruction). Returns false if no cache file is in
    // use, or if it cannot be written.
    bool SavePipelineCache();
    // Numbers that were measured on this device and driver, by name: those of this process, and those of
    // earlier ones where the pipeline cache is kept. A name has neither a tab nor a line break.
    std::optional<double> Measured(std::string_view name) const;
    void StoreMeasurement(std::string_view name, double value);

    // Returns the layout of set 1 (bindless textures), which all pipelines share: see rhi/texture_table.h.
    VkDescriptorSetLayout TextureTableLayout();
    // Returns the SPIR-V to pass to the driver instead of a shader's own (rhi/shader_specializer.h), or null
    // if the shader's own is to be used with the values. Only for rhi/.
    std::shared_ptr<const std::vector<uint32_t>> Specialized(std::span<const uint32_t> spirv,
                                                             std::span<const SpecializationValue> values);

  private:
    friend class Buffer;
    friend class CommandList;
    friend class MemoryBlock;
    friend class Texture;
    struct Impl;
    void Finish(Texture& texture);
    bool HasFormatFeatures(Format format, VkFormatFeatureFlags needed) const;
    VkImageView CreateView(const Texture& texture, const Subresources& part, ImageShape shape);
    void Free(VkBuffer buffer, const MemoryAllocation& memory) noexcept;
    void Free(VkImage image, VkImageView view, const MemoryAllocation& memory) noexcept;
    void FreeMemory(const MemoryAllocation& memory) noexcept;
    // Called before and after memory is allocated: the first throws Error{OutOfMemory} beyond the limit, the
    // last counts the memory.
    void RequireMemory(const std::string& subject, uint64_t bytes);
    void CheckMemory(VkResult result, const std::string& subject);
    void TrackMemory(MemoryAllocation& memory, const std::string& subject, bool isForDevice);
    void Recycle(CommandList& commands, const Submission& submission) noexcept;
    explicit Device(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> m_impl;
};

}  // namespace raygraph::rhi
