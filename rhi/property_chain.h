// Properties of a physical device, queried in one call. For rhi/ alone. Threads: any.
#pragma once

#include <tuple>

#include "rhi/functions.h"

namespace raygraph::rhi {

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
