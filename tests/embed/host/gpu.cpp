#include "gpu.h"

#include <cstring>
#include <stdexcept>

#include "rhi/device_requirements.h"

namespace {

void Require(VkResult result, const char* call) {
    if (result != VK_SUCCESS) throw std::runtime_error(std::string("host: ") + call + " failed");
}

}  // namespace

Gpu::Gpu() {
    VkApplicationInfo application{};
    application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    application.apiVersion = raygraph::rhi::Requirements().apiVersion;
    VkInstanceCreateInfo instanceInfo{};
    instanceInfo.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    instanceInfo.pApplicationInfo = &application;
    Require(vkCreateInstance(&instanceInfo, nullptr, &instance), "vkCreateInstance");

    uint32_t count = 0;
    vkEnumeratePhysicalDevices(instance, &count, nullptr);
    std::vector<VkPhysicalDevice> devices(count);
    vkEnumeratePhysicalDevices(instance, &count, devices.data());
    for (const VkPhysicalDevice candidate : devices) {
        if (!raygraph::rhi::RefusalsOf(candidate, vkGetInstanceProcAddr, instance).empty()) continue;
        physicalDevice = candidate;
        break;
    }
    if (!physicalDevice) throw std::runtime_error("host: no device meets Raygraph's requirements");

    queueFamily = raygraph::rhi::QueueFamilyFor(physicalDevice, vkGetInstanceProcAddr, instance).value();
    const auto features = raygraph::rhi::FeaturesFor(physicalDevice, vkGetInstanceProcAddr, instance);
    const auto extensions = raygraph::rhi::ExtensionsFor(physicalDevice, vkGetInstanceProcAddr, instance);
    deviceExtensions.assign(extensions.begin(), extensions.end());
    const float priority = 1.0f;
    VkDeviceQueueCreateInfo queueInfo{};
    queueInfo.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
    queueInfo.queueFamilyIndex = queueFamily;
    queueInfo.queueCount = 1;
    queueInfo.pQueuePriorities = &priority;
    VkDeviceCreateInfo deviceInfo{};
    deviceInfo.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
    deviceInfo.pNext = features.Root();
    deviceInfo.queueCreateInfoCount = 1;
    deviceInfo.pQueueCreateInfos = &queueInfo;
    deviceInfo.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
    deviceInfo.ppEnabledExtensionNames = extensions.data();
    Require(vkCreateDevice(physicalDevice, &deviceInfo, nullptr, &device), "vkCreateDevice");
    vkGetDeviceQueue(device, queueFamily, 0, &queue);
}

Gpu::~Gpu() {
    if (device) {
        vkDeviceWaitIdle(device);
        vkDestroyImage(device, m_picture, nullptr);
        vkFreeMemory(device, m_pictureMemory, nullptr);
        vkDestroyDevice(device, nullptr);
    }
    if (instance) vkDestroyInstance(instance, nullptr);
}

VkDeviceMemory Gpu::Allocate(const VkMemoryRequirements& requirements, VkMemoryPropertyFlags properties) {
    VkPhysicalDeviceMemoryProperties memory{};
    vkGetPhysicalDeviceMemoryProperties(physicalDevice, &memory);
    for (uint32_t type = 0; type < memory.memoryTypeCount; ++type) {
        if ((requirements.memoryTypeBits >> type & 1u) == 0) continue;
        if ((memory.memoryTypes[type].propertyFlags & properties) != properties) continue;
        VkMemoryAllocateInfo info{};
        info.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
        info.allocationSize = requirements.size;
        info.memoryTypeIndex = type;
        VkDeviceMemory result = VK_NULL_HANDLE;
        Require(vkAllocateMemory(device, &info, nullptr, &result), "vkAllocateMemory");
        return result;
    }
    throw std::runtime_error("host: no memory of the kind wanted");
}

VkImage Gpu::MakePicture(uint32_t width, uint32_t height) {
    m_width = width;
    m_height = height;
    VkImageCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = VK_FORMAT_R8G8B8A8_UNORM;
    info.extent = {width, height, 1};
    info.mipLevels = 1;
    info.arrayLayers = 1;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.usage =
        VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_SAMPLED_BIT;
    Require(vkCreateImage(device, &info, nullptr, &m_picture), "vkCreateImage");
    VkMemoryRequirements requirements{};
    vkGetImageMemoryRequirements(device, m_picture, &requirements);
    m_pictureMemory = Allocate(requirements, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    Require(vkBindImageMemory(device, m_picture, m_pictureMemory, 0), "vkBindImageMemory");
    return m_picture;
}

std::vector<std::array<uint8_t, 4>> Gpu::ReadPicture() {
    std::vector<std::array<uint8_t, 4>> texels(size_t{m_width} * m_height);
    VkBufferCreateInfo bufferInfo{};
    bufferInfo.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    bufferInfo.size = texels.size() * sizeof(texels[0]);
    bufferInfo.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    VkBuffer buffer = VK_NULL_HANDLE;
    Require(vkCreateBuffer(device, &bufferInfo, nullptr, &buffer), "vkCreateBuffer");
    VkMemoryRequirements requirements{};
    vkGetBufferMemoryRequirements(device, buffer, &requirements);
    const VkDeviceMemory memory =
        Allocate(requirements, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    Require(vkBindBufferMemory(device, buffer, memory, 0), "vkBindBufferMemory");

    VkCommandPoolCreateInfo poolInfo{};
    poolInfo.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    poolInfo.queueFamilyIndex = queueFamily;
    VkCommandPool pool = VK_NULL_HANDLE;
    Require(vkCreateCommandPool(device, &poolInfo, nullptr, &pool), "vkCreateCommandPool");
    VkCommandBufferAllocateInfo commandsInfo{};
    commandsInfo.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    commandsInfo.commandPool = pool;
    commandsInfo.commandBufferCount = 1;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    Require(vkAllocateCommandBuffers(device, &commandsInfo, &commands), "vkAllocateCommandBuffers");
    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    Require(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageExtent = {m_width, m_height, 1};
    vkCmdCopyImageToBuffer(commands, m_picture, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer, 1, &region);
    Require(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
    VkSubmitInfo submit{};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    Require(vkQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
    Require(vkQueueWaitIdle(queue), "vkQueueWaitIdle");

    void* mapped = nullptr;
    Require(vkMapMemory(device, memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
    std::memcpy(texels.data(), mapped, bufferInfo.size);
    vkDestroyCommandPool(device, pool, nullptr);
    vkDestroyBuffer(device, buffer, nullptr);
    vkFreeMemory(device, memory, nullptr);
    return texels;
}
