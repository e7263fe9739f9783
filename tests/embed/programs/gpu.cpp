#include "gpu.h"

#include <cstring>

Gpu::Gpu() {
    VkSemaphoreTypeCreateInfo type{};
    type.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO;
    type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
    VkSemaphoreCreateInfo semaphoreInfo{};
    semaphoreInfo.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO;
    semaphoreInfo.pNext = &type;
    Require(vkCreateSemaphore(device, &semaphoreInfo, nullptr, &timeline), "vkCreateSemaphore");
    VkCommandPoolCreateInfo poolInfo{};
    poolInfo.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    poolInfo.queueFamilyIndex = queueFamily;
    Require(vkCreateCommandPool(device, &poolInfo, nullptr, &m_pool), "vkCreateCommandPool");
    MakeHeap();
}

Gpu::~Gpu() {
    vkDeviceWaitIdle(device);
    for (const Owned& owned : m_owned) {
        vkDestroyImage(device, owned.image, nullptr);
        vkDestroyBuffer(device, owned.buffer, nullptr);
        vkFreeMemory(device, owned.memory, nullptr);
    }
    for (const VkImageView view : m_views) vkDestroyImageView(device, view, nullptr);
    vkDestroyPipelineLayout(device, m_layout, nullptr);
    vkDestroyDescriptorPool(device, m_heapPool, nullptr);
    vkDestroyDescriptorSetLayout(device, m_heapLayout, nullptr);
    vkDestroyCommandPool(device, m_pool, nullptr);
    vkDestroySemaphore(device, timeline, nullptr);
}

void Gpu::MakeHeap() {
    constexpr uint32_t kCount = 1000;
    VkDescriptorSetLayoutBinding textures{};
    textures.descriptorType = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE;
    textures.descriptorCount = kCount;
    textures.stageFlags = VK_SHADER_STAGE_ALL;
    const VkDescriptorBindingFlags flags = VK_DESCRIPTOR_BINDING_PARTIALLY_BOUND_BIT;
    VkDescriptorSetLayoutBindingFlagsCreateInfo flagsInfo{};
    flagsInfo.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_BINDING_FLAGS_CREATE_INFO;
    flagsInfo.bindingCount = 1;
    flagsInfo.pBindingFlags = &flags;
    VkDescriptorSetLayoutCreateInfo setInfo{};
    setInfo.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
    setInfo.pNext = &flagsInfo;
    setInfo.bindingCount = 1;
    setInfo.pBindings = &textures;
    Require(vkCreateDescriptorSetLayout(device, &setInfo, nullptr, &m_heapLayout),
            "vkCreateDescriptorSetLayout");
    const VkDescriptorPoolSize size{textures.descriptorType, kCount};
    VkDescriptorPoolCreateInfo poolInfo{};
    poolInfo.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
    poolInfo.maxSets = 1;
    poolInfo.poolSizeCount = 1;
    poolInfo.pPoolSizes = &size;
    Require(vkCreateDescriptorPool(device, &poolInfo, nullptr, &m_heapPool), "vkCreateDescriptorPool");
    VkDescriptorSetAllocateInfo allocate{};
    allocate.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
    allocate.descriptorPool = m_heapPool;
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &m_heapLayout;
    Require(vkAllocateDescriptorSets(device, &allocate, &m_heap), "vkAllocateDescriptorSets");
    VkPipelineLayoutCreateInfo layoutInfo{};
    layoutInfo.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    layoutInfo.setLayoutCount = 1;
    layoutInfo.pSetLayouts = &m_heapLayout;
    Require(vkCreatePipelineLayout(device, &layoutInfo, nullptr, &m_layout), "vkCreatePipelineLayout");
}

void Gpu::BindHeap(VkCommandBuffer commands) const {
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, m_layout, 0, 1, &m_heap, 0, nullptr);
}

void Gpu::DrawSquare(VkCommandBuffer commands, VkImage picture, uint32_t side, std::array<float, 4> color) {
    VkImageViewCreateInfo viewInfo{};
    viewInfo.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
    viewInfo.image = picture;
    viewInfo.viewType = VK_IMAGE_VIEW_TYPE_2D;
    viewInfo.format = VK_FORMAT_R8G8B8A8_UNORM;
    viewInfo.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    VkImageView& view = m_views.emplace_back();
    Require(vkCreateImageView(device, &viewInfo, nullptr, &view), "vkCreateImageView");
    VkImageMemoryBarrier barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
    barrier.dstAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_COLOR_ATTACHMENT_READ_BIT;
    barrier.oldLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL;
    barrier.newLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = picture;
    barrier.subresourceRange = viewInfo.subresourceRange;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                         VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT, 0, 0, nullptr, 0, nullptr, 1,
                         &barrier);
    VkRenderingAttachmentInfo target{};
    target.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO;
    target.imageView = view;
    target.imageLayout = barrier.newLayout;
    target.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
    target.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    target.clearValue.color = {{color[0], color[1], color[2], color[3]}};
    VkRenderingInfo rendering{};
    rendering.sType = VK_STRUCTURE_TYPE_RENDERING_INFO;
    rendering.renderArea.extent = {side, side};
    rendering.layerCount = 1;
    rendering.colorAttachmentCount = 1;
    rendering.pColorAttachments = &target;
    vkCmdBeginRendering(commands, &rendering);
    vkCmdEndRendering(commands);
    std::swap(barrier.oldLayout, barrier.newLayout);
    barrier.srcAccessMask = barrier.dstAccessMask;
    barrier.dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
                         VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0, nullptr, 0, nullptr, 1, &barrier);
}

VkImage Gpu::MakePicture(VkExtent2D extent) {
    Owned& picture = m_owned.emplace_back();
    picture.image = MakeImage(extent, picture.memory);
    return picture.image;
}

VkBuffer Gpu::MakeVertices(const void* data, size_t bytes) {
    VkBufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = bytes;
    info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                 VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;
    Owned& vertices = m_owned.emplace_back();
    Require(vkCreateBuffer(device, &info, nullptr, &vertices.buffer), "vkCreateBuffer");
    VkMemoryRequirements requirements{};
    vkGetBufferMemoryRequirements(device, vertices.buffer, &requirements);
    vertices.memory =
        Allocate(requirements, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
                 VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT);
    Require(vkBindBufferMemory(device, vertices.buffer, vertices.memory, 0), "vkBindBufferMemory");
    SetVertices(vertices.buffer, data, bytes);
    return vertices.buffer;
}

void Gpu::SetVertices(VkBuffer vertices, const void* data, size_t bytes) {
    for (const Owned& owned : m_owned) {
        if (owned.buffer != vertices) continue;
        void* mapped = nullptr;
        Require(vkMapMemory(device, owned.memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
        std::memcpy(mapped, data, bytes);
        vkUnmapMemory(device, owned.memory);
    }
}

void Gpu::Run(const Record& record) {
    VkCommandBufferAllocateInfo commandsInfo{};
    commandsInfo.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    commandsInfo.commandPool = m_pool;
    commandsInfo.commandBufferCount = 1;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    Require(vkAllocateCommandBuffers(device, &commandsInfo, &commands), "vkAllocateCommandBuffers");
    VkCommandBufferBeginInfo begin{};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    Require(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
    record(commands);
    Require(vkEndCommandBuffer(commands), "vkEndCommandBuffer");

    VkSemaphoreSubmitInfo wait{};
    wait.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO;
    wait.semaphore = timeline;
    wait.value = turn;
    wait.stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    VkSemaphoreSubmitInfo signal = wait;
    signal.value = ++turn;
    VkCommandBufferSubmitInfo commandsSubmit{};
    commandsSubmit.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO;
    commandsSubmit.commandBuffer = commands;
    VkSubmitInfo2 submit{};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2;
    submit.waitSemaphoreInfoCount = 1;
    submit.pWaitSemaphoreInfos = &wait;
    submit.commandBufferInfoCount = 1;
    submit.pCommandBufferInfos = &commandsSubmit;
    submit.signalSemaphoreInfoCount = 1;
    submit.pSignalSemaphoreInfos = &signal;
    {
        const std::lock_guard lock(queueLock);
        Require(vkQueueSubmit2(queue, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit2");
    }
    VkSemaphoreWaitInfo done{};
    done.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO;
    done.semaphoreCount = 1;
    done.pSemaphores = &timeline;
    done.pValues = &turn;
    Require(vkWaitSemaphores(device, &done, UINT64_MAX), "vkWaitSemaphores");
    vkFreeCommandBuffers(device, m_pool, 1, &commands);
}

void Gpu::Clear(VkImage picture, std::array<float, 4> color) {
    Run([&](VkCommandBuffer commands) {
        VkImageMemoryBarrier toWrite{};
        toWrite.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
        toWrite.dstAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
        toWrite.oldLayout = VK_IMAGE_LAYOUT_UNDEFINED;
        toWrite.newLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
        toWrite.srcQueueFamilyIndex = toWrite.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
        toWrite.image = picture;
        toWrite.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 0,
                             nullptr, 0, nullptr, 1, &toWrite);
        const VkClearColorValue value{{color[0], color[1], color[2], color[3]}};
        vkCmdClearColorImage(commands, picture, toWrite.newLayout, &value, 1, &toWrite.subresourceRange);
    });
}

std::vector<Texel> Gpu::Read(VkImage picture, VkExtent2D extent, const Record& before) {
    std::vector<Texel> texels(size_t{extent.width} * extent.height);
    VkBufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = texels.size() * sizeof(Texel);
    info.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    VkBuffer buffer = VK_NULL_HANDLE;
    Require(vkCreateBuffer(device, &info, nullptr, &buffer), "vkCreateBuffer");
    VkMemoryRequirements requirements{};
    vkGetBufferMemoryRequirements(device, buffer, &requirements);
    const VkDeviceMemory memory =
        Allocate(requirements, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT, 0);
    Require(vkBindBufferMemory(device, buffer, memory, 0), "vkBindBufferMemory");
    Run([&](VkCommandBuffer commands) {
        if (before) before(commands);
        VkBufferImageCopy region{};
        region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        region.imageExtent = {extent.width, extent.height, 1};
        vkCmdCopyImageToBuffer(commands, picture, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer, 1, &region);
        VkMemoryBarrier toHost{};
        toHost.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
        toHost.srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT;
        toHost.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
        vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1,
                             &toHost, 0, nullptr, 0, nullptr);
    });
    void* mapped = nullptr;
    Require(vkMapMemory(device, memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
    std::memcpy(texels.data(), mapped, info.size);
    vkDestroyBuffer(device, buffer, nullptr);
    vkFreeMemory(device, memory, nullptr);
    return texels;
}
