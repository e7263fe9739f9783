// What Raygraph needs from a Vulkan device, as data: readable before any device exists, so that a host engine
// can create its own VkDevice from it.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

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

struct RequirementList {
    uint32_t apiVersion = VK_API_VERSION_1_3;
    std::vector<ExtensionRequirement> extensions;
    std::vector<FeatureRequirement> features;
    std::vector<LimitRequirement> limits;
    VkQueueFlags queueFlags = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT | VK_QUEUE_TRANSFER_BIT;
};

// The list as data; static, thread-safe.
const RequirementList& Requirements();

// Optional capabilities, found or not.
struct OptionalFeatures {
    bool rayQuery = false;
    bool positionFetch = false;
    bool shaderClock = false;
    bool invocationReorder = false;
    bool opacityMicromap = false;
};

// The chained feature structures that turn the requirements on: pass Root() as VkDeviceCreateInfo::pNext.
// Movable, not copyable; Root() stays valid while the object lives.
class FeatureChain {
  public:
    FeatureChain();
    FeatureChain(FeatureChain&&) noexcept;
    FeatureChain& operator=(FeatureChain&&) noexcept;
    ~FeatureChain();
    const VkPhysicalDeviceFeatures2* Root() const;

  private:
    friend FeatureChain FeaturesFor(VkPhysicalDevice, PFN_vkGetInstanceProcAddr, VkInstance);
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

// The required features plus the optional ones that `device` has.
FeatureChain FeaturesFor(VkPhysicalDevice device, PFN_vkGetInstanceProcAddr loader, VkInstance instance);
// Names of the required extensions plus the optional ones that `device` has, for VkDeviceCreateInfo.
std::vector<const char*> ExtensionsFor(VkPhysicalDevice device, PFN_vkGetInstanceProcAddr loader,
                                       VkInstance instance);
// Every reason for which `device` cannot be used, one line each; empty: it can.
std::vector<std::string> RefusalsOf(VkPhysicalDevice device, PFN_vkGetInstanceProcAddr loader,
                                    VkInstance instance);

}  // namespace raygraph::rhi
