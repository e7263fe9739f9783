#include "rhi/readback.h"

#include "base/text.h"
#include "rhi/device.h"

namespace raygraph::rhi {
namespace {

[[noreturn]] void Refuse(const std::string& kind, const std::string& name, const std::string& reason) {
    throw MakeError(ErrorKind::Usage, "readback of {} '{}': {}", kind, name, reason);
}

Buffer StagingFor(Device& device, const std::string& name, uint64_t size) {
    return device.CreateBuffer({.name = "readback of " + name,
                                .size = size,
                                .usage = BufferUsage::CopyDestination,
                                .memory = MemoryKind::Readback});
}

// The host is a reader like any other: waiting for the timeline does not make writes visible to it.
void ReleaseToHost(CommandList& commands) {
    VkMemoryBarrier2 barrier{};
    barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2;
    barrier.srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT;
    barrier.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
    barrier.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT;
    barrier.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT;
    commands.Barriers({&barrier, 1}, {});
}

std::vector<std::byte> SubmitAndWait(Device& device, CommandList&& commands, Readback& readback) {
    readback.SetSubmitted(device.Submit(std::move(commands)));
    const std::span<const std::byte> bytes = readback.Wait();
    return {bytes.begin(), bytes.end()};
}

}  // namespace

Readback Readback::Record(CommandList& commands, const Buffer& source, uint64_t offset, uint64_t size) {
    const std::string& name = source.Desc().name;
    if (!Has(source.Desc().usage, BufferUsage::CopySource))
        Refuse("buffer", name, "it has no usage CopySource");
    if (size == VK_WHOLE_SIZE && offset <= source.Size()) size = source.Size() - offset;
    if (size == 0 || size > source.Size() || offset > source.Size() - size)
        Refuse("buffer", name, Text("{} bytes at {}, it has {}", size, offset, source.Size()));
    Readback readback;
    readback.m_device = &commands.Owner();
    readback.m_staging = StagingFor(commands.Owner(), name, size);
    commands.FullBarrier();
    commands.CopyBuffer(source, offset, readback.m_staging, 0, size);
    ReleaseToHost(commands);
    return readback;
}

Readback Readback::Record(CommandList& commands, const Texture& source, VkImageLayout layout,
                          uint32_t mipLevel, uint32_t layer) {
    const TextureDesc& desc = source.Desc();
    if (!Has(desc.usage, TextureUsage::CopySource))
        Refuse("texture", desc.name, "it has no usage CopySource");
    if (mipLevel >= desc.mipLevels)
        Refuse("texture", desc.name, Text("mip level {}, it has {}", mipLevel, desc.mipLevels));
    if (layer >= desc.layers) Refuse("texture", desc.name, Text("layer {}, it has {}", layer, desc.layers));
    const Extent2D extent = MipExtent(desc.extent, mipLevel);
    Readback readback;
    readback.m_device = &commands.Owner();
    readback.m_staging = StagingFor(commands.Owner(), desc.name, ImageBytes(desc.format, extent));
    commands.Transition(source, layout, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL);
    commands.CopyToBuffer(source, readback.m_staging, 0, mipLevel, layer);
    ReleaseToHost(commands);
    if (layout != VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL)
        commands.Transition(source, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, layout);
    return readback;
}

bool Readback::IsReady() const {
    return m_value != 0 && m_device->CompletedValue() >= m_value;
}

std::span<const std::byte> Readback::Bytes() const {
    if (!IsReady()) throw MakeError(ErrorKind::Usage, "'{}' is not ready", m_staging.Desc().name);
    return m_staging.Mapped();
}

std::span<const std::byte> Readback::Wait() {
    if (m_value == 0) throw MakeError(ErrorKind::Usage, "'{}' was not submitted", m_staging.Desc().name);
    m_device->WaitFor(m_value);
    return m_staging.Mapped();
}

std::vector<std::byte> ReadBuffer(Device& device, const Buffer& source, uint64_t offset, uint64_t size) {
    CommandList commands = device.BeginCommands("read back " + source.Desc().name);
    Readback readback = Readback::Record(commands, source, offset, size);
    return SubmitAndWait(device, std::move(commands), readback);
}

std::vector<std::byte> ReadTexture(Device& device, const Texture& source, VkImageLayout layout,
                                   uint32_t mipLevel, uint32_t layer) {
    CommandList commands = device.BeginCommands("read back " + source.Desc().name);
    Readback readback = Readback::Record(commands, source, layout, mipLevel, layer);
    return SubmitAndWait(device, std::move(commands), readback);
}

}  // namespace raygraph::rhi
