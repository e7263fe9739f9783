// An engine in C has this before it embeds anything: a Vulkan device, an image in its memory, and a command
// buffer a frame.
#ifndef HOST_H
#define HOST_H

#include <raygraph.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vulkan/vulkan.h>

// Ends the program with a line if a call of Vulkan or Raygraph has failed.
#define VULKAN(call)   Require((call) == VK_SUCCESS, #call)
#define RAYGRAPH(call) Require((call) == RG_OK, rg_last_error())
static void Require(bool holds, const char* line) {
    if (holds) return;
    fprintf(stderr, "%s\n", line);
    exit(1);
}

typedef struct Host {
    VkInstance instance;
    VkPhysicalDevice gpu;
    VkDevice device;
    VkQueue queue;
    VkCommandPool pool;
    VkCommandBuffer commands;
    VkFence fence;
    VkImage image;  // rgba8
    VkImageView view;
    VkDeviceMemory image_memory;
    VkBuffer buffer;  // of the texels of the image, for reading them
    VkDeviceMemory buffer_memory;
    uint32_t side;  // of the image, in pixels
    RgDevice* raygraph;
} Host;

static VkDeviceMemory Allocate(const Host* host, VkMemoryRequirements needed, VkMemoryPropertyFlags wanted) {
    VkPhysicalDeviceMemoryProperties heaps;
    vkGetPhysicalDeviceMemoryProperties(host->gpu, &heaps);
    VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                 .allocationSize = needed.size};
    while (!(needed.memoryTypeBits >> info.memoryTypeIndex & 1u) ||
           (heaps.memoryTypes[info.memoryTypeIndex].propertyFlags & wanted) != wanted)
        ++info.memoryTypeIndex;
    VkDeviceMemory memory;
    VULKAN(vkAllocateMemory(host->device, &info, NULL, &memory));
    return memory;
}

// Makes the device with what Raygraph needs, and lets Raygraph adopt it.
static void MakeDevice(Host* host) {
    const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                           .apiVersion = VK_API_VERSION_1_3};
    const VkInstanceCreateInfo instance = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                           .pApplicationInfo = &application};
    VULKAN(vkCreateInstance(&instance, NULL, &host->instance));
    VkPhysicalDevice gpus[16];
    uint32_t count = 16;
    vkEnumeratePhysicalDevices(host->instance, &count, gpus);
    RgRequirements* requirements = NULL;
    for (uint32_t i = 0; i < count && requirements == NULL; ++i)
        if (rg_requirements_create(vkGetInstanceProcAddr, host->instance, gpus[i], &requirements) == RG_OK)
            host->gpu = gpus[i];
    Require(requirements != NULL, "host: no device traces rays");

    RgDeviceSetup setup = {.struct_size = sizeof setup};
    RAYGRAPH(rg_requirements_get(requirements, &setup));
    const float priority = 1.0f;
    const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                           .queueFamilyIndex = setup.queue_family,
                                           .queueCount = 1,
                                           .pQueuePriorities = &priority};
    const VkDeviceCreateInfo device = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                       .pNext = setup.features,  // an engine adds its own
                                       .queueCreateInfoCount = 1,
                                       .pQueueCreateInfos = &queue,
                                       .enabledExtensionCount = setup.extension_count,
                                       .ppEnabledExtensionNames = setup.extensions};
    VULKAN(vkCreateDevice(host->gpu, &device, NULL, &host->device));
    vkGetDeviceQueue(host->device, setup.queue_family, 0, &host->queue);
    const RgAdoptDesc adopt = {.struct_size = sizeof adopt,
                               .queue_family = setup.queue_family,
                               .loader = vkGetInstanceProcAddr,
                               .instance = host->instance,
                               .physical_device = host->gpu,
                               .device = host->device,
                               .queue = host->queue,
                               .extensions = setup.extensions,
                               .extension_count = setup.extension_count,
                               .optional_features = setup.optional_features};
    RAYGRAPH(rg_device_adopt(&adopt, &host->raygraph));
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                          .queueFamilyIndex = setup.queue_family};
    VULKAN(vkCreateCommandPool(host->device, &pool, NULL, &host->pool));
    rg_requirements_destroy(requirements);
}

static void MakeImage(Host* host) {
    const VkImageCreateInfo image = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                     .imageType = VK_IMAGE_TYPE_2D,
                                     .format = VK_FORMAT_R8G8B8A8_UNORM,
                                     .extent = {host->side, host->side, 1},
                                     .mipLevels = 1,
                                     .arrayLayers = 1,
                                     .samples = VK_SAMPLE_COUNT_1_BIT,
                                     .usage = VK_IMAGE_USAGE_TRANSFER_DST_BIT |
                                              VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                                              VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT};
    VULKAN(vkCreateImage(host->device, &image, NULL, &host->image));
    VkMemoryRequirements needed;
    vkGetImageMemoryRequirements(host->device, host->image, &needed);
    host->image_memory = Allocate(host, needed, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    VULKAN(vkBindImageMemory(host->device, host->image, host->image_memory, 0));
    const VkImageViewCreateInfo view = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                        .image = host->image,
                                        .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                        .format = image.format,
                                        .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
    VULKAN(vkCreateImageView(host->device, &view, NULL, &host->view));
    const VkBufferCreateInfo buffer = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                       .size = (VkDeviceSize)4 * host->side * host->side,
                                       .usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    VULKAN(vkCreateBuffer(host->device, &buffer, NULL, &host->buffer));
    vkGetBufferMemoryRequirements(host->device, host->buffer, &needed);
    host->buffer_memory =
        Allocate(host, needed, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    VULKAN(vkBindBufferMemory(host->device, host->buffer, host->buffer_memory, 0));
    const VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    VULKAN(vkCreateFence(host->device, &fence, NULL, &host->fence));
    const VkCommandBufferAllocateInfo commands = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                  .commandPool = host->pool,
                                                  .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                  .commandBufferCount = 1};
    VULKAN(vkAllocateCommandBuffers(host->device, &commands, &host->commands));
}

static Host MakeHost(uint32_t side) {
    Host host = {.side = side};
    MakeDevice(&host);
    MakeImage(&host);
    return host;
}

// All handles that were made with the device have been destroyed before.
static void DestroyHost(Host* host) {
    rg_device_destroy(host->raygraph);
    vkDestroyFence(host->device, host->fence, NULL);
    vkDestroyBuffer(host->device, host->buffer, NULL);
    vkFreeMemory(host->device, host->buffer_memory, NULL);
    vkDestroyImageView(host->device, host->view, NULL);
    vkDestroyImage(host->device, host->image, NULL);
    vkFreeMemory(host->device, host->image_memory, NULL);
    vkDestroyCommandPool(host->device, host->pool, NULL);
    vkDestroyDevice(host->device, NULL);
    vkDestroyInstance(host->instance, NULL);
}

static void BeginCommands(Host* host) {
    const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                            .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    VULKAN(vkBeginCommandBuffer(host->commands, &begin));
}

// Submits the frame, and waits for it.
static void Submit(Host* host) {
    VULKAN(vkEndCommandBuffer(host->commands));
    const VkSubmitInfo submit = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &host->commands};
    VULKAN(vkQueueSubmit(host->queue, 1, &submit, host->fence));
    VULKAN(vkWaitForFences(host->device, 1, &host->fence, VK_TRUE, UINT64_MAX));
    VULKAN(vkResetFences(host->device, 1, &host->fence));
}

static inline void ChangeLayout(Host* host, VkImageLayout from, VkImageLayout to) {
    const VkImageMemoryBarrier barrier = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
        .srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT,
        .dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT,
        .oldLayout = from,
        .newLayout = to,
        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
        .image = host->image,
        .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
    vkCmdPipelineBarrier(host->commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                         VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, NULL, 0, NULL, 1, &barrier);
}

// Draws a blue square into the upper left corner of the image, which is in COLOR_ATTACHMENT_OPTIMAL.
static inline void DrawSquare(Host* host, uint32_t side) {
    const VkRenderingAttachmentInfo target = {.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                              .imageView = host->view,
                                              .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                              .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                              .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                              .clearValue.color.float32 = {0.0f, 0.0f, 1.0f, 1.0f}};
    const VkRenderingInfo rendering = {.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                       .renderArea.extent = {side, side},
                                       .layerCount = 1,
                                       .colorAttachmentCount = 1,
                                       .pColorAttachments = &target};
    vkCmdBeginRendering(host->commands, &rendering);
    vkCmdEndRendering(host->commands);
}

// Records a copy of the image, which is in TRANSFER_SRC_OPTIMAL. Once it is done, CopyTexels has the texels.
static void ReadImage(Host* host) {
    const VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                      .imageExtent = {host->side, host->side, 1}};
    vkCmdCopyImageToBuffer(host->commands, host->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, host->buffer, 1,
                           &region);
    const VkMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                     .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                     .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
    vkCmdPipelineBarrier(host->commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1,
                         &barrier, 0, NULL, 0, NULL);
}

static void CopyTexels(const Host* host, uint8_t* rgba) {
    void* texels;
    VULKAN(vkMapMemory(host->device, host->buffer_memory, 0, VK_WHOLE_SIZE, 0, &texels));
    memcpy(rgba, texels, (size_t)4 * host->side * host->side);
    vkUnmapMemory(host->device, host->buffer_memory);
}

#endif
