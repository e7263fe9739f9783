// Tables of Vulkan functions: InstanceFunctions for calls that need no device, and one DeviceFunctions per
// device, loaded through that device's own vkGetDeviceProcAddr. Members have the Vulkan names, so that a call
// reads `vk.vkCmdDispatch(...)`. To use one more function, add a line to the right list; nothing else
// changes. For rhi/ alone. Threads: any; tables do not change once they are loaded.
#pragma once

#include <memory>

#include "rhi/vulkan.h"

// clang-format off

// Loaded with a null instance.
#define RAYGRAPH_GLOBAL_FUNCTIONS(X)                    \
    X(vkCreateInstance)                                 \
    X(vkEnumerateInstanceExtensionProperties)           \
    X(vkEnumerateInstanceLayerProperties)               \
    X(vkEnumerateInstanceVersion)

#define RAYGRAPH_INSTANCE_FUNCTIONS(X)                  \
    X(vkCreateDevice)                                   \
    X(vkDestroyInstance)                                \
    X(vkEnumerateDeviceExtensionProperties)             \
    X(vkEnumeratePhysicalDevices)                       \
    X(vkGetDeviceProcAddr)                              \
    X(vkGetPhysicalDeviceFeatures2)                     \
    X(vkGetPhysicalDeviceFormatProperties2)             \
    X(vkGetPhysicalDeviceImageFormatProperties2)        \
    X(vkGetPhysicalDeviceMemoryProperties2)             \
    X(vkGetPhysicalDeviceProperties2)                   \
    X(vkGetPhysicalDeviceQueueFamilyProperties2)

// Only with VK_EXT_debug_utils: null without it.
#define RAYGRAPH_DEBUG_INSTANCE_FUNCTIONS(X)            \
    X(vkCreateDebugUtilsMessengerEXT)                   \
    X(vkDestroyDebugUtilsMessengerEXT)

// Only with VK_KHR_surface: null without it.
#define RAYGRAPH_SURFACE_FUNCTIONS(X)                   \
    X(vkDestroySurfaceKHR)                              \
    X(vkGetPhysicalDeviceSurfaceSupportKHR)             \
    X(vkGetPhysicalDeviceSurfaceCapabilitiesKHR)        \
    X(vkGetPhysicalDeviceSurfaceFormatsKHR)             \
    X(vkGetPhysicalDeviceSurfacePresentModesKHR)

#define RAYGRAPH_DEVICE_FUNCTIONS(X)                    \
    /* Device, queue, synchronization */                \
    X(vkDestroyDevice)                                  \
    X(vkGetDeviceQueue)                                 \
    X(vkQueueSubmit2)                                   \
    X(vkQueueWaitIdle)                                  \
    X(vkCreateSemaphore)                                \
    X(vkDestroySemaphore)                               \
    X(vkGetSemaphoreCounterValue)                       \
    X(vkSignalSemaphore)                                \
    X(vkWaitSemaphores)                                 \
    /* Memory, buffers, images, samplers */             \
    X(vkAllocateMemory)                                 \
    X(vkFreeMemory)                                     \
    X(vkCreateBuffer)                                   \
    X(vkDestroyBuffer)                                  \
    X(vkGetBufferDeviceAddress)                         \
    X(vkGetDeviceBufferMemoryRequirements)              \
    X(vkCreateImage)                                    \
    X(vkDestroyImage)                                   \
    X(vkBindBufferMemory2)                              \
    X(vkBindImageMemory2)                               \
    X(vkGetImageMemoryRequirements2)                    \
    X(vkGetDeviceImageMemoryRequirements)               \
    X(vkCreateImageView)                                \
    X(vkDestroyImageView)                               \
    X(vkCreateSampler)                                  \
    X(vkDestroySampler)                                 \
    /* Shaders, pipelines, descriptors */               \
    X(vkCreateShaderModule)                             \
    X(vkDestroyShaderModule)                            \
    X(vkCreatePipelineLayout)                           \
    X(vkDestroyPipelineLayout)                          \
    X(vkCreateComputePipelines)                         \
    X(vkCreateGraphicsPipelines)                        \
    X(vkCreateRayTracingPipelinesKHR)                   \
    X(vkDestroyPipeline)                                \
    X(vkGetRayTracingShaderGroupHandlesKHR)             \
    X(vkCreatePipelineCache)                            \
    X(vkDestroyPipelineCache)                           \
    X(vkGetPipelineCacheData)                           \
    X(vkCreateDescriptorSetLayout)                      \
    X(vkDestroyDescriptorSetLayout)                     \
    X(vkCreateDescriptorPool)                           \
    X(vkDestroyDescriptorPool)                          \
    X(vkAllocateDescriptorSets)                         \
    X(vkUpdateDescriptorSets)                           \
    /* Acceleration structures */                       \
    X(vkCreateAccelerationStructureKHR)                 \
    X(vkDestroyAccelerationStructureKHR)                \
    X(vkGetAccelerationStructureBuildSizesKHR)          \
    X(vkGetAccelerationStructureDeviceAddressKHR)       \
    X(vkCmdBuildAccelerationStructuresKHR)              \
    X(vkCmdCopyAccelerationStructureKHR)                \
    X(vkCmdWriteAccelerationStructuresPropertiesKHR)    \
    /* Query pools */                                   \
    X(vkCreateQueryPool)                                \
    X(vkDestroyQueryPool)                               \
    X(vkGetQueryPoolResults)                            \
    X(vkCmdResetQueryPool)                              \
    X(vkCmdWriteTimestamp2)                             \
    /* Command buffers */                               \
    X(vkCreateCommandPool)                              \
    X(vkDestroyCommandPool)                             \
    X(vkResetCommandPool)                               \
    X(vkAllocateCommandBuffers)                         \
    X(vkBeginCommandBuffer)                             \
    X(vkEndCommandBuffer)                               \
    X(vkCmdPipelineBarrier2)                            \
    X(vkCmdBindPipeline)                                \
    X(vkCmdBindDescriptorSets)                          \
    X(vkCmdPushDescriptorSetKHR)                        \
    X(vkCmdPushConstants)                               \
    X(vkCmdDispatch)                                    \
    X(vkCmdDispatchBase)                                \
    X(vkCmdTraceRaysKHR)                                \
    X(vkCmdBeginRendering)                              \
    X(vkCmdEndRendering)                                \
    X(vkCmdSetViewport)                                 \
    X(vkCmdSetScissor)                                  \
    X(vkCmdBindIndexBuffer)                             \
    X(vkCmdDraw)                                        \
    X(vkCmdDrawIndexed)                                 \
    X(vkCmdDrawIndirect)                                \
    X(vkCmdCopyBuffer2)                                 \
    X(vkCmdCopyImage2)                                  \
    X(vkCmdCopyBufferToImage2)                          \
    X(vkCmdCopyImageToBuffer2)                          \
    X(vkCmdBlitImage2)                                  \
    X(vkCmdFillBuffer)                                  \
    X(vkCmdClearColorImage)

// Only with VK_EXT_debug_utils: null without it.
#define RAYGRAPH_DEBUG_DEVICE_FUNCTIONS(X)              \
    X(vkSetDebugUtilsObjectNameEXT)                     \
    X(vkCmdBeginDebugUtilsLabelEXT)                     \
    X(vkCmdEndDebugUtilsLabelEXT)

// Only with VK_KHR_swapchain: null without it.
#define RAYGRAPH_SWAPCHAIN_FUNCTIONS(X)                 \
    X(vkCreateSwapchainKHR)                             \
    X(vkDestroySwapchainKHR)                            \
    X(vkGetSwapchainImagesKHR)                          \
    X(vkAcquireNextImageKHR)                            \
    X(vkQueuePresentKHR)

// Only with VK_KHR_pipeline_executable_properties: null without it.
#define RAYGRAPH_STATISTICS_FUNCTIONS(X)                \
    X(vkGetPipelineExecutablePropertiesKHR)             \
    X(vkGetPipelineExecutableStatisticsKHR)

// clang-format on

namespace raygraph::rhi {

#define RAYGRAPH_DECLARE_FUNCTION_(name) PFN_##name name = nullptr;

struct GlobalFunctions {
    RAYGRAPH_GLOBAL_FUNCTIONS(RAYGRAPH_DECLARE_FUNCTION_)
};

struct InstanceFunctions {
    RAYGRAPH_INSTANCE_FUNCTIONS(RAYGRAPH_DECLARE_FUNCTION_)
    RAYGRAPH_DEBUG_INSTANCE_FUNCTIONS(RAYGRAPH_DECLARE_FUNCTION_)
    RAYGRAPH_SURFACE_FUNCTIONS(RAYGRAPH_DECLARE_FUNCTION_)
};

struct DeviceFunctions {
    RAYGRAPH_DEVICE_FUNCTIONS(RAYGRAPH_DECLARE_FUNCTION_)
    RAYGRAPH_DEBUG_DEVICE_FUNCTIONS(RAYGRAPH_DECLARE_FUNCTION_)
    RAYGRAPH_SWAPCHAIN_FUNCTIONS(RAYGRAPH_DECLARE_FUNCTION_)
    RAYGRAPH_STATISTICS_FUNCTIONS(RAYGRAPH_DECLARE_FUNCTION_)
};

#undef RAYGRAPH_DECLARE_FUNCTION_

// Each throws Error{NoDevice} naming the first function that the loader or driver lacks.
GlobalFunctions LoadGlobalFunctions(PFN_vkGetInstanceProcAddr loader);
InstanceFunctions LoadInstanceFunctions(PFN_vkGetInstanceProcAddr loader, VkInstance instance,
                                        bool debugUtils);
DeviceFunctions LoadDeviceFunctions(PFN_vkGetDeviceProcAddr loader, VkDevice device, bool debugUtils);

// The system's Vulkan loader (libvulkan.so.1), opened at first use; it stays loaded.
class VulkanLoader {
  public:
    // Throws Error{NoDevice} when there is no loader on this machine.
    static std::shared_ptr<VulkanLoader> Open();
    VulkanLoader(const VulkanLoader&) = delete;
    VulkanLoader& operator=(const VulkanLoader&) = delete;

    PFN_vkGetInstanceProcAddr GetInstanceProcAddr() const { return m_getInstanceProcAddr; }

  private:
    VulkanLoader() = default;
    PFN_vkGetInstanceProcAddr m_getInstanceProcAddr = nullptr;
};

}  // namespace raygraph::rhi
