#include "rhi/device_requirements.h"

#include "base/text.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "rhi/functions.h"

namespace raygraph::rhi {

// Holds all feature structures that are queried.
struct FeatureStructs {
    VkPhysicalDeviceFeatures2 root{};
    VkPhysicalDeviceVulkan12Features vulkan12{};
    VkPhysicalDeviceVulkan13Features vulkan13{};
    VkPhysicalDeviceAccelerationStructureFeaturesKHR acceleration{};
    VkPhysicalDeviceRayTracingPipelineFeaturesKHR tracing{};
    VkPhysicalDeviceRayQueryFeaturesKHR query{};
    VkPhysicalDeviceShaderClockFeaturesKHR clock{};
    VkPhysicalDeviceRayTracingInvocationReorderFeaturesNV reorder{};
    VkPhysicalDeviceOpacityMicromapFeaturesEXT micromap{};
    VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR executables{};
#ifdef VK_KHR_ray_tracing_position_fetch  // Vulkan headers 1.3.249 or later
    VkPhysicalDeviceRayTracingPositionFetchFeaturesKHR positionFetch{};
#endif
};

namespace {

struct FeatureEntry {
    FeatureRequirement requirement;
    const char* extension;                         // null: part of Vulkan 1.3
    VkBool32& (*flag)(FeatureStructs&);            // returns the field of the feature
    bool OptionalFeatures::*capability = nullptr;  // the capability that an optional feature enables
};

// Describes an optional extension without a feature.
struct ExtensionEntry {
    ExtensionRequirement requirement;
    bool OptionalFeatures::*capability;
};

struct LimitEntry {
    LimitRequirement requirement;
    uint64_t (*value)(const VkPhysicalDeviceProperties2&, const VkPhysicalDeviceVulkan12Properties&,
                      const VkPhysicalDevicePushDescriptorPropertiesKHR&,
                      const VkPhysicalDeviceRayTracingPipelinePropertiesKHR&);
};

#define RAYGRAPH_FLAG_(member) ([](FeatureStructs& f) -> VkBool32& { return f.member; })

constexpr const char* kTracing = VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME;
constexpr const char* kAcceleration = VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME;

const std::array kFeatures{
    FeatureEntry{{"rayTracingPipeline", true, "all passes that trace"},
                 kTracing,
                 RAYGRAPH_FLAG_(tracing.rayTracingPipeline)},
    FeatureEntry{{"accelerationStructure", true, "scenes to trace in"},
                 kAcceleration,
                 RAYGRAPH_FLAG_(acceleration.accelerationStructure)},
    FeatureEntry{{"bufferDeviceAddress", true, "geometry reached by address; acceleration structures"},
                 nullptr,
                 RAYGRAPH_FLAG_(vulkan12.bufferDeviceAddress)},
    FeatureEntry{{"descriptorIndexing", true, "the bindless texture table"},
                 nullptr,
                 RAYGRAPH_FLAG_(vulkan12.descriptorIndexing)},
    FeatureEntry{{"runtimeDescriptorArray", true, "the bindless texture table"},
                 nullptr,
                 RAYGRAPH_FLAG_(vulkan12.runtimeDescriptorArray)},
    FeatureEntry{
        {"shaderSampledImageArrayNonUniformIndexing", true, "neighboring rays see different textures"},
        nullptr,
        RAYGRAPH_FLAG_(vulkan12.shaderSampledImageArrayNonUniformIndexing)},
    FeatureEntry{{"descriptorBindingPartiallyBound", true, "the bindless texture table"},
                 nullptr,
                 RAYGRAPH_FLAG_(vulkan12.descriptorBindingPartiallyBound)},
    FeatureEntry{{"descriptorBindingVariableDescriptorCount", true, "texture tables of different sizes"},
                 nullptr,
                 RAYGRAPH_FLAG_(vulkan12.descriptorBindingVariableDescriptorCount)},
    FeatureEntry{
        {"descriptorBindingSampledImageUpdateAfterBind", true, "textures that arrive while frames run"},
        nullptr,
        RAYGRAPH_FLAG_(vulkan12.descriptorBindingSampledImageUpdateAfterBind)},
    FeatureEntry{{"descriptorBindingUpdateUnusedWhilePending", true, "textures that arrive while frames run"},
                 nullptr,
                 RAYGRAPH_FLAG_(vulkan12.descriptorBindingUpdateUnusedWhilePending)},
    FeatureEntry{{"scalarBlockLayout", true, "structures shared by C++ and shaders"},
                 nullptr,
                 RAYGRAPH_FLAG_(vulkan12.scalarBlockLayout)},
    FeatureEntry{{"timelineSemaphore", true, "frames in flight, deferred destruction"},
                 nullptr,
                 RAYGRAPH_FLAG_(vulkan12.timelineSemaphore)},
    FeatureEntry{{"synchronization2", true, "the barriers of the render graph"},
                 nullptr,
                 RAYGRAPH_FLAG_(vulkan13.synchronization2)},
    FeatureEntry{
        {"dynamicRendering", true, "raster passes"}, nullptr, RAYGRAPH_FLAG_(vulkan13.dynamicRendering)},
    FeatureEntry{{"maintenance4", true, "memory needs of a resource before it exists"},
                 nullptr,
                 RAYGRAPH_FLAG_(vulkan13.maintenance4)},
    FeatureEntry{{"shaderInt64", true, "device addresses in shaders"},
                 nullptr,
                 RAYGRAPH_FLAG_(root.features.shaderInt64)},
    FeatureEntry{{"shaderStorageImageReadWithoutFormat", true, "passes that work on any texel format"},
                 nullptr,
                 RAYGRAPH_FLAG_(root.features.shaderStorageImageReadWithoutFormat)},
    FeatureEntry{{"shaderStorageImageWriteWithoutFormat", true, "passes that work on any texel format"},
                 nullptr,
                 RAYGRAPH_FLAG_(root.features.shaderStorageImageWriteWithoutFormat)},
    FeatureEntry{{"shaderSampledImageArrayDynamicIndexing", false, "indices into arrays of textures"},
                 nullptr,
                 RAYGRAPH_FLAG_(root.features.shaderSampledImageArrayDynamicIndexing)},
    FeatureEntry{{"shaderStorageImageArrayDynamicIndexing", false, "indices into arrays of storage images"},
                 nullptr,
                 RAYGRAPH_FLAG_(root.features.shaderStorageImageArrayDynamicIndexing)},
    FeatureEntry{{"shaderStorageBufferArrayDynamicIndexing", false, "indices into arrays of buffers"},
                 nullptr,
                 RAYGRAPH_FLAG_(root.features.shaderStorageBufferArrayDynamicIndexing)},
    FeatureEntry{{"shaderUniformBufferArrayDynamicIndexing", false, "indices into arrays of uniform blocks"},
                 nullptr,
                 RAYGRAPH_FLAG_(root.features.shaderUniformBufferArrayDynamicIndexing)},
    FeatureEntry{{"shaderClipDistance", false, "shadow maps of all lights in one draw"},
                 nullptr,
                 RAYGRAPH_FLAG_(root.features.shaderClipDistance),
                 &OptionalFeatures::clipDistance},
    FeatureEntry{{"multiDrawIndirect", false, "a scene drawn by one command"},
                 nullptr,
                 RAYGRAPH_FLAG_(root.features.multiDrawIndirect),
                 &OptionalFeatures::multiDrawIndirect},
    FeatureEntry{{"drawIndirectFirstInstance", false, "a scene drawn by one command"},
                 nullptr,
                 RAYGRAPH_FLAG_(root.features.drawIndirectFirstInstance),
                 &OptionalFeatures::drawIndirectFirstInstance},
    FeatureEntry{{"shaderBufferInt64Atomics", false, "drawing by compute shaders"},
                 nullptr,
                 RAYGRAPH_FLAG_(vulkan12.shaderBufferInt64Atomics),
                 &OptionalFeatures::bufferInt64Atomics},
    FeatureEntry{{"samplerAnisotropy", false, "textures of raster views, seen at an angle"},
                 nullptr,
                 RAYGRAPH_FLAG_(root.features.samplerAnisotropy),
                 &OptionalFeatures::samplerAnisotropy},
    FeatureEntry{{"shaderOutputLayer", false, "raster passes that draw to several layers at once"},
                 nullptr,
                 RAYGRAPH_FLAG_(vulkan12.shaderOutputLayer),
                 &OptionalFeatures::layeredTargets},
    FeatureEntry{{"fillModeNonSolid", false, "wireframe views"},
                 nullptr,
                 RAYGRAPH_FLAG_(root.features.fillModeNonSolid),
                 &OptionalFeatures::wireframe},
    FeatureEntry{{"textureCompressionBC", false, "compressed textures as they are in their files"},
                 nullptr,
                 RAYGRAPH_FLAG_(root.features.textureCompressionBC),
                 &OptionalFeatures::textureCompressionBc},
    FeatureEntry{{"rayQuery", false, "rays from other stages than ray tracing"},
                 VK_KHR_RAY_QUERY_EXTENSION_NAME,
                 RAYGRAPH_FLAG_(query.rayQuery),
                 &OptionalFeatures::rayQuery},
    FeatureEntry{{"shaderDeviceClock", false, "cost views"},
                 VK_KHR_SHADER_CLOCK_EXTENSION_NAME,
                 RAYGRAPH_FLAG_(clock.shaderDeviceClock),
                 &OptionalFeatures::shaderClock},
    FeatureEntry{{"rayTracingInvocationReorder", false, "coherent shading"},
                 VK_NV_RAY_TRACING_INVOCATION_REORDER_EXTENSION_NAME,
                 RAYGRAPH_FLAG_(reorder.rayTracingInvocationReorder),
                 &OptionalFeatures::invocationReorder},
    FeatureEntry{{"micromap", false, "alpha-tested geometry without any-hit shaders"},
                 VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME,
                 RAYGRAPH_FLAG_(micromap.micromap),
                 &OptionalFeatures::opacityMicromap},
    FeatureEntry{{"pipelineExecutableInfo", false, "registers and memory that programs take"},
                 VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME,
                 RAYGRAPH_FLAG_(executables.pipelineExecutableInfo),
                 &OptionalFeatures::pipelineStatistics},
#ifdef VK_KHR_ray_tracing_position_fetch
    FeatureEntry{{"rayTracingPositionFetch", false, "vertex positions out of the acceleration structure"},
                 VK_KHR_RAY_TRACING_POSITION_FETCH_EXTENSION_NAME,
                 RAYGRAPH_FLAG_(positionFetch.rayTracingPositionFetch),
                 &OptionalFeatures::positionFetch},
#endif
};

#undef RAYGRAPH_FLAG_

const std::array kExtensions{
    ExtensionEntry{{VK_EXT_MEMORY_BUDGET_EXTENSION_NAME, false,
                    "how much memory the device has left, as its driver says"},
                   &OptionalFeatures::memoryBudget},
};

const std::array kLimits{
    LimitEntry{{"maxPushDescriptors", 32, "the bindings of a pass"},
               [](auto&, auto&, auto& push, auto&) { return uint64_t{push.maxPushDescriptors}; }},
    LimitEntry{{"maxPushConstantsSize", 128, "the constants of a pass, in bytes"},
               [](auto& core, auto&, auto&, auto&) {
                   return uint64_t{core.properties.limits.maxPushConstantsSize};
               }},
    LimitEntry{{"maxDescriptorSetUpdateAfterBindSampledImages", 65536, "the bindless texture table"},
               [](auto&, auto& v12, auto&, auto&) {
                   return uint64_t{v12.maxDescriptorSetUpdateAfterBindSampledImages};
               }},
    LimitEntry{{"maxPerStageDescriptorUpdateAfterBindSampledImages", 65536, "the bindless texture table"},
               [](auto&, auto& v12, auto&, auto&) {
                   return uint64_t{v12.maxPerStageDescriptorUpdateAfterBindSampledImages};
               }},
    LimitEntry{
        {"maxDescriptorSetUpdateAfterBindSamplers", 65536, "the bindless texture table"},
        [](auto&, auto& v12, auto&, auto&) { return uint64_t{v12.maxDescriptorSetUpdateAfterBindSamplers}; }},
    LimitEntry{{"maxPerStageDescriptorUpdateAfterBindSamplers", 65536, "the bindless texture table"},
               [](auto&, auto& v12, auto&, auto&) {
                   return uint64_t{v12.maxPerStageDescriptorUpdateAfterBindSamplers};
               }},
    LimitEntry{{"maxRayRecursionDepth", 1, "tracing from ray generation"},
               [](auto&, auto&, auto&, auto& tracing) { return uint64_t{tracing.maxRayRecursionDepth}; }},
};

constexpr std::array kFormatRequirements{
    FormatRequirement{"linear filtering of rgba32f", VK_FORMAT_R32G32B32A32_SFLOAT,
                      VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT | VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT,
                      "environment maps, whose radiance exceeds what 16 bits hold"},
    FormatRequirement{"storage images of rgba32f", VK_FORMAT_R32G32B32A32_SFLOAT,
                      VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT, "radiance and its mean"},
};

// The queries to one physical device.
class Probe {
  public:
    Probe(VkPhysicalDevice device, PFN_vkGetInstanceProcAddr loader, VkInstance instance)
        : m_device(device), m_vk(LoadInstanceFunctions(loader, instance, false)) {
        uint32_t count = 0;
        m_vk.vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr);
        m_extensions.resize(count);
        m_vk.vkEnumerateDeviceExtensionProperties(device, nullptr, &count, m_extensions.data());
        m_extensions.resize(count);
    }

    bool Has(std::string_view extension) const {
        return std::any_of(m_extensions.begin(), m_extensions.end(),
                           [&](const VkExtensionProperties& e) { return extension == e.extensionName; });
    }
    bool HasExtensionOf(const FeatureEntry& entry) const { return !entry.extension || Has(entry.extension); }

    // Clears `structs` and chains those whose extension the device has.
    void Chain(FeatureStructs& structs) const {
        structs = {};
        structs.root.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
        void** tail = &structs.root.pNext;
        const auto add = [&](auto& structure, VkStructureType type) {
            structure.sType = type;
            *tail = &structure;
            tail = &structure.pNext;
        };
        add(structs.vulkan12, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES);
        add(structs.vulkan13, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES);
        const auto addIf = [&](const char* extension, auto& structure, VkStructureType type) {
            if (Has(extension)) add(structure, type);
        };
        addIf(kAcceleration, structs.acceleration,
              VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR);
        addIf(kTracing, structs.tracing, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_FEATURES_KHR);
        addIf(VK_KHR_RAY_QUERY_EXTENSION_NAME, structs.query,
              VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR);
        addIf(VK_KHR_SHADER_CLOCK_EXTENSION_NAME, structs.clock,
              VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_CLOCK_FEATURES_KHR);
        addIf(VK_NV_RAY_TRACING_INVOCATION_REORDER_EXTENSION_NAME, structs.reorder,
              VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_INVOCATION_REORDER_FEATURES_NV);
        addIf(VK_EXT_OPACITY_MICROMAP_EXTENSION_NAME, structs.micromap,
              VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_OPACITY_MICROMAP_FEATURES_EXT);
        addIf(VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME, structs.executables,
              VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR);
#ifdef VK_KHR_ray_tracing_position_fetch
        addIf(VK_KHR_RAY_TRACING_POSITION_FETCH_EXTENSION_NAME, structs.positionFetch,
              VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_POSITION_FETCH_FEATURES_KHR);
#endif
    }

    // Chains `structs` and queries all features of the device.
    void Query(FeatureStructs& structs) const {
        Chain(structs);
        m_vk.vkGetPhysicalDeviceFeatures2(m_device, &structs.root);
    }

    uint32_t ApiVersion() const {
        return PropertyChain<>(m_vk, m_device).Core().properties.apiVersion;
    }

    std::vector<std::string> LimitRefusals() const {
        const PropertyChain<VkPhysicalDeviceRayTracingPipelinePropertiesKHR,
                            VkPhysicalDevicePushDescriptorPropertiesKHR, VkPhysicalDeviceVulkan12Properties>
            chain(m_vk, m_device);
        std::vector<std::string> refusals;
        for (const LimitEntry& entry : kLimits) {
            const uint64_t value = entry.value(chain.Core(), chain.Get<VkPhysicalDeviceVulkan12Properties>(),
                                               chain.Get<VkPhysicalDevicePushDescriptorPropertiesKHR>(),
                                               chain.Get<VkPhysicalDeviceRayTracingPipelinePropertiesKHR>());
            if (value < entry.requirement.minimum)
                refusals.push_back(
                    Text("{} is {}, needs {}", entry.requirement.name, value, entry.requirement.minimum));
        }
        return refusals;
    }

    std::vector<std::string> FormatRefusals() const {
        std::vector<std::string> refusals;
        for (const FormatRequirement& requirement : kFormatRequirements) {
            VkFormatProperties2 properties{VK_STRUCTURE_TYPE_FORMAT_PROPERTIES_2, nullptr, {}};
            m_vk.vkGetPhysicalDeviceFormatProperties2(m_device, requirement.format, &properties);
            const VkFormatFeatureFlags has = properties.formatProperties.optimalTilingFeatures;
            if ((has & requirement.features) != requirement.features)
                refusals.push_back(std::string("lacks ") + requirement.name);
        }
        return refusals;
    }

    std::optional<uint32_t> QueueFamily(QueueKind queue) const {
        uint32_t count = 0;
        m_vk.vkGetPhysicalDeviceQueueFamilyProperties2(m_device, &count, nullptr);
        std::vector<VkQueueFamilyProperties2> families(
            count, {VK_STRUCTURE_TYPE_QUEUE_FAMILY_PROPERTIES_2, nullptr, {}});
        m_vk.vkGetPhysicalDeviceQueueFamilyProperties2(m_device, &count, families.data());
        const auto find = [&](auto&& suits) -> std::optional<uint32_t> {
            for (uint32_t i = 0; i < count; ++i)
                if (suits(families[i].queueFamilyProperties)) return i;
            return std::nullopt;
        };
        const auto main = find([](const auto& family) { return Suits(family, QueueKind::Main); });
        if (!main || queue == QueueKind::Main) return main;
        // The timestamps of a frame are read alike on both.
        const uint32_t timestampBits = families[*main].queueFamilyProperties.timestampValidBits;
        return find([&](const auto& family) {
            return Suits(family, queue) &&
                   (queue != QueueKind::Compute || family.timestampValidBits == timestampBits);
        });
    }

  private:
    static bool Suits(const VkQueueFamilyProperties& family, QueueKind queue) {
        const auto has = [&](VkQueueFlags flags) { return (family.queueFlags & flags) == flags; };
        const VkExtent3D granularity = family.minImageTransferGranularity;
        switch (queue) {
            case QueueKind::Main:
                return has(Requirements().queueFlags);
            case QueueKind::Compute:
                return has(VK_QUEUE_COMPUTE_BIT) && !has(VK_QUEUE_GRAPHICS_BIT);
            case QueueKind::Transfer:
                break;
        }
        // Families for video are for transfers, too. Uploads copy any number of rows.
        const VkQueueFlags others = ~(VK_QUEUE_TRANSFER_BIT | VK_QUEUE_SPARSE_BINDING_BIT);
        return has(VK_QUEUE_TRANSFER_BIT) && (family.queueFlags & others) == 0 && granularity.width == 1 &&
               granularity.height == 1;
    }

    VkPhysicalDevice m_device;
    InstanceFunctions m_vk;
    std::vector<VkExtensionProperties> m_extensions;
};

}  // namespace

const RequirementList& Requirements() {
    static const RequirementList kList = [] {
        RequirementList list;
        list.extensions = {
            {kTracing, true, "all passes that trace"},
            {kAcceleration, true, "scenes to trace in"},
            {VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME, true, "needed by VK_KHR_acceleration_structure"},
            {VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME, true, "the bindings of a pass"},
        };
        for (const FeatureEntry& entry : kFeatures) {
            list.features.push_back(entry.requirement);
            if (!entry.requirement.isRequired && entry.extension)
                list.extensions.push_back({entry.extension, false, entry.requirement.why});
        }
        for (const ExtensionEntry& entry : kExtensions) list.extensions.push_back(entry.requirement);
        for (const LimitEntry& entry : kLimits) list.limits.push_back(entry.requirement);
        list.formats.assign(kFormatRequirements.begin(), kFormatRequirements.end());
        return list;
    }();
    return kList;
}

struct FeatureChain::Impl {
    FeatureStructs structs;
};

FeatureChain::FeatureChain() : m_impl(std::make_unique<Impl>()) {
    m_impl->structs.root.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
}
FeatureChain::FeatureChain(FeatureChain&&) noexcept = default;
FeatureChain& FeatureChain::operator=(FeatureChain&&) noexcept = default;
FeatureChain::~FeatureChain() = default;
VkPhysicalDeviceFeatures2* FeatureChain::Root() {
    return &m_impl->structs.root;
}
const VkPhysicalDeviceFeatures2* FeatureChain::Root() const {
    return &m_impl->structs.root;
}

FeatureChain FeaturesFor(VkPhysicalDevice device, PFN_vkGetInstanceProcAddr loader, VkInstance instance) {
    const Probe probe(device, loader, instance);
    FeatureStructs available;
    probe.Query(available);
    FeatureChain chain;
    FeatureStructs& enabled = chain.m_impl->structs;
    probe.Chain(enabled);
    for (const FeatureEntry& entry : kFeatures)
        if (probe.HasExtensionOf(entry)) entry.flag(enabled) = entry.flag(available);
    return chain;
}

std::vector<const char*> ExtensionsFor(VkPhysicalDevice device, PFN_vkGetInstanceProcAddr loader,
                                       VkInstance instance) {
    const Probe probe(device, loader, instance);
    std::vector<const char*> names;
    for (const ExtensionRequirement& extension : Requirements().extensions)
        if (extension.isRequired || probe.Has(extension.name)) names.push_back(extension.name);
    return names;
}

std::optional<uint32_t> QueueFamilyFor(VkPhysicalDevice device, PFN_vkGetInstanceProcAddr loader,
                                       VkInstance instance, QueueKind queue) {
    return Probe(device, loader, instance).QueueFamily(queue);
}

OptionalFeatures OptionalFeaturesOf(VkPhysicalDevice device, PFN_vkGetInstanceProcAddr loader,
                                    VkInstance instance) {
    const Probe probe(device, loader, instance);
    FeatureStructs available;
    probe.Query(available);
    OptionalFeatures features;
    for (const FeatureEntry& entry : kFeatures)
        if (entry.capability)
            features.*entry.capability = probe.HasExtensionOf(entry) && entry.flag(available);
    for (const ExtensionEntry& entry : kExtensions)
        features.*entry.capability = probe.Has(entry.requirement.name);
    return features;
}

OptionalFeatures Restrict(OptionalFeatures features, std::span<const std::string> enabled) {
    const auto isEnabled = [&](const char* extension) {
        return std::find(enabled.begin(), enabled.end(), extension) != enabled.end();
    };
    for (const FeatureEntry& entry : kFeatures)
        if (entry.capability && entry.extension && !isEnabled(entry.extension))
            features.*entry.capability = false;
    for (const ExtensionEntry& entry : kExtensions)
        if (!isEnabled(entry.requirement.name)) features.*entry.capability = false;
    return features;
}

OptionalFeatures Restrict(OptionalFeatures features, const OptionalFeatures& enabled) {
    for (const FeatureEntry& entry : kFeatures)
        if (entry.capability && !(enabled.*entry.capability)) features.*entry.capability = false;
    return features;
}

std::vector<std::string> UnmetRequirements(VkPhysicalDevice device, PFN_vkGetInstanceProcAddr loader,
                                           VkInstance instance) {
    const Probe probe(device, loader, instance);
    const uint32_t version = probe.ApiVersion();
    const auto text = [](uint32_t v) {
        return Text("{}.{}", VK_API_VERSION_MAJOR(v), VK_API_VERSION_MINOR(v));
    };
    // Without Vulkan 1.3 the following structures cannot even be queried.
    if (version < Requirements().apiVersion)
        return {"has Vulkan " + text(version) + ", needs " + text(Requirements().apiVersion)};

    std::vector<std::string> refusals;
    for (const ExtensionRequirement& extension : Requirements().extensions)
        if (extension.isRequired && !probe.Has(extension.name))
            refusals.push_back(std::string("lacks ") + extension.name);
    FeatureStructs available;
    probe.Query(available);
    for (const FeatureEntry& entry : kFeatures)
        if (entry.requirement.isRequired && probe.HasExtensionOf(entry) && !entry.flag(available))
            refusals.push_back(std::string("lacks the feature ") + entry.requirement.name);
    // A limit of a missing extension would read as 0, so that only the missing extension is reported.
    if (refusals.empty()) refusals = probe.LimitRefusals();
    for (std::string& refusal : probe.FormatRefusals()) refusals.push_back(std::move(refusal));
    if (!probe.QueueFamily(QueueKind::Main))
        refusals.emplace_back("has no queue family for graphics, compute and transfer");
    return refusals;
}

}  // namespace raygraph::rhi
