// The requirements of Raygraph on a Vulkan device, as data: readable before any device exists, so that a host
// engine can create its own VkDevice from them. Threads: any.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "base/api.h"
#include "rhi/functions.h"
#include "rhi/submission.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

struct ExtensionRequirement {
    const char* name;
    bool isRequired;
    const char* why;
};

struct LimitRequirement {
    const char* name;  // "maxPushDescriptors"
    uint64_t minimum;
    const char* why;
};

struct FeatureRequirement {
    const char* name;  // "accelerationStructure"
    bool isRequired;
    const char* why;
};

struct FormatRequirement {
    const char* name;  // "linear filtering of rgba32f"
    VkFormat format;
    VkFormatFeatureFlags features;  // features with optimal tiling
    const char* why;
};

struct RequirementList {
    uint32_t apiVersion = VK_API_VERSION_1_3;
    std::vector<ExtensionRequirement> extensions;
    std::vector<FeatureRequirement> features;
    std::vector<LimitRequirement> limits;
    std::vector<FormatRequirement> formats;
    VkQueueFlags queueFlags = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT | VK_QUEUE_TRANSFER_BIT;
};

// Returns the list as static data. Thread-safe.
RAYGRAPH_API const RequirementList& Requirements();

// Holds the optional capabilities of a device.
struct OptionalFeatures {
    bool rayQuery = false;
    bool positionFetch = false;
    bool shaderClock = false;
    bool invocationReorder = false;
    bool opacityMicromap = false;
    bool wireframe = false;     // fillModeNonSolid
    bool clipDistance = false;  // shaderClipDistance
    bool multiDrawIndirect = false;
    bool drawIndirectFirstInstance = false;
    bool bufferInt64Atomics = false;    // shaderBufferInt64Atomics
    bool textureCompressionBc = false;  // textureCompressionBC
    bool samplerAnisotropy = false;
    bool pipelineStatistics = false;  // pipelineExecutableInfo
    bool layeredTargets = false;      // shaderOutputLayer
    bool memoryBudget = false;        // VK_EXT_memory_budget, an extension without a feature to enable

    bool operator==(const OptionalFeatures&) const = default;
};

// The chained feature structures that enable the requirements: pass Root() as VkDeviceCreateInfo::pNext.
// Movable, not copyable; Root() stays valid while the object lives.
class RAYGRAPH_API FeatureChain {
  public:
    FeatureChain();
    FeatureChain(FeatureChain&&) noexcept;
    FeatureChain& operator=(FeatureChain&&) noexcept;
    ~FeatureChain();
    // The caller may set more flags in the chained structures before the device is created.
    VkPhysicalDeviceFeatures2* Root();
    const VkPhysicalDeviceFeatures2* Root() const;

  private:
    friend FeatureChain FeaturesFor(VkPhysicalDevice, PFN_vkGetInstanceProcAddr, VkInstance);
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

// --- Queries of a physical device; `loader` is the one by which `instance` was created ---

// Returns the required features and the optional ones that `device` has.
RAYGRAPH_API FeatureChain FeaturesFor(VkPhysicalDevice device, PFN_vkGetInstanceProcAddr loader,
                                      VkInstance instance);
// Returns the names of the required extensions and of the optional ones that `device` has, for
// VkDeviceCreateInfo. The strings live as long as the program.
RAYGRAPH_API std::vector<const char*> ExtensionsFor(VkPhysicalDevice device, PFN_vkGetInstanceProcAddr loader,
                                                    VkInstance instance);
// Returns the first queue family for a queue; nullopt if there is none. The main queue's has all of
// RequirementList::queueFlags, and the work of the others' can run beside graphics.
RAYGRAPH_API std::optional<uint32_t> QueueFamilyFor(VkPhysicalDevice device, PFN_vkGetInstanceProcAddr loader,
                                                    VkInstance instance, QueueKind queue = QueueKind::Main);
// Returns the optional capabilities of `device`, whose extension and feature are both present.
RAYGRAPH_API OptionalFeatures OptionalFeaturesOf(VkPhysicalDevice device, PFN_vkGetInstanceProcAddr loader,
                                                 VkInstance instance);
// Clears capabilities that need a device extension which is not in `enabled`.
RAYGRAPH_API OptionalFeatures Restrict(OptionalFeatures features, std::span<const std::string> enabled);
// Clears capabilities that are not set in `enabled`.
RAYGRAPH_API OptionalFeatures Restrict(OptionalFeatures features, const OptionalFeatures& enabled);
// Returns every reason for which `device` cannot be used, one line each; empty: it can be used.
RAYGRAPH_API std::vector<std::string> UnmetRequirements(VkPhysicalDevice device,
                                                        PFN_vkGetInstanceProcAddr loader,
                                                        VkInstance instance);

// --- Properties of a physical device, queried in one call. For rhi/ alone ---

template <typename Properties>
inline constexpr VkStructureType kTypeOf = VK_STRUCTURE_TYPE_MAX_ENUM;
template <>
inline constexpr VkStructureType kTypeOf<VkPhysicalDeviceDriverProperties> =
    VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES;
template <>
inline constexpr VkStructureType kTypeOf<VkPhysicalDeviceSubgroupProperties> =
    VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES;
template <>
inline constexpr VkStructureType kTypeOf<VkPhysicalDeviceMaintenance4Properties> =
    VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_4_PROPERTIES;
template <>
inline constexpr VkStructureType kTypeOf<VkPhysicalDeviceVulkan12Properties> =
    VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES;
template <>
inline constexpr VkStructureType kTypeOf<VkPhysicalDevicePushDescriptorPropertiesKHR> =
    VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PUSH_DESCRIPTOR_PROPERTIES_KHR;
template <>
inline constexpr VkStructureType kTypeOf<VkPhysicalDeviceAccelerationStructurePropertiesKHR> =
    VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR;
template <>
inline constexpr VkStructureType kTypeOf<VkPhysicalDeviceRayTracingPipelinePropertiesKHR> =
    VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_PROPERTIES_KHR;

// Holds each structure once. The device must have the extensions to which they belong.
template <typename... Properties>
class PropertyChain {
  public:
    PropertyChain(const InstanceFunctions& vk, VkPhysicalDevice device) {
        (Append(std::get<Properties>(m_properties)), ...);
        vk.vkGetPhysicalDeviceProperties2(device, &m_core);
    }
    PropertyChain(const PropertyChain&) = delete;  // its members point at each other
    PropertyChain& operator=(const PropertyChain&) = delete;

    const VkPhysicalDeviceProperties2& Core() const { return m_core; }
    template <typename T>
    const T& Get() const {
        return std::get<T>(m_properties);
    }

  private:
    template <typename T>
    void Append(T& properties) {
        static_assert(kTypeOf<T> != VK_STRUCTURE_TYPE_MAX_ENUM, "kTypeOf lacks this structure");
        properties.sType = kTypeOf<T>;
        properties.pNext = m_core.pNext;
        m_core.pNext = &properties;
    }

    std::tuple<Properties...> m_properties{};
    VkPhysicalDeviceProperties2 m_core{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, nullptr, {}};
};

}  // namespace raygraph::rhi
