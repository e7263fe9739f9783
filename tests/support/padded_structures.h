// A driver whose compaction saves memory: while it exists, the device says that structures take an eighth more
// memory than they do, and builds them in what they take. So lavapipe's, which cannot be made smaller, are
// compacted, too.
#pragma once

#include <map>

#include "rhi/device.h"
#include "rhi/functions.h"

namespace raygraph::testing {

class PaddedStructures {
  public:
    explicit PaddedStructures(rhi::Device& device) : m_vk(const_cast<rhi::DeviceFunctions&>(device.Vk())) {
        system = m_vk;
        m_vk.vkGetAccelerationStructureBuildSizesKHR = GetPaddedSizes;
        m_vk.vkCreateAccelerationStructureKHR = CreateWithoutPadding;
    }
    ~PaddedStructures() { m_vk = system; }
    PaddedStructures(const PaddedStructures&) = delete;
    PaddedStructures& operator=(const PaddedStructures&) = delete;

  private:
    static VKAPI_ATTR void VKAPI_CALL GetPaddedSizes(VkDevice device,
                                                     VkAccelerationStructureBuildTypeKHR type,
                                                     const VkAccelerationStructureBuildGeometryInfoKHR* info,
                                                     const uint32_t* counts,
                                                     VkAccelerationStructureBuildSizesInfoKHR* sizes) {
        system.vkGetAccelerationStructureBuildSizesKHR(device, type, info, counts, sizes);
        const VkDeviceSize taken = sizes->accelerationStructureSize;
        // Odd, as no driver's sizes are.
        sizes->accelerationStructureSize = (taken + taken / 8) | 1u;
        withoutPadding[sizes->accelerationStructureSize] = taken;
    }
    static VKAPI_ATTR VkResult VKAPI_CALL
    CreateWithoutPadding(VkDevice device, const VkAccelerationStructureCreateInfoKHR* create,
                         const VkAllocationCallbacks* allocation, VkAccelerationStructureKHR* structure) {
        VkAccelerationStructureCreateInfoKHR smaller = *create;
        if (const auto padded = withoutPadding.find(create->size); padded != withoutPadding.end())
            smaller.size = padded->second;
        return system.vkCreateAccelerationStructureKHR(device, &smaller, allocation, structure);
    }

    // Vulkan's functions carry no user data.
    static inline rhi::DeviceFunctions system{};
    static inline std::map<VkDeviceSize, VkDeviceSize> withoutPadding;
    rhi::DeviceFunctions& m_vk;
};

}  // namespace raygraph::testing
