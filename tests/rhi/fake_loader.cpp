#include "tests/rhi/fake_loader.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <set>
#include <span>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "base/check.h"
#include "tests/support/replaced_function.h"

namespace raygraph::testing {
namespace {

// Holds the functions behind the fakes, as the system's loader returned them last.
struct State {
    Lies lies;
    PFN_vkGetInstanceProcAddr getInstanceProcAddr = nullptr;
    PFN_vkGetDeviceProcAddr getDeviceProcAddr = nullptr;
    PFN_vkEnumerateDeviceExtensionProperties enumerateExtensions = nullptr;
    PFN_vkGetPhysicalDeviceFeatures2 features = nullptr;
    PFN_vkGetPhysicalDeviceProperties2 properties = nullptr;
    PFN_vkQueueSubmit2 submit = nullptr;
    PFN_vkWaitSemaphores wait = nullptr;
    PFN_vkGetPhysicalDeviceFormatProperties2 formats = nullptr;
    PFN_vkCreateBuffer createBuffer = nullptr;
    PFN_vkCreateSampler createSampler = nullptr;
    PFN_vkResetCommandPool resetPool = nullptr;
    PFN_vkCmdPipelineBarrier2 barrier = nullptr;
    PFN_vkGetAccelerationStructureBuildSizesKHR buildSizes = nullptr;
    PFN_vkCmdBuildAccelerationStructuresKHR build = nullptr;
    PFN_vkGetPhysicalDeviceMemoryProperties memory = nullptr;
    PFN_vkGetPhysicalDeviceMemoryProperties2 memory2 = nullptr;
    PFN_vkGetBufferMemoryRequirements2 bufferRequirements = nullptr;
    PFN_vkGetImageMemoryRequirements2 imageRequirements = nullptr;
    PFN_vkGetDeviceBufferMemoryRequirements deviceBufferRequirements = nullptr;
    PFN_vkGetDeviceImageMemoryRequirements deviceImageRequirements = nullptr;
    PFN_vkAllocateMemory allocateMemory = nullptr;
    PFN_vkCreateDevice createDevice = nullptr;
    PFN_vkCreateComputePipelines createCompute = nullptr;
    PFN_vkCreateRayTracingPipelinesKHR createRayTracing = nullptr;
    std::mutex rayTracingMutex;      // guards rayTracingMakers
    std::mutex computeMutex;         // guards the three below and areComputePipelinesAlone
    std::set<VkPipeline> capturing;  // pipelines that were made to capture statistics
    std::condition_variable computeCalled;
    uint32_t computeCount = 0;  // calls of vkCreateComputePipelines
    // The real memory types, and those that all resources queried so far can use.
    VkPhysicalDeviceMemoryProperties realMemory{};
    uint32_t usableTypes = ~0u;
};
State* activeState = nullptr;

// Calls `change` with every structure of a pNext chain of the given type.
template <typename T, typename Change>
void ForEach(void* chain, VkStructureType type, Change&& change) {
    for (auto* s = static_cast<VkBaseOutStructure*>(chain); s; s = s->pNext)
        if (s->sType == type) change(*reinterpret_cast<T*>(s));
}

VKAPI_ATTR VkResult VKAPI_CALL EnumerateExtensions(VkPhysicalDevice device, const char* layer,
                                                   uint32_t* count, VkExtensionProperties* properties) {
    uint32_t all = 0;
    activeState->enumerateExtensions(device, layer, &all, nullptr);
    std::vector<VkExtensionProperties> kept(all);
    activeState->enumerateExtensions(device, layer, &all, kept.data());
    std::erase_if(kept, [](const VkExtensionProperties& e) {
        return activeState->lies.hiddenExtension == e.extensionName;
    });
    if (activeState->lies.hasStatistics) {
        VkExtensionProperties& added = kept.emplace_back();
        std::strcpy(added.extensionName, VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME);
    }
    if (properties) std::copy_n(kept.begin(), std::min<size_t>(*count, kept.size()), properties);
    *count = static_cast<uint32_t>(kept.size());
    return VK_SUCCESS;
}

VKAPI_ATTR void VKAPI_CALL Features(VkPhysicalDevice device, VkPhysicalDeviceFeatures2* features) {
    activeState->features(device, features);
    const Lies& lies = activeState->lies;
    if (lies.cannotDraw) features->features.drawIndirectFirstInstance = VK_FALSE;
    if (lies.hasNoBlocks) features->features.textureCompressionBC = VK_FALSE;
    ForEach<VkPhysicalDeviceVulkan12Features>(features, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
                                              [&](auto& f) {
                                                  if (lies.hasNoScalarBlockLayout)
                                                      f.scalarBlockLayout = VK_FALSE;
                                                  if (lies.cannotDraw) f.shaderBufferInt64Atomics = VK_FALSE;
                                              });
    ForEach<VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR>(
        features, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR,
        [&](auto& f) { f.pipelineExecutableInfo = lies.hasStatistics ? VK_TRUE : VK_FALSE; });
}

VKAPI_ATTR void VKAPI_CALL Properties(VkPhysicalDevice device, VkPhysicalDeviceProperties2* properties) {
    activeState->properties(device, properties);
    if (activeState->lies.apiVersion != 0) properties->properties.apiVersion = activeState->lies.apiVersion;
    if (const uint64_t range = activeState->lies.maxStorageBufferRange; range != 0)
        properties->properties.limits.maxStorageBufferRange = static_cast<uint32_t>(range);
    if (activeState->lies.maxPushDescriptors == 0) return;
    ForEach<VkPhysicalDevicePushDescriptorPropertiesKHR>(
        properties, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PUSH_DESCRIPTOR_PROPERTIES_KHR,
        [](auto& p) { p.maxPushDescriptors = activeState->lies.maxPushDescriptors; });
}

VKAPI_ATTR VkResult VKAPI_CALL Submit(VkQueue queue, uint32_t count, const VkSubmitInfo2* infos,
                                      VkFence fence) {
    if (activeState->lies.submitResult != VK_SUCCESS) return activeState->lies.submitResult;
    if (const VkResult next = std::exchange(activeState->lies.nextSubmitResult, VK_SUCCESS)) return next;
    static std::mutex lock;  // devices may submit on several threads
    const std::lock_guard guard(lock);
    for (uint32_t i = 0; i < count; ++i)
        activeState->lies.submitWaits.emplace_back(
            infos[i].pWaitSemaphoreInfos, infos[i].pWaitSemaphoreInfos + infos[i].waitSemaphoreInfoCount);
    return activeState->submit(queue, count, infos, fence);
}

VKAPI_ATTR VkResult VKAPI_CALL Wait(VkDevice device, const VkSemaphoreWaitInfo* info, uint64_t timeout) {
    if (activeState->lies.waitResult != VK_SUCCESS) return activeState->lies.waitResult;
    return activeState->wait(device, info, timeout);
}

VKAPI_ATTR void VKAPI_CALL Formats(VkPhysicalDevice device, VkFormat format,
                                   VkFormatProperties2* properties) {
    activeState->formats(device, format, properties);
    if (activeState->lies.hasNoFloatFilter && format == VK_FORMAT_R32G32B32A32_SFLOAT)
        properties->formatProperties.optimalTilingFeatures &=
            ~VkFormatFeatureFlags{VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT};
}

VKAPI_ATTR VkResult VKAPI_CALL CreateBuffer(VkDevice device, const VkBufferCreateInfo* info,
                                            const VkAllocationCallbacks* allocation, VkBuffer* buffer) {
    int32_t& left = activeState->lies.buffersBeforeFailure;
    if (left >= 0 && left-- == 0) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    return activeState->createBuffer(device, info, allocation, buffer);
}

VKAPI_ATTR VkResult VKAPI_CALL CreateSampler(VkDevice device, const VkSamplerCreateInfo* info,
                                             const VkAllocationCallbacks* allocator, VkSampler* sampler) {
    ++activeState->lies.samplers;
    return activeState->createSampler(device, info, allocator, sampler);
}

VKAPI_ATTR VkResult VKAPI_CALL CreateRayTracing(VkDevice device, VkDeferredOperationKHR operation,
                                                VkPipelineCache cache, uint32_t count,
                                                const VkRayTracingPipelineCreateInfoKHR* infos,
                                                const VkAllocationCallbacks* allocator,
                                                VkPipeline* pipelines) {
    if (const std::shared_future<void> before = activeState->lies.beforeRayTracing; before.valid())
        before.wait();
    {
        const std::lock_guard lock(activeState->rayTracingMutex);
        activeState->lies.rayTracingMakers.push_back(std::this_thread::get_id());
    }
    return activeState->createRayTracing(device, operation, cache, count, infos, allocator, pipelines);
}

VKAPI_ATTR VkResult VKAPI_CALL ResetPool(VkDevice device, VkCommandPool pool, VkCommandPoolResetFlags flags) {
    if (activeState->lies.resetPoolResult != VK_SUCCESS) return activeState->lies.resetPoolResult;
    return activeState->resetPool(device, pool, flags);
}

VKAPI_ATTR void VKAPI_CALL Barrier(VkCommandBuffer commands, const VkDependencyInfo* info) {
    std::vector<VkBufferMemoryBarrier2>& seen = activeState->lies.bufferBarriers;
    seen.insert(seen.end(), info->pBufferMemoryBarriers,
                info->pBufferMemoryBarriers + info->bufferMemoryBarrierCount);
    activeState->barrier(commands, info);
}

VKAPI_ATTR void VKAPI_CALL BuildSizes(VkDevice device, VkAccelerationStructureBuildTypeKHR type,
                                      const VkAccelerationStructureBuildGeometryInfoKHR* info,
                                      const uint32_t* counts,
                                      VkAccelerationStructureBuildSizesInfoKHR* sizes) {
    activeState->buildSizes(device, type, info, counts, sizes);
    sizes->buildScratchSize = std::max(sizes->buildScratchSize, activeState->lies.buildScratchBytes);
}

VKAPI_ATTR void VKAPI_CALL Build(VkCommandBuffer commands, uint32_t count,
                                 const VkAccelerationStructureBuildGeometryInfoKHR* infos,
                                 const VkAccelerationStructureBuildRangeInfoKHR* const* ranges) {
    std::vector<VkBuildAccelerationStructureModeKHR>& modes = activeState->lies.builds.emplace_back();
    for (uint32_t i = 0; i < count; ++i) modes.push_back(infos[i].mode);
    activeState->build(commands, count, infos, ranges);
}

constexpr uint32_t kAllTypes = (1u << (kCachedHostMemory + 1)) - 1;

void TellMemory(VkPhysicalDeviceMemoryProperties& properties) {
    constexpr VkMemoryPropertyFlags kLocal = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
    constexpr VkMemoryPropertyFlags kMapped =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    properties = {};
    properties.memoryHeapCount = 3;
    properties.memoryHeaps[0] = {kFakeDeviceHeapBytes, VK_MEMORY_HEAP_DEVICE_LOCAL_BIT};
    properties.memoryHeaps[1] = {kFakeDeviceHeapBytes, 0};
    properties.memoryHeaps[2] = {kFakeDeviceHeapBytes / 8, VK_MEMORY_HEAP_DEVICE_LOCAL_BIT};
    properties.memoryTypeCount = kCachedHostMemory + 1;
    properties.memoryTypes[kDeviceMemory] = {kLocal, 0};
    properties.memoryTypes[kMappedDeviceMemory] = {kLocal | kMapped, 2};
    properties.memoryTypes[kHostMemory] = {kMapped, 1};
    properties.memoryTypes[kCachedHostMemory] = {kMapped | VK_MEMORY_PROPERTY_HOST_CACHED_BIT, 1};
}

VKAPI_ATTR void VKAPI_CALL Memory(VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties* properties) {
    activeState->memory(device, properties);
    activeState->realMemory = *properties;
    if (activeState->lies.hasSeparateMemory) TellMemory(*properties);
}

VKAPI_ATTR void VKAPI_CALL Memory2(VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties2* properties) {
    activeState->memory2(device, properties);
    activeState->realMemory = properties->memoryProperties;
    if (!activeState->lies.hasSeparateMemory) return;
    TellMemory(properties->memoryProperties);
    ForEach<VkPhysicalDeviceMemoryBudgetPropertiesEXT>(
        properties, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_BUDGET_PROPERTIES_EXT, [](auto& budget) {
            for (uint32_t heap = 0; heap < 3; ++heap) {
                budget.heapBudget[heap] = heap == 2 ? kFakeDeviceBudgetBytes / 8 : kFakeDeviceBudgetBytes;
                budget.heapUsage[heap] = activeState->lies.heapUsage;
            }
        });
}

void TellTypes(VkMemoryRequirements2* requirements) {
    uint32_t& types = requirements->memoryRequirements.memoryTypeBits;
    activeState->usableTypes &= types;
    if (activeState->lies.hasSeparateMemory) types = kAllTypes;
}

// Returns the real type behind the faked ones, which may be mapped and hold anything: one that all resources
// can use, with the properties of mapped memory. If no type serves both images and mapping, mapping wins.
uint32_t RealType() {
    constexpr VkMemoryPropertyFlags kMapped =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    const VkPhysicalDeviceMemoryProperties& real = activeState->realMemory;
    for (const uint32_t usable : {activeState->usableTypes, ~0u})
        for (uint32_t type = 0; type < real.memoryTypeCount; ++type)
            if (((usable >> type) & 1u) != 0 && (real.memoryTypes[type].propertyFlags & kMapped) == kMapped)
                return type;
    return 0;
}

VKAPI_ATTR void VKAPI_CALL BufferRequirements(VkDevice device, const VkBufferMemoryRequirementsInfo2* info,
                                              VkMemoryRequirements2* requirements) {
    activeState->bufferRequirements(device, info, requirements);
    TellTypes(requirements);
}

VKAPI_ATTR void VKAPI_CALL ImageRequirements(VkDevice device, const VkImageMemoryRequirementsInfo2* info,
                                             VkMemoryRequirements2* requirements) {
    activeState->imageRequirements(device, info, requirements);
    TellTypes(requirements);
}

VKAPI_ATTR void VKAPI_CALL DeviceBufferRequirements(VkDevice device,
                                                    const VkDeviceBufferMemoryRequirements* info,
                                                    VkMemoryRequirements2* requirements) {
    activeState->deviceBufferRequirements(device, info, requirements);
    TellTypes(requirements);
}

VKAPI_ATTR void VKAPI_CALL DeviceImageRequirements(VkDevice device,
                                                   const VkDeviceImageMemoryRequirements* info,
                                                   VkMemoryRequirements2* requirements) {
    activeState->deviceImageRequirements(device, info, requirements);
    TellTypes(requirements);
}

VKAPI_ATTR VkResult VKAPI_CALL AllocateMemory(VkDevice device, const VkMemoryAllocateInfo* info,
                                              const VkAllocationCallbacks* allocation,
                                              VkDeviceMemory* memory) {
    Lies& lies = activeState->lies;
    if (!lies.hasSeparateMemory) return activeState->allocateMemory(device, info, allocation, memory);
    uint64_t& left = info->memoryTypeIndex < kHostMemory ? lies.deviceBytesLeft : lies.hostBytesLeft;
    if (info->allocationSize > left) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    left -= info->allocationSize;
    lies.takenBytes.at(info->memoryTypeIndex) += info->allocationSize;
    VkMemoryAllocateInfo real = *info;
    real.memoryTypeIndex = RealType();
    return activeState->allocateMemory(device, &real, allocation, memory);
}

// Removes the extension, which the real device may not have.
VKAPI_ATTR VkResult VKAPI_CALL CreateDevice(VkPhysicalDevice device, const VkDeviceCreateInfo* info,
                                            const VkAllocationCallbacks* allocation, VkDevice* created) {
    if (!activeState->lies.hasStatistics) return activeState->createDevice(device, info, allocation, created);
    std::vector<const char*> extensions;
    for (const char* name : std::span(info->ppEnabledExtensionNames, info->enabledExtensionCount))
        if (std::string_view(name) != VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME)
            extensions.push_back(name);
    VkDeviceCreateInfo real = *info;
    real.ppEnabledExtensionNames = extensions.data();
    real.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
    ForEach<VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR>(
        const_cast<void*>(real.pNext),
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR,
        [](auto& f) { f.pipelineExecutableInfo = VK_FALSE; });
    return activeState->createDevice(device, &real, allocation, created);
}

VKAPI_ATTR VkResult VKAPI_CALL CreateCompute(VkDevice device, VkPipelineCache cache, uint32_t count,
                                             const VkComputePipelineCreateInfo* infos,
                                             const VkAllocationCallbacks* allocation, VkPipeline* pipelines) {
    State& state = *activeState;
    std::unique_lock lock(state.computeMutex);
    ++state.computeCount;
    state.computeCalled.notify_all();
    const auto areAllHere = [&] { return state.computeCount >= state.lies.computePipelinesAtOnce; };
    state.lies.areComputePipelinesAlone |=
        !state.computeCalled.wait_for(lock, std::chrono::seconds(10), areAllHere);
    if (state.lies.computePipelineResult != VK_SUCCESS) return state.lies.computePipelineResult;
    lock.unlock();
    std::vector<VkComputePipelineCreateInfo> real(infos, infos + count);
    for (VkComputePipelineCreateInfo& info : real)
        info.flags &= ~VkPipelineCreateFlags{VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR};
    const VkResult result = state.createCompute(device, cache, count, real.data(), allocation, pipelines);
    lock.lock();
    for (uint32_t i = 0; i < count; ++i)
        if ((infos[i].flags & VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR) != 0)
            state.capturing.insert(pipelines[i]);
    return result;
}

VKAPI_ATTR VkResult VKAPI_CALL Executables(VkDevice, const VkPipelineInfoKHR*, uint32_t* count,
                                           VkPipelineExecutablePropertiesKHR* programs) {
    if (programs) {
        RG_CHECK_EQ(*count, 2u);
        std::strcpy(programs[0].name, "main");
        programs[0].subgroupSize = 8;
        std::strcpy(programs[1].name, "other");
        programs[1].subgroupSize = 0;
    }
    *count = 2;
    return VK_SUCCESS;
}

VKAPI_ATTR VkResult VKAPI_CALL Statistics(VkDevice, const VkPipelineExecutableInfoKHR* info, uint32_t* count,
                                          VkPipelineExecutableStatisticKHR* statistics) {
    RG_CHECK(activeState->capturing.contains(info->pipeline));
    const uint32_t known = info->executableIndex == 0 ? 2 : 0;
    if (statistics && known > 0) {
        RG_CHECK_EQ(*count, known);
        std::strcpy(statistics[0].name, "Register Count");
        std::strcpy(statistics[0].description, "How many registers an invocation has.");
        statistics[0].format = VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_UINT64_KHR;
        statistics[0].value.u64 = 40;
        std::strcpy(statistics[1].name, "Spills");
        statistics[1].format = VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_BOOL32_KHR;
        statistics[1].value.b32 = VK_TRUE;
    }
    *count = known;
    return VK_SUCCESS;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetDeviceProcAddr(VkDevice device, const char* name) {
    const PFN_vkVoidFunction real = activeState->getDeviceProcAddr(device, name);
    if (std::strcmp(name, "vkQueueSubmit2") == 0) return Replaced(real, activeState->submit, Submit);
    if (std::strcmp(name, "vkWaitSemaphores") == 0) return Replaced(real, activeState->wait, Wait);
    if (std::strcmp(name, "vkCreateBuffer") == 0)
        return Replaced(real, activeState->createBuffer, CreateBuffer);
    if (std::strcmp(name, "vkCreateSampler") == 0)
        return Replaced(real, activeState->createSampler, CreateSampler);
    if (std::strcmp(name, "vkResetCommandPool") == 0)
        return Replaced(real, activeState->resetPool, ResetPool);
    if (std::strcmp(name, "vkCmdPipelineBarrier2") == 0) return Replaced(real, activeState->barrier, Barrier);
    const auto is = [&](const char* other) { return std::strcmp(name, other) == 0; };
    if (is("vkGetAccelerationStructureBuildSizesKHR"))
        return Replaced(real, activeState->buildSizes, BuildSizes);
    if (is("vkCmdBuildAccelerationStructuresKHR")) return Replaced(real, activeState->build, Build);
    if (is("vkCreateComputePipelines")) return Replaced(real, activeState->createCompute, CreateCompute);
    if (activeState->lies.hasStatistics) {
        if (is("vkGetPipelineExecutablePropertiesKHR"))
            return reinterpret_cast<PFN_vkVoidFunction>(Executables);
        if (is("vkGetPipelineExecutableStatisticsKHR"))
            return reinterpret_cast<PFN_vkVoidFunction>(Statistics);
    }
    if (is("vkCreateRayTracingPipelinesKHR"))
        return Replaced(real, activeState->createRayTracing, CreateRayTracing);
    if (is("vkAllocateMemory")) return Replaced(real, activeState->allocateMemory, AllocateMemory);
    if (is("vkGetBufferMemoryRequirements2"))
        return Replaced(real, activeState->bufferRequirements, BufferRequirements);
    if (is("vkGetImageMemoryRequirements2"))
        return Replaced(real, activeState->imageRequirements, ImageRequirements);
    if (is("vkGetDeviceBufferMemoryRequirements"))
        return Replaced(real, activeState->deviceBufferRequirements, DeviceBufferRequirements);
    if (is("vkGetDeviceImageMemoryRequirements"))
        return Replaced(real, activeState->deviceImageRequirements, DeviceImageRequirements);
    return real;
}

VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL GetInstanceProcAddr(VkInstance instance, const char* name) {
    const PFN_vkVoidFunction real = activeState->getInstanceProcAddr(instance, name);
    const auto is = [&](const char* other) { return std::strcmp(name, other) == 0; };
    if (is("vkGetDeviceProcAddr")) return Replaced(real, activeState->getDeviceProcAddr, GetDeviceProcAddr);
    if (is("vkEnumerateDeviceExtensionProperties"))
        return Replaced(real, activeState->enumerateExtensions, EnumerateExtensions);
    if (is("vkCreateDevice")) return Replaced(real, activeState->createDevice, CreateDevice);
    if (is("vkGetPhysicalDeviceFeatures2")) return Replaced(real, activeState->features, Features);
    if (is("vkGetPhysicalDeviceFormatProperties2")) return Replaced(real, activeState->formats, Formats);
    if (is("vkGetPhysicalDeviceMemoryProperties")) return Replaced(real, activeState->memory, Memory);
    if (is("vkGetPhysicalDeviceMemoryProperties2")) return Replaced(real, activeState->memory2, Memory2);
    if (is("vkGetPhysicalDeviceProperties2")) return Replaced(real, activeState->properties, Properties);
    return real;
}

}  // namespace

FakeLoader::FakeLoader() : m_system(rhi::VulkanLoader::Open()) {
    RG_CHECK(activeState == nullptr);
    activeState = new State;
    activeState->getInstanceProcAddr = m_system->GetInstanceProcAddr();
}

FakeLoader::~FakeLoader() {
    delete activeState;
    activeState = nullptr;
}

PFN_vkGetInstanceProcAddr FakeLoader::Entry() const {
    return GetInstanceProcAddr;
}

Lies& FakeLoader::Tell() {
    return activeState->lies;
}

}  // namespace raygraph::testing
