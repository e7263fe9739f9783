// Device::Create and Device::Enumerate: instance, choice of the physical device, logical device.

#include <algorithm>
#include <array>
#include <cstring>

#include "base/text.h"
#include "rhi/choose_device.h"
#include "rhi/device_impl.h"

namespace raygraph::rhi {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

// Returns the extensions of the loader, and those of `layer` if it is not null.
std::vector<std::string> InstanceExtensions(const GlobalFunctions& vk, const char* layer) {
    std::vector<std::string> names;
    for (const char* source : {static_cast<const char*>(nullptr), layer}) {
        uint32_t count = 0;
        vk.vkEnumerateInstanceExtensionProperties(source, &count, nullptr);
        std::vector<VkExtensionProperties> properties(count);
        vk.vkEnumerateInstanceExtensionProperties(source, &count, properties.data());
        for (uint32_t i = 0; i < count; ++i) names.emplace_back(properties[i].extensionName);
        if (!layer) break;
    }
    return names;
}

bool HasLayer(const GlobalFunctions& vk, const char* layer) {
    uint32_t count = 0;
    vk.vkEnumerateInstanceLayerProperties(&count, nullptr);
    std::vector<VkLayerProperties> layers(count);
    vk.vkEnumerateInstanceLayerProperties(&count, layers.data());
    return std::any_of(layers.begin(), layers.end(),
                       [&](const VkLayerProperties& l) { return std::strcmp(l.layerName, layer) == 0; });
}

struct InstanceDesc {
    std::string name;
    bool validation = false;
    bool debugUtils = false;  // set if the extension exists
    std::vector<std::string> surfaceExtensions = {};
};

struct CreatedInstance {
    VkInstance handle = VK_NULL_HANDLE;
    bool hasDebugUtils = false;
};

// `messenger` may be null; it is chained, so that it also receives messages of vkCreateInstance.
CreatedInstance CreateInstance(PFN_vkGetInstanceProcAddr loader, const InstanceDesc& desc,
                               const VkDebugUtilsMessengerCreateInfoEXT* messenger) {
    const GlobalFunctions vk = LoadGlobalFunctions(loader);
    uint32_t version = 0;
    vk.vkEnumerateInstanceVersion(&version);
    if (version < VK_API_VERSION_1_3)
        throw MakeError(ErrorKind::NoDevice, "the Vulkan loader knows Vulkan 1.{}, needs 1.3",
                        VK_API_VERSION_MINOR(version));
    if (desc.validation && !HasLayer(vk, kValidationLayer))
        throw MakeError(ErrorKind::NoDevice, "validation was asked for, but the layer {} is not installed",
                        kValidationLayer);

    const std::vector<std::string> available =
        InstanceExtensions(vk, desc.validation ? kValidationLayer : nullptr);
    const auto has = [&](const char* name) {
        return std::find(available.begin(), available.end(), name) != available.end();
    };
    CreatedInstance created;
    created.hasDebugUtils = desc.debugUtils && has(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    std::vector<const char*> extensions;
    if (created.hasDebugUtils) extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    if (desc.validation) extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
    for (const std::string& extension : desc.surfaceExtensions) {
        if (!has(extension.c_str()))
            throw MakeError(ErrorKind::NoDevice,
                            "the window system needs {}, which no Vulkan driver of this machine has",
                            extension);
        extensions.push_back(extension.c_str());
    }

    VkApplicationInfo application{};
    application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    application.pApplicationName = desc.name.c_str();
    application.pEngineName = "raygraph";
    application.apiVersion = VK_API_VERSION_1_3;
    VkDebugUtilsMessengerCreateInfoEXT watch{};
    const void* chain = nullptr;
    if (messenger && created.hasDebugUtils) {
        watch = *messenger;
        chain = &watch;
    }
    // Core validation is the layer's default. GPU-assisted validation stays off: in 1.3.239 it reports
    // false errors.
    const auto synchronization = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    VkValidationFeaturesEXT features{};
    features.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT;
    features.pNext = chain;
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = &synchronization;

    VkInstanceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    info.pNext = desc.validation ? &features : chain;
    info.pApplicationInfo = &application;
    info.enabledLayerCount = desc.validation ? 1 : 0;
    info.ppEnabledLayerNames = &kValidationLayer;
    info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    const VkResult result = vk.vkCreateInstance(&info, nullptr, &created.handle);
    if (result != VK_SUCCESS) {
        // A loader without any driver returns this result
        const char* cause = result == VK_ERROR_INCOMPATIBLE_DRIVER ? " (no Vulkan driver is installed)" : "";
        throw Error(KindOfCreationError(result), Text("vkCreateInstance: {}{}", ResultName(result), cause),
                    result);
    }
    return created;
}

std::vector<VkPhysicalDevice> PhysicalDevices(const InstanceFunctions& vk, VkInstance instance) {
    uint32_t count = 0;
    vk.vkEnumeratePhysicalDevices(instance, &count, nullptr);
    std::vector<VkPhysicalDevice> devices(count);
    vk.vkEnumeratePhysicalDevices(instance, &count, devices.data());
    devices.resize(count);
    return devices;
}

std::vector<DeviceReport> ReportOnAll(const std::vector<VkPhysicalDevice>& devices,
                                      PFN_vkGetInstanceProcAddr loader, VkInstance instance) {
    std::vector<DeviceReport> reports;
    reports.reserve(devices.size());
    for (VkPhysicalDevice device : devices)
        reports.push_back(ReportOn(static_cast<uint32_t>(reports.size()), device, loader, instance));
    return reports;
}

}  // namespace

std::unique_ptr<Device> Device::Create(const DeviceDesc& desc) {
    auto impl = std::make_unique<Impl>(desc.log);
    if (!desc.getInstanceProcAddr) impl->loader = VulkanLoader::Open();
    impl->getInstanceProcAddr =
        desc.getInstanceProcAddr ? desc.getInstanceProcAddr : impl->loader->GetInstanceProcAddr();
    impl->name = desc.name;
    impl->isOwned = true;
    impl->framesInFlight = std::max(desc.framesInFlight, 1u);
    impl->savesPipelineCache = desc.savePipelineCache;
    impl->capturesStatistics = desc.capturesStatistics;

    const VkDebugUtilsMessengerCreateInfoEXT messenger = impl->messages.MessengerInfo();
    const CreatedInstance created = CreateInstance(
        impl->getInstanceProcAddr,
        {desc.name, desc.validation, desc.debugNames || desc.validation, desc.surfaceExtensions},
        desc.validation ? &messenger : nullptr);
    impl->instance = created.handle;
    impl->hasDebugUtils = created.hasDebugUtils;
    impl->instanceFunctions =
        LoadInstanceFunctions(impl->getInstanceProcAddr, impl->instance, impl->hasDebugUtils);
    if (desc.validation && impl->hasDebugUtils) {
        const VkResult result = impl->instanceFunctions.vkCreateDebugUtilsMessengerEXT(
            impl->instance, &messenger, nullptr, &impl->messenger);
        if (result != VK_SUCCESS)
            throw Error(ErrorKind::NoDevice, Text("vkCreateDebugUtilsMessengerEXT: {}", ResultName(result)),
                        result);
    }

    const std::vector<VkPhysicalDevice> devices = PhysicalDevices(impl->instanceFunctions, impl->instance);
    const uint32_t choice =
        ChooseDevice(ReportOnAll(devices, impl->getInstanceProcAddr, impl->instance), desc.select);
    impl->physicalDevice = devices[choice];

    const float priority = 1.0f;
    std::vector<VkDeviceQueueCreateInfo> queueInfos;
    for (const QueueKind kind : kQueueKinds) {
        if (kind != QueueKind::Main && !desc.usesOtherQueues) continue;
        const std::optional<uint32_t> family =
            QueueFamilyFor(impl->physicalDevice, impl->getInstanceProcAddr, impl->instance, kind);
        if (!family) continue;
        impl->Queue(kind).isUsed = true;
        impl->Queue(kind).family = *family;
        VkDeviceQueueCreateInfo& queue = queueInfos.emplace_back();
        queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
        queue.queueFamilyIndex = *family;
        queue.queueCount = 1;
        queue.pQueuePriorities = &priority;
    }
    const FeatureChain features =
        FeaturesFor(impl->physicalDevice, impl->getInstanceProcAddr, impl->instance);
    std::vector<const char*> extensions =
        ExtensionsFor(impl->physicalDevice, impl->getInstanceProcAddr, impl->instance);
    if (!desc.surfaceExtensions.empty()) extensions.push_back(VK_KHR_SWAPCHAIN_EXTENSION_NAME);
    VkDeviceCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
    info.pNext = features.Root();
    info.queueCreateInfoCount = static_cast<uint32_t>(queueInfos.size());
    info.pQueueCreateInfos = queueInfos.data();
    info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    const VkResult result =
        impl->instanceFunctions.vkCreateDevice(impl->physicalDevice, &info, nullptr, &impl->device);
    if (result != VK_SUCCESS)
        throw Error(KindOfCreationError(result),
                    Text("device '{}': vkCreateDevice: {}", desc.name, ResultName(result)), result);

    impl->Open(OptionalFeaturesOf(impl->physicalDevice, impl->getInstanceProcAddr, impl->instance),
               PipelineCacheFolder(desc.cacheDirectory), desc.hangLimit);
    return std::unique_ptr<Device>(new Device(std::move(impl)));
}

std::vector<DeviceReport> Device::Enumerate(PFN_vkGetInstanceProcAddr loader) {
    std::shared_ptr<VulkanLoader> library;
    CreatedInstance instance;
    try {
        if (!loader) {
            library = VulkanLoader::Open();
            loader = library->GetInstanceProcAddr();
        }
        instance = CreateInstance(loader, {"raygraph", false, false}, nullptr);
    } catch (const Error&) {
        return {};  // no loader, or no driver at all: no devices
    }
    const InstanceFunctions vk = LoadInstanceFunctions(loader, instance.handle, false);
    const auto destroy = [&](VkInstance_T* handle) { vk.vkDestroyInstance(handle, nullptr); };
    const std::unique_ptr<VkInstance_T, decltype(destroy)> owner(instance.handle, destroy);
    return ReportOnAll(PhysicalDevices(vk, instance.handle), loader, instance.handle);
}

// --- Device::Adopt: checks the device of a host against the requirements, and wraps it ---

namespace {

std::string Missing(const AdoptedDeviceDesc& desc) {
    if (!desc.getInstanceProcAddr) return "getInstanceProcAddr";
    if (!desc.instance) return "instance";
    if (!desc.physicalDevice) return "physicalDevice";
    if (!desc.device) return "device";
    if (!desc.queue) return "queue";
    return {};
}

}  // namespace

std::unique_ptr<Device> Device::Adopt(const AdoptedDeviceDesc& desc) {
    const std::string subject = "adopted device '" + desc.name + "'";
    if (const std::string missing = Missing(desc); !missing.empty())
        throw MakeError(ErrorKind::Usage, "{}: {} is null", subject, missing);
    if (static_cast<bool>(desc.lockQueue) != static_cast<bool>(desc.unlockQueue))
        throw MakeError(ErrorKind::Usage, "{}: lockQueue and unlockQueue are given both or neither", subject);

    std::vector<std::string> refusals =
        UnmetRequirements(desc.physicalDevice, desc.getInstanceProcAddr, desc.instance);
    for (const ExtensionRequirement& extension : Requirements().extensions)
        if (extension.isRequired && std::find(desc.enabledExtensions.begin(), desc.enabledExtensions.end(),
                                              extension.name) == desc.enabledExtensions.end())
            refusals.push_back(std::string(extension.name) + " is not enabled");
    const InstanceFunctions vk =
        LoadInstanceFunctions(desc.getInstanceProcAddr, desc.instance, desc.debugUtilsEnabled);
    uint32_t familyCount = 0;
    vk.vkGetPhysicalDeviceQueueFamilyProperties2(desc.physicalDevice, &familyCount, nullptr);
    std::vector<VkQueueFamilyProperties2> families(
        familyCount, {VK_STRUCTURE_TYPE_QUEUE_FAMILY_PROPERTIES_2, nullptr, {}});
    vk.vkGetPhysicalDeviceQueueFamilyProperties2(desc.physicalDevice, &familyCount, families.data());
    const auto refuseFamily = [&](const AdoptedQueue& queue, VkQueueFlags needed, const char* what) {
        if (!queue.queue) return;
        if (queue.family >= familyCount)
            refusals.push_back(
                Text("queue family {} does not exist, there are {}", queue.family, familyCount));
        else if ((families[queue.family].queueFamilyProperties.queueFlags & needed) != needed)
            refusals.push_back(Text("queue family {} is not for {}", queue.family, what));
    };
    const AdoptedQueue mainQueue{desc.queue, desc.queueFamily};
    refuseFamily(mainQueue, Requirements().queueFlags, "graphics, compute and transfer");
    refuseFamily(desc.computeQueue, VK_QUEUE_COMPUTE_BIT, "compute");
    const auto timestampBits = [&](uint32_t family) {
        return family < familyCount ? families[family].queueFamilyProperties.timestampValidBits : 0;
    };
    if (desc.computeQueue.queue && timestampBits(desc.computeQueue.family) != timestampBits(desc.queueFamily))
        refusals.push_back(Text("queue family {} has other timestamps than family {}",
                                desc.computeQueue.family, desc.queueFamily));
    // Graphics and compute include transfers, whether their families say so or not.
    if (desc.transferQueue.family >= familyCount ||
        (families[desc.transferQueue.family].queueFamilyProperties.queueFlags &
         (VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT)) == 0)
        refuseFamily(desc.transferQueue, VK_QUEUE_TRANSFER_BIT, "transfer");
    if (!refusals.empty()) {
        std::string text = subject + " cannot be used";
        const char* separator = ": ";
        for (const std::string& refusal : refusals) {
            text += separator + refusal;
            separator = ", ";
        }
        throw Error(ErrorKind::NoDevice, text);
    }

    auto impl = std::make_unique<Impl>(desc.log);
    impl->getInstanceProcAddr = desc.getInstanceProcAddr;
    impl->name = desc.name;
    impl->hasDebugUtils = desc.debugUtilsEnabled;
    impl->instance = desc.instance;
    impl->physicalDevice = desc.physicalDevice;
    impl->device = desc.device;
    for (const auto& [kind, queue] :
         {std::pair(QueueKind::Main, mainQueue), std::pair(QueueKind::Compute, desc.computeQueue),
          std::pair(QueueKind::Transfer, desc.transferQueue)}) {
        impl->Queue(kind).isUsed = queue.queue != VK_NULL_HANDLE;
        impl->Queue(kind).queue = queue.queue;
        impl->Queue(kind).family = queue.family;
    }
    impl->allocator = desc.memoryAllocator;
    impl->framesInFlight = std::max(desc.framesInFlight, 1u);
    impl->allocation = desc.allocationCallbacks;
    impl->lockQueues = desc.lockQueue;
    impl->unlockQueues = desc.unlockQueue;
    impl->instanceFunctions = vk;
    impl->savesPipelineCache = desc.savePipelineCache;
    const OptionalFeatures available =
        Restrict(OptionalFeaturesOf(desc.physicalDevice, desc.getInstanceProcAddr, desc.instance),
                 desc.enabledExtensions);
    impl->Open(Restrict(available, desc.enabledFeatures), PipelineCacheFolder(desc.cacheDirectory),
               desc.hangLimit);
    return std::unique_ptr<Device>(new Device(std::move(impl)));
}

}  // namespace raygraph::rhi
