#include "passes/pixel_list.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "base/check.h"
#include "base/text.h"
#include "rhi/device.h"

namespace raygraph::passes {

namespace {

// Rounds up to a quarter of a power of two.
uint32_t RoundedUp(uint32_t rows) {
    const uint32_t unit = std::max(std::bit_floor(rows) / 4, 1u);
    return (rows + unit - 1) / unit * unit;
}

BufferId Staged(Renderer& renderer, const char* name, uint64_t bytes) {
    return renderer.CreateBuffer(name, {.size = bytes, .memory = rhi::MemoryKind::Upload});
}

void Write(const rhi::Buffer& staging, std::span<const std::byte> bytes) {
    std::memcpy(staging.Mapped().data(), bytes.data(), bytes.size());
}

}  // namespace

PixelList::PixelList(rhi::Device& device, Extent2D picture) : m_picture(picture) {
    const uint64_t most = uint64_t{picture.width} * picture.height;
    m_buffer = device.CreateBuffer({.name = "pixelList",
                                    .size = most * sizeof(gpu::ListedPixel),
                                    .usage = rhi::BufferUsage::Storage | rhi::BufferUsage::CopyDestination});
}

void PixelList::Set(std::span<const gpu::ListedPixel> pixels) {
    RG_CHECK(!pixels.empty() && pixels.size() <= uint64_t{m_picture.width} * m_picture.height);
    m_count = static_cast<uint32_t>(pixels.size());
    m_changed.assign(pixels.begin(), pixels.end());
}

ListedPixels PixelList::Declare(Renderer& renderer, uint32_t count) {
    RG_CHECK(count > 0 && count <= m_count);
    const uint32_t rows = (count + m_picture.width - 1) / m_picture.width;
    ListedPixels listed{.list = renderer.Import("pixelList", m_buffer, m_state),
                        .address = m_buffer.Address(),
                        .count = count,
                        .extent = {m_picture.width, std::min(RoundedUp(rows), m_picture.height)}};
    if (m_changed.empty()) return listed;
    // The size is one of few, so that the buffer serves later lists, too
    const uint64_t bytes = std::as_bytes(std::span(m_changed)).size();
    const BufferId staging =
        Staged(renderer, "pixelList.staging", std::bit_ceil(std::max<uint64_t>(bytes, 4096)));
    renderer.AddPass(
        "ListPixels", PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.CopiesFrom(staging);
            listed.list = pass.CopiesTo(listed.list);
        },
        [staging, list = listed.list, pixels = std::move(m_changed)](CommandList& commands,
                                                                     const PassResources& resources) {
            const std::span<const std::byte> data = std::as_bytes(std::span(pixels));
            Write(resources.Buffer(staging), data);
            commands.CopyBuffer(resources.Buffer(staging), 0, resources.Buffer(list), 0, data.size());
        });
    m_changed.clear();
    return listed;
}

TextureId UploadCounts(Renderer& renderer, std::span<const uint32_t> counts, Extent2D picture) {
    return UploadTexels(renderer, std::as_bytes(counts),
                        renderer.CreateTexture("counts", {picture, Format::R32Uint}));
}

TextureId UploadTexels(Renderer& renderer, std::span<const std::byte> texels, TextureId target) {
    const Extent2D extent = renderer.Desc(target).extent;
    if (texels.size() != size_t{rhi::TexelBytes(renderer.Desc(target).format)} * extent.width * extent.height)
        throw MakeError(ErrorKind::Usage, "UploadTexels: {} bytes for a texture of {}x{}", texels.size(),
                        extent.width, extent.height);
    const BufferId staging = Staged(renderer, "texels.staging", texels.size());
    renderer.AddPass(
        "UploadTexels", PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.CopiesFrom(staging);
            target = pass.CopiesTo(target);
            pass.KeepAlive();
        },
        [staging, target, data = std::vector<std::byte>(texels.begin(), texels.end())](
            CommandList& commands, const PassResources& resources) {
            Write(resources.Buffer(staging), data);
            commands.CopyToTexture(resources.Buffer(staging), 0, resources.Texture(target));
        });
    return target;
}

}  // namespace raygraph::passes
