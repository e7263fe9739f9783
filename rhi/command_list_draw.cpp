// CommandList: drawing.
#include <algorithm>
#include <array>

#include "base/text.h"
#include "rhi/command_list.h"
#include "rhi/device.h"

namespace raygraph::rhi {
namespace {

constexpr uint32_t kMaxColorTargets = 8;

}  // namespace

void CommandList::BeginRendering(Extent2D extent, std::span<const ColorTarget> colors,
                                 const DepthTarget* depth) {
    if (extent.IsEmpty()) throw Error(ErrorKind::Usage, "BeginRendering: the extent is empty");
    if (colors.size() > kMaxColorTargets)
        throw MakeError(ErrorKind::Usage, "BeginRendering: {} color targets, at most {}", colors.size(),
                        kMaxColorTargets);
    std::array<VkRenderingAttachmentInfo, kMaxColorTargets> attachments{};
    for (size_t i = 0; i < colors.size(); ++i) {
        VkRenderingAttachmentInfo& attachment = attachments[i];
        attachment.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO;
        attachment.imageView =
            colors[i].texture->View(Subresource(colors[i].level, colors[i].layer), ImageShape::Plain);
        attachment.imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
        attachment.loadOp = colors[i].clear ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
        attachment.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
        std::copy_n(colors[i].clearValue, 4, attachment.clearValue.color.float32);
    }
    VkRenderingAttachmentInfo depthAttachment{};
    if (depth) {
        depthAttachment.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO;
        depthAttachment.imageView =
            depth->texture->View(Subresource(depth->level, depth->layer), ImageShape::Plain);
        depthAttachment.imageLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        depthAttachment.loadOp = depth->clear ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
        depthAttachment.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
        depthAttachment.clearValue.depthStencil.depth = depth->clearValue;
    }
    const VkRect2D area{{0, 0}, {extent.width, extent.height}};
    VkRenderingInfo info{};
    info.sType = VK_STRUCTURE_TYPE_RENDERING_INFO;
    info.renderArea = area;
    info.layerCount = 1;
    info.colorAttachmentCount = static_cast<uint32_t>(colors.size());
    info.pColorAttachments = attachments.data();
    info.pDepthAttachment = depth ? &depthAttachment : nullptr;
    Vk().vkCmdBeginRendering(m_commands, &info);
    const VkViewport viewport{0.0f, 0.0f, static_cast<float>(extent.width), static_cast<float>(extent.height),
                              0.0f, 1.0f};
    Vk().vkCmdSetViewport(m_commands, 0, 1, &viewport);
    Vk().vkCmdSetScissor(m_commands, 0, 1, &area);
}

void CommandList::EndRendering() {
    Vk().vkCmdEndRendering(m_commands);
}

void CommandList::SetScissor(int32_t x, int32_t y, Extent2D extent) {
    const VkRect2D area{{x, y}, {extent.width, extent.height}};
    Vk().vkCmdSetScissor(m_commands, 0, 1, &area);
}

void CommandList::Draw(uint32_t vertexCount, uint32_t instanceCount, uint32_t firstVertex,
                       uint32_t firstInstance) {
    RequirePipeline("Draw");
    Vk().vkCmdDraw(m_commands, vertexCount, instanceCount, firstVertex, firstInstance);
}

void CommandList::DrawIndexed(const Buffer& indices, uint32_t indexCount, uint32_t instanceCount,
                              uint32_t firstIndex, int32_t vertexOffset, uint32_t firstInstance) {
    RequirePipeline("DrawIndexed");
    Vk().vkCmdBindIndexBuffer(m_commands, indices.Handle(), 0, VK_INDEX_TYPE_UINT32);
    Vk().vkCmdDrawIndexed(m_commands, indexCount, instanceCount, firstIndex, vertexOffset, firstInstance);
}

void CommandList::DrawIndirect(const Buffer& commands, uint32_t firstDraw, uint32_t drawCount) {
    RequirePipeline("DrawIndirect");
    constexpr uint32_t kStride = sizeof(VkDrawIndirectCommand);
    if ((uint64_t{firstDraw} + drawCount) * kStride > commands.Size())
        throw MakeError(ErrorKind::Usage, "DrawIndirect: draws {} to {} of '{}', which holds {}", firstDraw,
                        uint64_t{firstDraw} + drawCount, commands.Desc().name, commands.Size() / kStride);
    if (drawCount == 0) return;
    if (m_device->Info().optional.multiDrawIndirect) {
        Vk().vkCmdDrawIndirect(m_commands, commands.Handle(), uint64_t{firstDraw} * kStride, drawCount,
                               kStride);
        return;
    }
    for (uint32_t draw = firstDraw; draw < firstDraw + drawCount; ++draw)
        Vk().vkCmdDrawIndirect(m_commands, commands.Handle(), uint64_t{draw} * kStride, 1, kStride);
}

}  // namespace raygraph::rhi
