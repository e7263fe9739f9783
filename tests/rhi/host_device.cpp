#include "tests/rhi/host_device.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

namespace raygraph::testing {
namespace {

// Before each block is its size, padded so that the block keeps its alignment.
size_t HeaderBytes(size_t alignment) {
    return std::max(alignment, alignof(std::max_align_t));
}

void Require(VkResult result, const char* what) {
    if (result != VK_SUCCESS) throw std::runtime_error(std::string("host: ") + what + " failed");
}

VKAPI_ATTR VkBool32 VKAPI_CALL Receive(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                       VkDebugUtilsMessageTypeFlagsEXT,
                                       const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    *static_cast<std::string*>(user) += std::string(data->pMessage) + "\n";
    return VK_FALSE;
}

}  // namespace

CountingAllocator::CountingAllocator() {
    m_callbacks.pUserData = this;
    m_callbacks.pfnAllocation = Allocate;
    m_callbacks.pfnReallocation = Reallocate;
    m_callbacks.pfnFree = Free;
}

void* CountingAllocator::Allocate(void* user, size_t size, size_t alignment, VkSystemAllocationScope) {
    if (size == 0) return nullptr;
    const size_t header = HeaderBytes(alignment);
    const size_t total = (header + size + header - 1) / header * header;
    auto* memory = static_cast<std::byte*>(std::aligned_alloc(header, total));
    if (!memory) return nullptr;
    // The two words just before the block tell Free and Reallocate where it starts and how long it is.
    std::memcpy(memory + header - sizeof(size_t), &size, sizeof(size_t));
    std::memcpy(memory + header - 2 * sizeof(size_t), &header, sizeof(size_t));
    auto* self = static_cast<CountingAllocator*>(user);
    ++self->m_live;
    ++self->m_total;
    return memory + header;
}

void* CountingAllocator::Reallocate(void* user, void* old, size_t size, size_t alignment,
                                    VkSystemAllocationScope scope) {
    void* memory = Allocate(user, size, alignment, scope);
    if (old && memory) {
        size_t oldSize = 0;
        std::memcpy(&oldSize, static_cast<std::byte*>(old) - sizeof(size_t), sizeof(size_t));
        std::memcpy(memory, old, std::min(size, oldSize));
    }
    if (old && (memory || size == 0)) Free(user, old);
    return memory;
}

void CountingAllocator::Free(void* user, void* memory) {
    if (!memory) return;
    size_t header = 0;
    std::memcpy(&header, static_cast<std::byte*>(memory) - 2 * sizeof(size_t), sizeof(size_t));
    --static_cast<CountingAllocator*>(user)->m_live;
    std::free(static_cast<std::byte*>(memory) - header);
}

HostDevice::HostDevice(bool wantsValidation) : m_loader(rhi::VulkanLoader::Open()) {
    try {
        CreateInstance(rhi::LoadGlobalFunctions(m_loader->GetInstanceProcAddr()), wantsValidation);
        CreateDevice();
    } catch (...) {
        Destroy();
        throw;
    }
}

void HostDevice::CreateInstance(const rhi::GlobalFunctions& global, bool wantsValidation) {
    constexpr const char* kLayer = "VK_LAYER_KHRONOS_validation";
    uint32_t layerCount = 0;
    global.vkEnumerateInstanceLayerProperties(&layerCount, nullptr);
    std::vector<VkLayerProperties> layers(layerCount);
    global.vkEnumerateInstanceLayerProperties(&layerCount, layers.data());
    const bool hasLayer =
        wantsValidation && std::any_of(layers.begin(), layers.end(), [&](const VkLayerProperties& layer) {
            return std::strcmp(layer.layerName, kLayer) == 0;
        });
    uint32_t extensionCount = 0;
    global.vkEnumerateInstanceExtensionProperties(nullptr, &extensionCount, nullptr);
    std::vector<VkExtensionProperties> known(extensionCount);
    global.vkEnumerateInstanceExtensionProperties(nullptr, &extensionCount, known.data());
    m_hasDebugUtils = std::any_of(known.begin(), known.end(), [](const VkExtensionProperties& extension) {
        return std::strcmp(extension.extensionName, VK_EXT_DEBUG_UTILS_EXTENSION_NAME) == 0;
    });
    std::vector<const char*> extensions;
    if (m_hasDebugUtils) extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    if (hasLayer) extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);

    const auto synchronization = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkValidationFeaturesEXT validation{};
    validation.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT;
    validation.enabledValidationFeatureCount = 1;
    validation.pEnabledValidationFeatures = &synchronization;
    VkApplicationInfo application{};
    application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    application.pApplicationName = "host";
    application.apiVersion = rhi::Requirements().apiVersion;
    VkInstanceCreateInfo instanceInfo{};
    instanceInfo.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    instanceInfo.pNext = hasLayer ? &validation : nullptr;
    instanceInfo.pApplicationInfo = &application;
    instanceInfo.enabledLayerCount = hasLayer ? 1 : 0;
    instanceInfo.ppEnabledLayerNames = &kLayer;
    instanceInfo.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
    instanceInfo.ppEnabledExtensionNames = extensions.data();
    Require(global.vkCreateInstance(&instanceInfo, nullptr, &m_instance), "vkCreateInstance");
    m_instanceFunctions =
        rhi::LoadInstanceFunctions(m_loader->GetInstanceProcAddr(), m_instance, m_hasDebugUtils);
    if (!m_hasDebugUtils) return;
    VkDebugUtilsMessengerCreateInfoEXT messenger{};
    messenger.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
    messenger.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    messenger.pfnUserCallback = Receive;
    messenger.pUserData = &m_validationText;
    Require(m_instanceFunctions.vkCreateDebugUtilsMessengerEXT(m_instance, &messenger, nullptr, &m_messenger),
            "vkCreateDebugUtilsMessengerEXT");
}

void HostDevice::CreateDevice() {
    const PFN_vkGetInstanceProcAddr entry = m_loader->GetInstanceProcAddr();
    uint32_t count = 0;
    m_instanceFunctions.vkEnumeratePhysicalDevices(m_instance, &count, nullptr);
    std::vector<VkPhysicalDevice> devices(count);
    m_instanceFunctions.vkEnumeratePhysicalDevices(m_instance, &count, devices.data());
    for (VkPhysicalDevice device : devices)
        if (!m_physicalDevice && rhi::UnmetRequirements(device, entry, m_instance).empty())
            m_physicalDevice = device;
    if (!m_physicalDevice) throw std::runtime_error("host: no device meets the requirements");

    const float priority = 1.0f;
    std::vector<VkDeviceQueueCreateInfo> queueInfos;
    for (const rhi::QueueKind kind : rhi::kQueueKinds) {
        const auto family = rhi::QueueFamilyFor(m_physicalDevice, entry, m_instance, kind);
        m_queues[rhi::IndexOf(kind)].family = family.value_or(m_queues.front().family);
        if (!family) continue;
        VkDeviceQueueCreateInfo& queue = queueInfos.emplace_back();
        queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
        queue.queueFamilyIndex = *family;
        queue.queueCount = 1;
        queue.pQueuePriorities = &priority;
    }
    const rhi::FeatureChain features = rhi::FeaturesFor(m_physicalDevice, entry, m_instance);
    const std::vector<const char*> names = rhi::ExtensionsFor(m_physicalDevice, entry, m_instance);
    m_extensions.assign(names.begin(), names.end());
    VkDeviceCreateInfo deviceInfo{};
    deviceInfo.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
    deviceInfo.pNext = features.Root();
    deviceInfo.queueCreateInfoCount = static_cast<uint32_t>(queueInfos.size());
    deviceInfo.pQueueCreateInfos = queueInfos.data();
    deviceInfo.enabledExtensionCount = static_cast<uint32_t>(names.size());
    deviceInfo.ppEnabledExtensionNames = names.data();
    Require(m_instanceFunctions.vkCreateDevice(m_physicalDevice, &deviceInfo, nullptr, &m_device),
            "vkCreateDevice");
    m_functions =
        rhi::LoadDeviceFunctions(m_instanceFunctions.vkGetDeviceProcAddr, m_device, m_hasDebugUtils);
    for (rhi::AdoptedQueue& queue : m_queues)
        m_functions.vkGetDeviceQueue(m_device, queue.family, 0, &queue.queue);
}

HostDevice::~HostDevice() {
    Destroy();
}

void HostDevice::Destroy() {
    if (m_device && m_functions.vkDestroyDevice) m_functions.vkDestroyDevice(m_device, nullptr);
    if (m_messenger) m_instanceFunctions.vkDestroyDebugUtilsMessengerEXT(m_instance, m_messenger, nullptr);
    if (m_instance && m_instanceFunctions.vkDestroyInstance)
        m_instanceFunctions.vkDestroyInstance(m_instance, nullptr);
}

rhi::AdoptedDeviceDesc HostDevice::Desc() const {
    rhi::AdoptedDeviceDesc desc;
    desc.name = "the host";
    desc.instance = m_instance;
    desc.physicalDevice = m_physicalDevice;
    desc.device = m_device;
    desc.queue = m_queues.front().queue;
    desc.queueFamily = m_queues.front().family;
    desc.getInstanceProcAddr = m_loader->GetInstanceProcAddr();
    desc.enabledExtensions = m_extensions;
    desc.enabledFeatures = rhi::OptionalFeaturesOf(m_physicalDevice, desc.getInstanceProcAddr, m_instance);
    desc.debugUtilsEnabled = m_hasDebugUtils;
    return desc;
}

rhi::AdoptedDeviceDesc HostDevice::DescWithQueues() const {
    rhi::AdoptedDeviceDesc desc = Desc();
    desc.computeQueue = m_queues[rhi::IndexOf(rhi::QueueKind::Compute)];
    desc.transferQueue = m_queues[rhi::IndexOf(rhi::QueueKind::Transfer)];
    return desc;
}

}  // namespace raygraph::testing
