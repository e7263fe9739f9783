// Device::Adopt: checks a host's device against the requirements, and wraps it.
#include <algorithm>

#include "base/text.h"

#include "rhi/device_impl.h"

namespace raygraph::rhi {
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
    const VkQueueFlags needed = Requirements().queueFlags;
    if (desc.queueFamily >= familyCount)
        refusals.push_back(
            Text("queue family {} does not exist, there are {}", desc.queueFamily, familyCount));
    else if ((families[desc.queueFamily].queueFamilyProperties.queueFlags & needed) != needed)
        refusals.push_back(
            Text("queue family {} is not for graphics, compute and transfer", desc.queueFamily));
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
    impl->queue = desc.queue;
    impl->queueFamily = desc.queueFamily;
    impl->framesInFlight = std::max(desc.framesInFlight, 1u);
    impl->allocation = desc.allocationCallbacks;
    impl->lockQueue = desc.lockQueue;
    impl->unlockQueue = desc.unlockQueue;
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
