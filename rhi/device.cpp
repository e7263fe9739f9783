#include "rhi/device.h"

#include <algorithm>
#include <tuple>

#include "base/check.h"
#include "base/text.h"
#include "rhi/device_impl.h"
#include "rhi/shader_specializer.h"
#include "rhi/texture_table.h"

namespace raygraph::rhi {

ErrorKind KindOfCreationError(VkResult result) {
    switch (result) {
        case VK_ERROR_OUT_OF_HOST_MEMORY:
        case VK_ERROR_OUT_OF_DEVICE_MEMORY:
            return ErrorKind::OutOfMemory;
        case VK_ERROR_DEVICE_LOST:
            return ErrorKind::DeviceLost;
        default:
            return ErrorKind::NoDevice;
    }
}

void Device::Impl::Open(const OptionalFeatures& optional, const std::filesystem::path& cacheFolder,
                        std::optional<std::chrono::milliseconds> requestedHangLimit) {
    vk = LoadDeviceFunctions(instanceFunctions.vkGetDeviceProcAddr, device, hasDebugUtils);
    info = ReadDeviceInfo(instanceFunctions, physicalDevice, Queue(QueueKind::Main).family, optional);
    hangLimit = requestedHangLimit.value_or(info.type == DeviceType::Cpu ? std::chrono::milliseconds(0)
                                                                         : kDefaultHangLimit);

    OpenAllocator();
    OpenQueues();

    const raygraph::Log& log = messages.Messages();
    WriteLog(log, LogLevel::Info, log_category::kDevice, "device '{}': {}, {}, Vulkan {}.{}", name, info.name,
             info.driver, VK_API_VERSION_MAJOR(info.apiVersion), VK_API_VERSION_MINOR(info.apiVersion));
    if (const std::string lacks = MissingFeatures(info.optional); !lacks.empty())
        WriteLog(log, LogLevel::Debug, log_category::kDevice, "device '{}' lacks {}", name, lacks);
    PipelineCacheFile::Loaded cached;
    if (savesPipelineCache) {
        VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, nullptr, {}};
        instanceFunctions.vkGetPhysicalDeviceProperties2(physicalDevice, &properties);
        pipelineCacheFile = PipelineCacheFile(cacheFolder, properties.properties);
        cached = pipelineCacheFile.Load();
        if (std::filesystem::path file = pipelineCacheFile.Path(); !file.empty())
            measurements.SetFile(file.replace_extension(".measured"));
        if (!cached.problem.empty())
            log.Send(LogLevel::Warning, log_category::kCache, cached.problem);
        else if (cached.bytes.empty())
            WriteLog(log, LogLevel::Info, log_category::kCache, "no pipeline cache yet: {}",
                     pipelineCacheFile.Path());
        else
            WriteLog(log, LogLevel::Info, log_category::kCache, "pipeline cache of {} read from {}",
                     BytesText(cached.bytes.size()), pipelineCacheFile.Path());
    }
    VkPipelineCacheCreateInfo cacheInfo{};
    cacheInfo.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO;
    cacheInfo.initialDataSize = cached.bytes.size();
    cacheInfo.pInitialData = cached.bytes.data();
    VkPipelineCache cache = VK_NULL_HANDLE;
    CheckCreation(vk.vkCreatePipelineCache(device, &cacheInfo, allocation, &cache), "vkCreatePipelineCache");
    pipelineCache = cache;
    specializedShaders.emplace(savesPipelineCache ? cacheFolder : std::filesystem::path(), log,
                               SpecializerVersion());
}

void Device::Impl::CheckCreation(VkResult result, const char* what) const {
    if (result == VK_SUCCESS) return;
    throw Error(KindOfCreationError(result), Text("device '{}': {}: {}", name, what, ResultName(result)),
                result);
}

void Device::Impl::OpenAllocator() {
    VkPhysicalDeviceMemoryProperties2 properties{
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_PROPERTIES_2, nullptr, {}};
    instanceFunctions.vkGetPhysicalDeviceMemoryProperties2(physicalDevice, &properties);
    memoryProperties = properties.memoryProperties;
    if (allocator) return;
    CheckCreation(CreateVmaAllocator({.instance = instance,
                                      .physicalDevice = physicalDevice,
                                      .device = device,
                                      .getInstanceProcAddr = getInstanceProcAddr,
                                      .getDeviceProcAddr = instanceFunctions.vkGetDeviceProcAddr,
                                      .hasMemoryBudget = info.optional.memoryBudget,
                                      .callbacks = allocation},
                                     ownAllocator),
                  "vmaCreateAllocator");
    allocator = ownAllocator.get();
}

void Device::Impl::OpenQueues() {
    for (QueueState& state : queues) {
        if (!state.isUsed) continue;
        if (!state.queue) vk.vkGetDeviceQueue(device, state.family, 0, &state.queue);
        if (std::ranges::find(queueFamilies, state.family) == queueFamilies.end())
            queueFamilies.push_back(state.family);
        VkSemaphoreTypeCreateInfo type{};
        type.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO;
        type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
        const VkSemaphoreCreateInfo create{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type, 0};
        VkSemaphore semaphore = VK_NULL_HANDLE;
        CheckCreation(vk.vkCreateSemaphore(device, &create, allocation, &semaphore), "vkCreateSemaphore");
        state.timeline = semaphore;
    }
}

VkResult Device::Impl::Await(const Submission& submission) noexcept {
    const VkSemaphoreWaitInfo wait{VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO, nullptr,          0, 1,
                                   &Queue(submission.queue).timeline,     &submission.value};
    if (hangLimit.count() == 0) return vk.vkWaitSemaphores(device, &wait, UINT64_MAX);
    const auto limit =
        static_cast<uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(hangLimit).count());
    constexpr uint64_t kMillisecond = 1'000'000;
    uint64_t before = 0;
    VkResult result = QueryProgress(before);
    while (result == VK_SUCCESS) {
        result = vk.vkWaitSemaphores(device, &wait, hungProgress.load() == before ? kMillisecond : limit);
        if (result != VK_TIMEOUT) return result;
        uint64_t completed = 0;
        result = QueryProgress(completed);
        if (result == VK_SUCCESS && completed == before) {
            hungProgress = completed;
            return VK_TIMEOUT;
        }
        before = completed;  // the device is slow, but does not hang
    }
    return result;
}

bool Device::Impl::Drain() noexcept {
    for (const QueueKind kind : kQueueKinds) {
        const uint64_t last = Queue(kind).lastSignaled.load();
        if (!Queue(kind).timeline || last == 0) continue;
        const VkResult result = Await({last, kind});
        if (result == VK_TIMEOUT) return false;
        if (result == VK_SUCCESS) continue;
        // The device is lost: whatever is still running ends in finite time, which the queue knows.
        LockQueues();
        vk.vkQueueWaitIdle(Queue(kind).queue);
        UnlockQueues();
    }
    return true;
}

void Device::Impl::Silence() noexcept {
    if (messenger) instanceFunctions.vkDestroyDebugUtilsMessengerEXT(instance, messenger, allocation);
    messenger = VK_NULL_HANDLE;
}

void Device::Impl::Close() noexcept {
    if (device && vk.vkDestroyDevice) {
        retired.CollectAll();
        for (const CommandSlot& slot : slots) vk.vkDestroyCommandPool(device, slot.pool, allocation);
        slots.clear();
        vk.vkDestroyDescriptorSetLayout(device, tableLayout, allocation);
        vk.vkDestroyPipelineCache(device, pipelineCache, allocation);
        for (const QueueState& state : queues) vk.vkDestroySemaphore(device, state.timeline, allocation);
        if (allocator) {
            if (const uint64_t left = memory.Statistics().usedBytes; left != 0)
                WriteLog(messages.Messages(), LogLevel::Error, log_category::kMemory,
                         "device '{}' is destroyed before {} bytes of its resources", name, left);
            ownAllocator.reset();
        }
    }
    if (isOwned) {
        if (device) {
            const auto destroy = reinterpret_cast<PFN_vkDestroyDevice>(
                instanceFunctions.vkGetDeviceProcAddr(device, "vkDestroyDevice"));
            if (destroy) destroy(device, allocation);
        }
        Silence();
        if (instance && instanceFunctions.vkDestroyInstance)
            instanceFunctions.vkDestroyInstance(instance, allocation);
    }
    // A second call has nothing to close
    device = VK_NULL_HANDLE;
    instance = VK_NULL_HANDLE;
}

void Device::Impl::LockQueues() {
    if (lockQueues) lockQueues();
}

void Device::Impl::UnlockQueues() {
    if (unlockQueues) unlockQueues();
}

Device::Device(std::unique_ptr<Impl> impl) : m_impl(std::move(impl)) {}

Device::~Device() {
    if (m_impl->savesPipelineCache) SavePipelineCache();
    if (m_impl->Drain()) {
        m_impl->Close();
        return;
    }
    // Objects that the device may still use cannot be freed, nor can the loader and retired objects.
    WriteLog(Log(), LogLevel::Error, log_category::kDevice, "device '{}' hangs: nothing of it is freed",
             m_impl->name);
    m_impl->Silence();
    std::ignore = m_impl.release();
}

const DeviceInfo& Device::Info() const {
    return m_impl->info;
}
const InstanceFunctions& Device::InstanceVk() const {
    return m_impl->instanceFunctions;
}

const DeviceFunctions& Device::Vk() const {
    return m_impl->vk;
}
VkDevice Device::Handle() const {
    return m_impl->device;
}
VkPhysicalDevice Device::PhysicalDevice() const {
    return m_impl->physicalDevice;
}
VkInstance Device::Instance() const {
    return m_impl->instance;
}
bool Device::HasQueue(QueueKind queue) const {
    return m_impl->Queue(queue).isUsed;
}
uint32_t Device::QueueFamily(QueueKind queue) const {
    return m_impl->Queue(queue).family;
}
std::span<const uint32_t> Device::QueueFamilies() const {
    return m_impl->queueFamilies;
}
VkPipelineCache Device::PipelineCache() const {
    return m_impl->pipelineCache;
}
VkPipelineCreateFlags Device::PipelineFlags() const {
    const bool captures = m_impl->capturesStatistics && m_impl->info.optional.pipelineStatistics;
    return captures ? VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR : 0;
}
uint32_t Device::FramesInFlight() const {
    return m_impl->framesInFlight;
}
std::chrono::milliseconds Device::HangLimit() const {
    return m_impl->hangLimit;
}
const VkAllocationCallbacks* Device::AllocationCallbacks() const {
    return m_impl->allocation;
}
uint64_t Device::ValidationMessageCount() const {
    return m_impl->messages.ValidationCount();
}

void Device::SetName(VkObjectType type, uint64_t handle, const std::string& name) {
    if (!m_impl->vk.vkSetDebugUtilsObjectNameEXT || handle == 0) return;
    VkDebugUtilsObjectNameInfoEXT info{};
    info.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT;
    info.objectType = type;
    info.objectHandle = handle;
    info.pObjectName = name.c_str();
    // A failure is ignored, since it affects only a name.
    m_impl->vk.vkSetDebugUtilsObjectNameEXT(m_impl->device, &info);
}

const raygraph::Log& Device::Log() const {
    return m_impl->messages.Messages();
}

void Device::Check(VkResult result, std::string_view what) const {
    if (result >= VK_SUCCESS) return;
    const std::string text = std::string(what) + ": " + ResultName(result);
    switch (result) {
        case VK_ERROR_OUT_OF_HOST_MEMORY:
        case VK_ERROR_OUT_OF_DEVICE_MEMORY:
            throw Error(ErrorKind::OutOfMemory, text, result);
        case VK_ERROR_DEVICE_LOST:
            throw Error(ErrorKind::DeviceLost, Text("{}; {}", text, m_impl->lastPassReports->Text()), result);
        default:
            throw Error(ErrorKind::Vulkan, text, result);
    }
}

std::string LastPassReports::Text() {
    const std::lock_guard lock(m_mutex);
    std::string all;
    for (const Report& report : m_reports)
        if (const std::string text = report(); !text.empty()) all += (all.empty() ? "" : "; ") + text;
    return all.empty() ? "no pass is known" : all;
}

std::shared_ptr<const void> Device::AddLastPassReport(std::function<std::string()> report) {
    const auto entry = m_impl->lastPassReports->Add(std::move(report));
    return {&*entry, [reports = m_impl->lastPassReports, entry](const void*) { reports->Remove(entry); }};
}

bool Device::SavePipelineCache() {
    const std::lock_guard lock(m_impl->pipelineCacheMutex);
    if (!m_impl->savesPipelineCache) return false;
    const auto read = [&](size_t& size, void* target) {
        return m_impl->vk.vkGetPipelineCacheData(m_impl->device, m_impl->pipelineCache, &size, target);
    };
    size_t size = 0, savedBytes = 0;
    std::string problem;
    if (read(size, nullptr) == VK_SUCCESS) {
        std::vector<std::byte> bytes(size);
        // With VK_INCOMPLETE a pipeline was added in between; the truncated data is a valid cache, too.
        if (read(size, bytes.data()) >= VK_SUCCESS) {
            bytes.resize(size);
            savedBytes = size;
            problem = m_impl->pipelineCacheFile.Save(bytes);
        } else {
            problem = "the driver does not give it";
        }
    } else {
        problem = "the driver does not give it";
    }
    if (!problem.empty())
        WriteLog(Log(), LogLevel::Warning, log_category::kCache, "pipeline cache is not saved: {}", problem);
    else
        WriteLog(Log(), LogLevel::Debug, log_category::kCache, "pipeline cache of {} is saved",
                 BytesText(savedBytes));
    return problem.empty();
}

std::optional<double> Device::Measured(std::string_view name) const {
    return m_impl->measurements.Find(name);
}

void Device::StoreMeasurement(std::string_view name, double value) {
    m_impl->measurements.Set(name, value);
}

std::shared_ptr<const std::vector<uint32_t>> Device::Specialized(
    std::span<const uint32_t> spirv, std::span<const SpecializationValue> values) {
    return m_impl->specializedShaders->Find(spirv, values);
}

VkDescriptorSetLayout Device::TextureTableLayout() {
    const std::lock_guard lock(m_impl->tableLayoutMutex);
    if (!m_impl->tableLayout) m_impl->tableLayout = CreateTextureTableLayout(*this);
    return m_impl->tableLayout;
}

}  // namespace raygraph::rhi
