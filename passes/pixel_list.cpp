#include "passes/pixel_list.h"

#include <cstring>

#include "base/check.h"
#include "base/text.h"
#include "rhi/device.h"

namespace raygraph::passes {

namespace {

uint32_t Quotient(uint64_t a, uint64_t b) {  // rounded up
    return static_cast<uint32_t>((a + b - 1) / b);
}

BufferId Staged(Renderer& renderer, const char* name, uint64_t bytes) {
    return renderer.CreateBuffer(name, {.size = bytes, .memory = rhi::MemoryKind::Upload});
}

void Write(const rhi::Buffer& staging, std::span<const std::byte> bytes) {
    std::memcpy(staging.Mapped().data(), bytes.data(), bytes.size());
}

}  // namespace

PixelList::PixelList(rhi::Device& device, Extent2D picture) : m_picture(picture) {
    // Texels that repeat are fewer than rows
    const uint64_t most = (uint64_t{picture.width} + 1) * picture.height;
    m_buffer = device.CreateBuffer({.name = "pixelList",
                                    .size = most * sizeof(gpu::ListedPixel),
                                    .usage = rhi::BufferUsage::Storage | rhi::BufferUsage::CopyDestination});
    m_listed.address = m_buffer.Address();
}

void PixelList::Set(std::span<const gpu::ListedPixel> pixels) {
    const auto count = static_cast<uint32_t>(pixels.size());
    RG_CHECK(count > 0 && count <= uint64_t{m_picture.width} * m_picture.height);
    m_listed.count = count;
    m_listed.extent.height = Quotient(count, m_picture.width);
    m_listed.extent.width = Quotient(count, m_listed.extent.height);
    m_changed.assign(pixels.begin(), pixels.end());
    m_changed.resize(size_t{m_listed.extent.width} * m_listed.extent.height, pixels.back());
}

ListedPixels PixelList::Declare(Renderer& renderer) {
    RG_CHECK(m_listed.IsGiven());
    m_listed.list = renderer.Import("pixelList", m_buffer, m_state);
    if (m_changed.empty()) return m_listed;
    const uint64_t bytes = std::as_bytes(std::span(m_changed)).size();
    const BufferId staging = Staged(renderer, "pixelList.staging", bytes);
    renderer.AddPass(
        "ListPixels", PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.CopiesFrom(staging);
            m_listed.list = pass.CopiesTo(m_listed.list);
        },
        [staging, list = m_listed.list, pixels = std::move(m_changed)](CommandList& commands,
                                                                       const PassResources& resources) {
            const std::span<const std::byte> data = std::as_bytes(std::span(pixels));
            Write(resources.Buffer(staging), data);
            commands.CopyBuffer(resources.Buffer(staging), 0, resources.Buffer(list), 0, data.size());
        });
    m_changed.clear();
    return m_listed;
}

TextureId UploadCounts(Renderer& renderer, std::span<const uint32_t> counts, Extent2D picture) {
    return UploadTexels(renderer, std::as_bytes(counts),
                        renderer.CreateTexture("counts", {picture, Format::R32Uint}));
}

TextureId UploadTexels(Renderer& renderer, std::span<const std::byte> texels, TextureId target) {
    const Extent2D extent = renderer.Desc(target).extent;
    if (texels.size() != size_t{4} * extent.width * extent.height)
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
