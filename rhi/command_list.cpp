#include "rhi/command_list.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "base/check.h"
#include "base/text.h"
#include "rhi/device.h"
#include "rhi/pipeline.h"
#include "rhi/texture_table.h"

namespace raygraph::rhi {
namespace {

VkImageSubresourceLayers PlaceOf(const Texture& texture, uint32_t mipLevel, uint32_t layer = 0) {
    return {texture.WholeRange().aspectMask, mipLevel, layer, 1};
}

VkOffset3D Corner(Extent2D extent) {
    return {static_cast<int32_t>(extent.width), static_cast<int32_t>(extent.height), 1};
}

VkImageLayout LayoutFor(VkDescriptorType type) {
    return type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE ? VK_IMAGE_LAYOUT_GENERAL
                                                    : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
}

std::string TextOf(Extent2D extent) {
    return Text("{}x{}", extent.width, extent.height);
}

// "'albedo' (640x360 rgba8)"
std::string TextOf(const Texture& texture) {
    return "'" + texture.Desc().name + "' (" + TextOf(texture.Extent()) + " " + Name(texture.Desc().format) +
           ")";
}

// "mip level 2 of 2", "layer 6 of 6"; empty: the texture has both.
std::string MissingSubresource(const Texture& texture, uint32_t mipLevel, uint32_t layer) {
    const TextureDesc& desc = texture.Desc();
    if (mipLevel >= desc.mipLevels) return Text("mip level {} of {}", mipLevel, desc.mipLevels);
    return layer >= desc.layers ? Text("layer {} of {}", layer, desc.layers) : std::string();
}

// Rows of a mip level of a layer, tightly packed in a buffer.
void CheckBufferCopy(const char* call, const Buffer& buffer, uint64_t offset, const Texture& texture,
                     uint32_t mipLevel, uint32_t layer, uint32_t firstRow, uint32_t rowCount) {
    const auto fail = [&](const std::string& why) {
        throw MakeError(ErrorKind::Usage, "{}: buffer '{}' ({} bytes) and texture {}: {}", call,
                        buffer.Desc().name, buffer.Size(), TextOf(texture), why);
    };
    const std::string missing = MissingSubresource(texture, mipLevel, layer);
    if (!missing.empty()) fail(missing);
    const Extent2D extent = MipExtent(texture.Extent(), mipLevel);
    if (firstRow > extent.height || rowCount > extent.height - firstRow)
        fail(Text("{} rows from {} on, there are {}", rowCount, firstRow, extent.height));
    const uint32_t texelBytes = TexelBytes(texture.Desc().format);
    const uint32_t alignment = std::lcm(texelBytes, 4u);
    if (offset % alignment != 0) fail(Text("offset {} is not a multiple of {}", offset, alignment));
    const uint32_t side = BlockSide(texture.Desc().format);
    if (firstRow % side != 0 || (rowCount % side != 0 && firstRow + rowCount != extent.height))
        fail(Text("{} rows from {} on, the format has blocks of {}", rowCount, firstRow, side));
    const uint64_t bytes = ImageBytes(texture.Desc().format, {extent.width, rowCount});
    if (bytes > buffer.Size() || offset > buffer.Size() - bytes)
        fail(Text("{} bytes at {} do not fit", bytes, offset));
}

}  // namespace

CommandList& CommandList::operator=(CommandList&& other) noexcept {
    if (this == &other) return *this;
    if (m_device) m_device->Recycle(*this, {});
    m_device = std::exchange(other.m_device, nullptr);
    m_commands = std::exchange(other.m_commands, VK_NULL_HANDLE);
    m_pool = std::exchange(other.m_pool, VK_NULL_HANDLE);
    m_queue = other.m_queue;
    m_serial = std::exchange(other.m_serial, 0);
    m_onSubmitted = std::exchange(other.m_onSubmitted, {});
    m_onDropped = std::exchange(other.m_onDropped, {});
    m_pipeline = std::exchange(other.m_pipeline, nullptr);
    m_tracing = std::exchange(other.m_tracing, nullptr);
    m_compute = std::exchange(other.m_compute, nullptr);
    m_portion = std::exchange(other.m_portion, {});
    m_bindPoint = other.m_bindPoint;
    return *this;
}

CommandList::~CommandList() {
    if (m_device) m_device->Recycle(*this, {});
}

const DeviceFunctions& CommandList::Vk() const {
    return m_device->Vk();
}

void CommandList::Barriers(std::span<const VkMemoryBarrier2> memory,
                           std::span<const VkImageMemoryBarrier2> images,
                           std::span<const VkBufferMemoryBarrier2> buffers) {
    if (memory.empty() && images.empty() && buffers.empty()) return;
    VkDependencyInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO;
    info.memoryBarrierCount = static_cast<uint32_t>(memory.size());
    info.pMemoryBarriers = memory.data();
    info.bufferMemoryBarrierCount = static_cast<uint32_t>(buffers.size());
    info.pBufferMemoryBarriers = buffers.data();
    info.imageMemoryBarrierCount = static_cast<uint32_t>(images.size());
    info.pImageMemoryBarriers = images.data();
    Vk().vkCmdPipelineBarrier2(m_commands, &info);
}

void CommandList::FullBarrier() {
    VkMemoryBarrier2 barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2;
    barrier.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    barrier.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
    barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
    Barriers({&barrier, 1}, {});
}

void CommandList::Transition(const Texture& texture, VkImageLayout from, VkImageLayout to) {
    VkImageMemoryBarrier2 barrier = ImageBarrier(texture, from, to);
    barrier.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    barrier.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
    barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
    Barriers({}, {&barrier, 1});
}

void CommandList::Bind(const Pipeline& pipeline, VkPipelineBindPoint bindPoint) {
    m_pipeline = &pipeline;
    m_compute = nullptr;
    m_tracing = nullptr;
    m_bindPoint = bindPoint;
    Vk().vkCmdBindPipeline(m_commands, bindPoint, pipeline.Handle());
}

void CommandList::Bind(const ComputePipeline& pipeline) {
    Bind(pipeline, VK_PIPELINE_BIND_POINT_COMPUTE);
    m_compute = &pipeline;
}

void CommandList::Bind(const RayTracingPipeline& pipeline) {
    Bind(pipeline, VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR);
    m_tracing = &pipeline;
}

void CommandList::Bind(const RasterPipeline& pipeline) {
    Bind(pipeline, VK_PIPELINE_BIND_POINT_GRAPHICS);
}

void CommandList::RequirePipeline(const char* call) const {
    if (!m_pipeline) throw MakeError(ErrorKind::Usage, "{}: no pipeline is bound", call);
}

void CommandList::BindResources(std::span<const BoundResource> resources) {
    if (resources.empty()) return;
    RequirePipeline("BindResources");
    const size_t count = resources.size();
    if (count > kMaxBoundResources)
        throw MakeError(ErrorKind::Usage, "BindResources: pipeline '{}': {} resources, at most {}",
                        m_pipeline->Name(), count, kMaxBoundResources);
    std::array<VkWriteDescriptorSet, kMaxBoundResources> writes{};
    std::array<VkDescriptorBufferInfo, kMaxBoundResources> buffers;
    std::array<VkDescriptorImageInfo, kMaxBoundResources> images;
    std::array<VkWriteDescriptorSetAccelerationStructureKHR, kMaxBoundResources> structures;
    for (size_t i = 0; i < count; ++i) {
        const BoundResource& resource = resources[i];
        VkWriteDescriptorSet& write = writes[i];
        write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
        write.dstBinding = resource.binding;
        write.dstArrayElement = resource.element;
        write.descriptorCount = 1;
        write.descriptorType = resource.type;
        if (resource.buffer) {
            buffers[i] = {resource.buffer->Handle(), resource.offset, resource.size};
            write.pBufferInfo = &buffers[i];
        } else if (resource.texture) {
            images[i] = {resource.sampler ? resource.sampler->Handle() : VK_NULL_HANDLE,
                         resource.view ? resource.view : resource.texture->View(), LayoutFor(resource.type)};
            write.pImageInfo = &images[i];
        } else if (resource.accelerationStructure) {
            structures[i] = {};
            structures[i].sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR;
            structures[i].accelerationStructureCount = 1;
            structures[i].pAccelerationStructures = &resource.accelerationStructure;
            write.pNext = &structures[i];
        } else {
            throw MakeError(ErrorKind::Usage,
                            "BindResources: pipeline '{}', binding {}: nothing is given for it",
                            m_pipeline->Name(), resource.binding);
        }
    }
    Vk().vkCmdPushDescriptorSetKHR(m_commands, m_bindPoint, m_pipeline->Layout(), 0,
                                   static_cast<uint32_t>(count), writes.data());
}

void CommandList::BindTextures(const TextureTable& table) {
    RequirePipeline("BindTextures");
    VkDescriptorSet set = table.Set();
    Vk().vkCmdBindDescriptorSets(m_commands, m_bindPoint, m_pipeline->Layout(), 1, 1, &set, 0, nullptr);
}

void CommandList::PushConstants(std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    RequirePipeline("PushConstants");
    if (bytes.size() > m_pipeline->PushConstantBytes() || bytes.size() % 4 != 0)
        throw MakeError(ErrorKind::Usage,
                        "PushConstants: {} bytes, pipeline '{}' takes a multiple of 4 up to {}", bytes.size(),
                        m_pipeline->Name(), m_pipeline->PushConstantBytes());
    Vk().vkCmdPushConstants(m_commands, m_pipeline->Layout(), m_pipeline->PushConstantStages(), 0,
                            static_cast<uint32_t>(bytes.size()), bytes.data());
}

void CommandList::Dispatch(uint32_t groupsX, uint32_t groupsY, uint32_t groupsZ) {
    if (!m_compute) throw Error(ErrorKind::Usage, "Dispatch: no compute pipeline is bound");
    if (groupsX == 0 || groupsY == 0 || groupsZ == 0) return;
    const std::array<uint32_t, 3>& max = m_device->Info().maxGroupCounts;
    if (groupsX > max[0] || groupsY > max[1] || groupsZ > max[2])
        throw MakeError(ErrorKind::Usage,
                        "Dispatch: pipeline '{}': {} x {} x {} groups, the device takes {} x {} x {}",
                        m_compute->Name(), groupsX, groupsY, groupsZ, max[0], max[1], max[2]);
    if (m_portion.IsWhole()) {
        Vk().vkCmdDispatch(m_commands, groupsX, groupsY, groupsZ);
        return;
    }
    std::array<uint32_t, 3> first{}, count{groupsX, groupsY, groupsZ};
    const size_t longest = static_cast<size_t>(std::ranges::max_element(count) - count.begin());
    const Portion groups = PortionOf(count[longest]);
    first[longest] = groups.first;
    count[longest] = groups.end - groups.first;
    if (count[longest] > 0)
        Vk().vkCmdDispatchBase(m_commands, first[0], first[1], first[2], count[0], count[1], count[2]);
}

void CommandList::DispatchOver(Extent2D extent) {
    if (!m_compute) throw Error(ErrorKind::Usage, "DispatchOver: no compute pipeline is bound");
    const auto [x, y, z] = m_compute->WorkgroupSize();
    const auto groups = [](uint32_t texels, uint32_t size) {
        return texels / size + (texels % size != 0 ? 1 : 0);
    };
    Dispatch(groups(extent.width, x), groups(extent.height, y), 1);
}

void CommandList::TraceRays(Extent2D extent) {
    if (!m_tracing) throw Error(ErrorKind::Usage, "TraceRays: no ray-tracing pipeline is bound");
    if (extent.IsEmpty()) return;
    const uint64_t rays = uint64_t{extent.width} * extent.height;
    if (rays > m_device->Info().maxRayInvocationCount)
        throw MakeError(ErrorKind::Usage, "TraceRays: pipeline '{}': {} invocations, the device takes {}",
                        m_tracing->Name(), TextOf(extent), m_device->Info().maxRayInvocationCount);
    Vk().vkCmdTraceRaysKHR(m_commands, &m_tracing->RayGenRegion(), &m_tracing->MissRegion(),
                           &m_tracing->HitRegion(), &m_tracing->CallableRegion(), extent.width, extent.height,
                           1);
}

void CommandList::CopyBuffer(const Buffer& source, uint64_t sourceOffset, const Buffer& target,
                             uint64_t targetOffset, uint64_t size) {
    if (size == 0) return;
    const auto fits = [&](const Buffer& buffer, uint64_t offset) {
        return size <= buffer.Size() && offset <= buffer.Size() - size;
    };
    if (!fits(source, sourceOffset) || !fits(target, targetOffset))
        throw MakeError(ErrorKind::Usage,
                        "CopyBuffer: {} bytes from '{}' ({} bytes) at {} to '{}' ({} bytes) at {} do not fit",
                        size, source.Desc().name, source.Size(), sourceOffset, target.Desc().name,
                        target.Size(), targetOffset);
    const VkBufferCopy2 region{VK_STRUCTURE_TYPE_BUFFER_COPY_2, nullptr, sourceOffset, targetOffset, size};
    const VkCopyBufferInfo2 info{
        VK_STRUCTURE_TYPE_COPY_BUFFER_INFO_2, nullptr, source.Handle(), target.Handle(), 1, &region};
    Vk().vkCmdCopyBuffer2(m_commands, &info);
}

void CommandList::CopyToTexture(const Buffer& source, uint64_t offset, const Texture& target,
                                uint32_t mipLevel, uint32_t layer) {
    const uint32_t rowCount =
        mipLevel < target.Desc().mipLevels ? MipExtent(target.Extent(), mipLevel).height : 0;
    CopyRowsToTexture(source, offset, target, mipLevel, 0, rowCount, layer);
}

void CommandList::CopyRowsToTexture(const Buffer& source, uint64_t offset, const Texture& target,
                                    uint32_t mipLevel, uint32_t firstRow, uint32_t rowCount, uint32_t layer) {
    CheckBufferCopy("CopyToTexture", source, offset, target, mipLevel, layer, firstRow, rowCount);
    if (rowCount == 0) return;
    VkBufferImageCopy2 region{};
    region.sType = VK_STRUCTURE_TYPE_BUFFER_IMAGE_COPY_2;
    region.bufferOffset = offset;
    region.imageSubresource = PlaceOf(target, mipLevel, layer);
    region.imageOffset = {0, static_cast<int32_t>(firstRow), 0};
    region.imageExtent = {MipExtent(target.Extent(), mipLevel).width, rowCount, 1};
    const VkCopyBufferToImageInfo2 info{
        VK_STRUCTURE_TYPE_COPY_BUFFER_TO_IMAGE_INFO_2, nullptr, source.Handle(), target.Image(),
        VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,          1,       &region};
    Vk().vkCmdCopyBufferToImage2(m_commands, &info);
}

void CommandList::CopyToBuffer(const Texture& source, const Buffer& target, uint64_t offset,
                               uint32_t mipLevel, uint32_t layer) {
    const Extent2D extent =
        mipLevel < source.Desc().mipLevels ? MipExtent(source.Extent(), mipLevel) : Extent2D{};
    CheckBufferCopy("CopyToBuffer", target, offset, source, mipLevel, layer, 0, extent.height);
    VkBufferImageCopy2 region{};
    region.sType = VK_STRUCTURE_TYPE_BUFFER_IMAGE_COPY_2;
    region.bufferOffset = offset;
    region.imageSubresource = PlaceOf(source, mipLevel, layer);
    region.imageExtent = {extent.width, extent.height, 1};
    const VkCopyImageToBufferInfo2 info{VK_STRUCTURE_TYPE_COPY_IMAGE_TO_BUFFER_INFO_2,
                                        nullptr,
                                        source.Image(),
                                        VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                        target.Handle(),
                                        1,
                                        &region};
    Vk().vkCmdCopyImageToBuffer2(m_commands, &info);
}

void CommandList::CopyTexture(const Texture& source, const Place& from, const Texture& target,
                              const Place& to) {
    for (const auto& [texture, place] : {std::pair(&source, &from), std::pair(&target, &to)}) {
        const std::string missing = MissingSubresource(*texture, place->level, place->layer);
        if (!missing.empty())
            throw MakeError(ErrorKind::Usage, "CopyTexture: from {} to {}: {} of '{}'", TextOf(source),
                            TextOf(target), missing, texture->Desc().name);
    }
    const Extent2D extent = MipExtent(source.Extent(), from.level);
    const Extent2D targetExtent = MipExtent(target.Extent(), to.level);
    const Format format = source.Desc().format;
    const Format targetFormat = target.Desc().format;
    if (extent != targetExtent || TexelBytes(format) != TexelBytes(targetFormat) ||
        BlockSide(format) != BlockSide(targetFormat) || IsDepth(format) != IsDepth(targetFormat))
        throw MakeError(ErrorKind::Usage, "CopyTexture: {} does not fit {}{}", TextOf(source), TextOf(target),
                        from.level == 0 && to.level == 0
                            ? std::string()
                            : Text(": level {} is {}, level {} is {}", from.level, TextOf(extent), to.level,
                                   TextOf(targetExtent)));
    VkImageCopy2 region{};
    region.sType = VK_STRUCTURE_TYPE_IMAGE_COPY_2;
    region.srcSubresource = PlaceOf(source, from.level, from.layer);
    region.dstSubresource = PlaceOf(target, to.level, to.layer);
    region.extent = {extent.width, extent.height, 1};
    const VkCopyImageInfo2 info{VK_STRUCTURE_TYPE_COPY_IMAGE_INFO_2,
                                nullptr,
                                source.Image(),
                                VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                target.Image(),
                                VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                1,
                                &region};
    Vk().vkCmdCopyImage2(m_commands, &info);
}

void CommandList::BlitMip(const Texture& texture, uint32_t level) {
    VkImageBlit2 region{};
    region.sType = VK_STRUCTURE_TYPE_IMAGE_BLIT_2;
    region.srcSubresource = PlaceOf(texture, level - 1);
    region.srcOffsets[1] = Corner(MipExtent(texture.Extent(), level - 1));
    region.dstSubresource = PlaceOf(texture, level);
    region.dstOffsets[1] = Corner(MipExtent(texture.Extent(), level));
    const VkBlitImageInfo2 info{VK_STRUCTURE_TYPE_BLIT_IMAGE_INFO_2,
                                nullptr,
                                texture.Image(),
                                VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                texture.Image(),
                                VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                1,
                                &region,
                                VK_FILTER_LINEAR};
    Vk().vkCmdBlitImage2(m_commands, &info);
}

void CommandList::Fill(const Buffer& target, uint32_t value, uint64_t offset, uint64_t size) {
    Vk().vkCmdFillBuffer(m_commands, target.Handle(), offset, size, value);
}

void CommandList::Clear(const Texture& texture, const float (&rgba)[4], const Subresources& part) {
    const TextureDesc& desc = texture.Desc();
    const Subresources resolved = Resolved(part, desc.mipLevels, desc.layers);
    const std::string missing = DescribeMissing(resolved, desc.mipLevels, desc.layers);
    if (!missing.empty()) throw MakeError(ErrorKind::Usage, "Clear: {}: {}", TextOf(texture), missing);
    VkClearColorValue value{};
    std::copy_n(rgba, 4, value.float32);
    const VkImageSubresourceRange range = texture.RangeOf(resolved);
    Vk().vkCmdClearColorImage(m_commands, texture.Image(), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &value, 1,
                              &range);
}

void CommandList::BeginLabel(const std::string& name) {
    if (!Vk().vkCmdBeginDebugUtilsLabelEXT) return;
    VkDebugUtilsLabelEXT label{};
    label.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT;
    label.pLabelName = name.c_str();
    Vk().vkCmdBeginDebugUtilsLabelEXT(m_commands, &label);
}

void CommandList::EndLabel() {
    if (Vk().vkCmdEndDebugUtilsLabelEXT) Vk().vkCmdEndDebugUtilsLabelEXT(m_commands);
}

void CommandList::WriteTimestamp(VkQueryPool pool, uint32_t query, VkPipelineStageFlags2 stage) {
    Vk().vkCmdWriteTimestamp2(m_commands, stage, pool, query);
}

// --- Drawing ---

namespace {

VkImageView TargetView(const Texture& texture, const Subresources& part) {
    return texture.View(part, part.layerCount > 1 ? ImageShape::Array : ImageShape::Plain);
}

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
        attachment.imageView = TargetView(*colors[i].texture, colors[i].part);
        attachment.imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL;
        attachment.loadOp = colors[i].clear ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
        attachment.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
        std::copy_n(colors[i].clearValue, 4, attachment.clearValue.color.float32);
    }
    VkRenderingAttachmentInfo depthAttachment{};
    if (depth) {
        depthAttachment.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO;
        depthAttachment.imageView = TargetView(*depth->texture, depth->part);
        depthAttachment.imageLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        depthAttachment.loadOp = depth->clear ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
        depthAttachment.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
        depthAttachment.clearValue.depthStencil.depth = depth->clearValue;
    }
    const VkRect2D area{{0, 0}, {extent.width, extent.height}};
    VkRenderingInfo info{};
    info.sType = VK_STRUCTURE_TYPE_RENDERING_INFO;
    info.renderArea = area;
    info.layerCount = depth ? depth->part.layerCount : colors.empty() ? 1 : colors.front().part.layerCount;
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
