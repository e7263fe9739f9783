// Host is what an engine has before it embeds anything: a Vulkan device and images in its memory.
#pragma once

#include <vulkan/vulkan.h>

#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include "rhi/device_requirements.h"

inline void Require(VkResult result, const char* call) {
    if (result != VK_SUCCESS) throw std::runtime_error(std::string("host: ") + call + " failed");
}

struct Host {
    Host() {
        VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
        application.apiVersion = raygraph::rhi::Requirements().apiVersion;  // Vulkan 1.3
        VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
        info.pApplicationInfo = &application;
        Require(vkCreateInstance(&info, nullptr, &instance), "vkCreateInstance");
        uint32_t count = 0;
        vkEnumeratePhysicalDevices(instance, &count, nullptr);
        std::vector<VkPhysicalDevice> candidates(count);
        vkEnumeratePhysicalDevices(instance, &count, candidates.data());
        MakeDevice(candidates);
    }
    ~Host() {
        if (device) vkDestroyImage(device, image, nullptr);
        if (device) vkFreeMemory(device, imageMemory, nullptr);
        if (device) vkDestroyDevice(device, nullptr);
        if (instance) vkDestroyInstance(instance, nullptr);
    }
    Host(const Host&) = delete;
    Host& operator=(const Host&) = delete;

    void MakeDevice(const std::vector<VkPhysicalDevice>& candidates) {
        namespace rhi = raygraph::rhi;
        for (VkPhysicalDevice candidate : candidates)  // UnmetRequirements says why not, a line each
            if (!physicalDevice && rhi::UnmetRequirements(candidate, vkGetInstanceProcAddr, instance).empty())
                physicalDevice = candidate;
        if (!physicalDevice) throw std::runtime_error("host: no device traces rays");

        queueFamily = *rhi::QueueFamilyFor(physicalDevice, vkGetInstanceProcAddr, instance);
        rhi::FeatureChain features = rhi::FeaturesFor(physicalDevice, vkGetInstanceProcAddr, instance);
        const auto names = rhi::ExtensionsFor(physicalDevice, vkGetInstanceProcAddr, instance);
        extensions.assign(names.begin(), names.end());
        const float priority = 1.0f;
        VkDeviceQueueCreateInfo queueInfo{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
        queueInfo.queueFamilyIndex = queueFamily;
        queueInfo.queueCount = 1;
        queueInfo.pQueuePriorities = &priority;
        VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
        info.pNext = features.Root();  // to which an engine adds its own features
        info.queueCreateInfoCount = 1;
        info.pQueueCreateInfos = &queueInfo;
        info.enabledExtensionCount = static_cast<uint32_t>(names.size());
        info.ppEnabledExtensionNames = names.data();
        Require(vkCreateDevice(physicalDevice, &info, nullptr, &device), "vkCreateDevice");
        vkGetDeviceQueue(device, queueFamily, 0, &queue);
    }

    // Makes an rgba8 image that can be copied, drawn into and read by shaders, and its memory.
    VkImage MakeImage(VkExtent2D extent, VkDeviceMemory& memory) const {
        VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
        info.imageType = VK_IMAGE_TYPE_2D;
        info.format = VK_FORMAT_R8G8B8A8_UNORM;
        info.extent = {extent.width, extent.height, 1};
        info.mipLevels = info.arrayLayers = 1;
        info.samples = VK_SAMPLE_COUNT_1_BIT;
        info.usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                     VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT |
                     VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
        VkImage made = VK_NULL_HANDLE;
        Require(vkCreateImage(device, &info, nullptr, &made), "vkCreateImage");
        VkMemoryRequirements requirements{};
        vkGetImageMemoryRequirements(device, made, &requirements);
        memory = Allocate(requirements, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, 0);
        Require(vkBindImageMemory(device, made, memory, 0), "vkBindImageMemory");
        return made;
    }
    VkDeviceMemory Allocate(const VkMemoryRequirements& requirements, VkMemoryPropertyFlags properties,
                            VkMemoryAllocateFlags flags) const {
        VkPhysicalDeviceMemoryProperties heaps{};
        vkGetPhysicalDeviceMemoryProperties(physicalDevice, &heaps);
        uint32_t type = 0;
        while (type < heaps.memoryTypeCount &&
               ((requirements.memoryTypeBits >> type & 1u) == 0 ||
                (heaps.memoryTypes[type].propertyFlags & properties) != properties))
            ++type;
        VkMemoryAllocateFlagsInfo flagsInfo{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
        flagsInfo.flags = flags;
        VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
        info.pNext = &flagsInfo;
        info.allocationSize = requirements.size;
        info.memoryTypeIndex = type;
        VkDeviceMemory memory = VK_NULL_HANDLE;
        Require(vkAllocateMemory(device, &info, nullptr, &memory), "vkAllocateMemory");
        return memory;
    }

    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physicalDevice = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;
    uint32_t queueFamily = 0;
    std::vector<std::string> extensions;
    VkImage image = VK_NULL_HANDLE;
    VkDeviceMemory imageMemory = VK_NULL_HANDLE;
};
