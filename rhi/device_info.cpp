// Reads the properties of a physical device; names of results and types.
#include <algorithm>

#include "base/text.h"
#include "rhi/device.h"
#include "rhi/device_impl.h"
#include "rhi/device_requirements.h"

namespace raygraph::rhi {
namespace {

DeviceType TypeOf(VkPhysicalDeviceType type) {
    switch (type) {
        case VK_PHYSICAL_DEVICE_TYPE_CPU:
            return DeviceType::Cpu;
        case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
            return DeviceType::Integrated;
        case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
            return DeviceType::Discrete;
        case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
            return DeviceType::Virtual;
        default:
            return DeviceType::Other;
    }
}

std::string DriverText(const VkPhysicalDeviceDriverProperties& driver) {
    std::string text = driver.driverName;
    if (driver.driverInfo[0]) text += std::string(" ") + driver.driverInfo;
    return text;
}

}  // namespace

std::string MissingFeatures(const OptionalFeatures& features) {
    std::string text;
    const auto add = [&](bool isPresent, const char* name) {
        if (!isPresent) text += (text.empty() ? "" : ", ") + std::string(name);
    };
    add(features.rayQuery, "ray query");
    add(features.positionFetch, "position fetch");
    add(features.shaderClock, "shader clock");
    add(features.invocationReorder, "invocation reorder");
    add(features.opacityMicromap, "opacity micromaps");
    add(features.wireframe, "wireframes");
    add(features.clipDistance, "clip distances");
    add(features.multiDrawIndirect, "multi-draw indirect");
    add(features.drawIndirectFirstInstance, "first instances of indirect draws");
    add(features.bufferInt64Atomics, "64-bit atomics");
    add(features.textureCompressionBc, "compressed textures");
    add(features.samplerAnisotropy, "anisotropic filters");
    add(features.layeredTargets, "layered targets");
    add(features.memoryBudget, "memory budgets");
    return text;
}

DeviceInfo ReadDeviceInfo(const InstanceFunctions& vk, VkPhysicalDevice device, uint32_t queueFamily,
                          const OptionalFeatures& optional) {
    const PropertyChain<VkPhysicalDeviceDriverProperties, VkPhysicalDeviceSubgroupProperties,
                        VkPhysicalDeviceMaintenance4Properties, VkPhysicalDevicePushDescriptorPropertiesKHR,
                        VkPhysicalDeviceAccelerationStructurePropertiesKHR,
                        VkPhysicalDeviceRayTracingPipelinePropertiesKHR>
        chain(vk, device);
    const auto& driver = chain.Get<VkPhysicalDeviceDriverProperties>();
    const auto& acceleration = chain.Get<VkPhysicalDeviceAccelerationStructurePropertiesKHR>();
    const auto& tracing = chain.Get<VkPhysicalDeviceRayTracingPipelinePropertiesKHR>();
    const VkPhysicalDeviceProperties& properties = chain.Core().properties;

    uint32_t familyCount = 0;
    vk.vkGetPhysicalDeviceQueueFamilyProperties2(device, &familyCount, nullptr);
    std::vector<VkQueueFamilyProperties2> families(
        familyCount, {VK_STRUCTURE_TYPE_QUEUE_FAMILY_PROPERTIES_2, nullptr, {}});
    vk.vkGetPhysicalDeviceQueueFamilyProperties2(device, &familyCount, families.data());

    DeviceInfo info;
    info.name = properties.deviceName;
    info.driver = DriverText(driver);
    info.type = TypeOf(properties.deviceType);
    info.apiVersion = properties.apiVersion;
    info.vendorId = properties.vendorID;
    info.isLavapipe = driver.driverID == VK_DRIVER_ID_MESA_LLVMPIPE;
    info.shaderGroupHandleSize = tracing.shaderGroupHandleSize;
    info.shaderGroupHandleAlignment = tracing.shaderGroupHandleAlignment;
    info.shaderGroupBaseAlignment = tracing.shaderGroupBaseAlignment;
    info.maxShaderGroupStride = tracing.maxShaderGroupStride;
    info.maxRayRecursionDepth = tracing.maxRayRecursionDepth;
    info.maxRayInvocationCount = tracing.maxRayDispatchInvocationCount;
    std::copy_n(properties.limits.maxComputeWorkGroupCount, 3, info.maxGroupCounts.begin());
    info.scratchAlignment = acceleration.minAccelerationStructureScratchOffsetAlignment;
    info.maxInstanceCount = acceleration.maxInstanceCount;
    info.timestampValidBits = families.at(queueFamily).queueFamilyProperties.timestampValidBits;
    info.timestampPeriodNs =
        info.timestampValidBits == 0 ? 0.0 : static_cast<double>(properties.limits.timestampPeriod);
    info.maxPushConstantBytes = properties.limits.maxPushConstantsSize;
    info.maxPushDescriptors = chain.Get<VkPhysicalDevicePushDescriptorPropertiesKHR>().maxPushDescriptors;
    info.storageAlignment = properties.limits.minStorageBufferOffsetAlignment;
    info.uniformAlignment = properties.limits.minUniformBufferOffsetAlignment;
    info.maxBufferBytes = chain.Get<VkPhysicalDeviceMaintenance4Properties>().maxBufferSize;
    info.maxStorageBufferBytes = properties.limits.maxStorageBufferRange;
    info.maxUniformBufferBytes = properties.limits.maxUniformBufferRange;
    info.maxTextureExtent = properties.limits.maxImageDimension2D;
    info.maxTextureLayers = properties.limits.maxImageArrayLayers;
    info.subgroupSize = chain.Get<VkPhysicalDeviceSubgroupProperties>().subgroupSize;
    info.optional = optional;
    if (optional.samplerAnisotropy) info.maxAnisotropy = properties.limits.maxSamplerAnisotropy;
    return info;
}

DeviceReport ReportOn(uint32_t index, VkPhysicalDevice device, PFN_vkGetInstanceProcAddr loader,
                      VkInstance instance) {
    const InstanceFunctions vk = LoadInstanceFunctions(loader, instance, false);
    const PropertyChain<VkPhysicalDeviceDriverProperties> chain(vk, device);
    const VkPhysicalDeviceProperties& properties = chain.Core().properties;
    DeviceReport report;
    report.index = index;
    report.name = properties.deviceName;
    report.driver = DriverText(chain.Get<VkPhysicalDeviceDriverProperties>());
    report.type = TypeOf(properties.deviceType);
    report.apiVersion = properties.apiVersion;
    report.refusals = UnmetRequirements(device, loader, instance);
    return report;
}

std::string ResultName(VkResult result) {
    switch (result) {
        case VK_ERROR_OUT_OF_HOST_MEMORY:
            return "VK_ERROR_OUT_OF_HOST_MEMORY";
        case VK_ERROR_OUT_OF_DEVICE_MEMORY:
            return "VK_ERROR_OUT_OF_DEVICE_MEMORY";
        case VK_ERROR_INITIALIZATION_FAILED:
            return "VK_ERROR_INITIALIZATION_FAILED";
        case VK_ERROR_DEVICE_LOST:
            return "VK_ERROR_DEVICE_LOST";
        case VK_ERROR_MEMORY_MAP_FAILED:
            return "VK_ERROR_MEMORY_MAP_FAILED";
        case VK_ERROR_LAYER_NOT_PRESENT:
            return "VK_ERROR_LAYER_NOT_PRESENT";
        case VK_ERROR_EXTENSION_NOT_PRESENT:
            return "VK_ERROR_EXTENSION_NOT_PRESENT";
        case VK_ERROR_FEATURE_NOT_PRESENT:
            return "VK_ERROR_FEATURE_NOT_PRESENT";
        case VK_ERROR_INCOMPATIBLE_DRIVER:
            return "VK_ERROR_INCOMPATIBLE_DRIVER";
        case VK_ERROR_TOO_MANY_OBJECTS:
            return "VK_ERROR_TOO_MANY_OBJECTS";
        case VK_ERROR_FORMAT_NOT_SUPPORTED:
            return "VK_ERROR_FORMAT_NOT_SUPPORTED";
        case VK_ERROR_FRAGMENTED_POOL:
            return "VK_ERROR_FRAGMENTED_POOL";
        case VK_ERROR_OUT_OF_POOL_MEMORY:
            return "VK_ERROR_OUT_OF_POOL_MEMORY";
        case VK_ERROR_FRAGMENTATION:
            return "VK_ERROR_FRAGMENTATION";
        case VK_ERROR_UNKNOWN:
            return "VK_ERROR_UNKNOWN";
        case VK_ERROR_INVALID_OPAQUE_CAPTURE_ADDRESS:
            return "VK_ERROR_INVALID_OPAQUE_CAPTURE_ADDRESS";
        case VK_ERROR_INVALID_SHADER_NV:
            return "VK_ERROR_INVALID_SHADER_NV";
        default:
            return Text("VkResult {}", static_cast<int>(result));
    }
}

}  // namespace raygraph::rhi
