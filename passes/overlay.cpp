#include "passes/overlay.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "base/text.h"

namespace raygraph::passes {

namespace {

TextureId Compose(Renderer& renderer, const char* name, TextureId coarse, TextureId fine, Extent2D extent,
                  const TileCursor& done) {
    TextureId picture = renderer.CreateTexture("overlay", {extent, Format::Rgba32Float});
    struct Constants {
        uint32_t x, y, bandHeight;
    };
    renderer.AddPass(
        name, PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/overlay.comp");
            pass.Reads("coarse", coarse);
            pass.Reads("fine", fine);
            pass.Constants(Constants{done.X(), done.Y(), done.BandHeight()});
            picture = pass.Writes("picture", picture);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return picture;
}

}  // namespace

TextureId Overlay(Renderer& renderer, TextureId coarse, TextureId fine, const TileCursor& done) {
    return Compose(renderer, "Overlay", coarse, fine, renderer.Desc(fine).extent, done);
}

TextureId Upscale(Renderer& renderer, TextureId coarse, Extent2D extent) {
    return Compose(renderer, "Upscale", coarse, coarse, extent, {});
}

// --- Outlines ---

namespace {

constexpr float kWidest = 8.0f;  // pixels

// Returns a bit for each instance up to the last one of them; at least one word.
std::vector<uint32_t> BitsOf(std::span<const uint32_t> instances) {
    const uint32_t last = instances.empty() ? 0 : *std::ranges::max_element(instances);
    std::vector<uint32_t> bits(last / 32 + 1, 0);
    for (const uint32_t instance : instances) bits[instance / 32] |= 1u << (instance % 32);
    return bits;
}

void RequireFormat(const GraphTextureDesc& desc, Format format, const char* what) {
    if (desc.format != format)
        throw MakeError(ErrorKind::Usage, "outline: {} is {}, must be {}", what, rhi::Name(desc.format),
                        rhi::Name(format));
}

}  // namespace

TextureId OutlineInstances(Renderer& renderer, TextureId hits, std::span<const uint32_t> instances,
                           TextureId line, float width, std::function<void()> onSubmitted) {
    if (!(width > 0.0f && width <= kWidest))
        throw MakeError(ErrorKind::Usage, "outline: a line of {} pixels, must be above 0 and at most 8",
                        width);
    const GraphTextureDesc desc = renderer.Desc(line);
    RequireFormat(desc, Format::R32Float, "the line");
    RequireFormat(renderer.Desc(hits), Format::Rgba32Uint, "what is seen");
    std::vector<uint32_t> bits = BitsOf(instances);
    const BufferId outlined = renderer.CreateBuffer(
        "outlined", {.size = bits.size() * sizeof(uint32_t), .memory = rhi::MemoryKind::Upload});
    renderer.AddPass(
        "OutlineInstances", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/outline_instances.comp");
            pass.Reads("hits", hits);
            pass.Reads("outlined", outlined);
            pass.Constants(width);
            line = pass.Writes("line", line);
        },
        [extent = desc.extent, outlined, bits = std::move(bits), onSubmitted = std::move(onSubmitted)](
            CommandList& commands, const PassResources& resources) {
            std::memcpy(resources.Buffer(outlined).Mapped().data(), bits.data(),
                        bits.size() * sizeof(uint32_t));
            commands.DispatchOver(extent);
            if (onSubmitted) commands.OnSubmitted(onSubmitted);
        });
    return line;
}

TextureId DrawOutline(Renderer& renderer, TextureId picture, TextureId line, const glm::vec3& color) {
    const GraphTextureDesc desc = renderer.Desc(picture);
    RequireFormat(desc, Format::Rgba8Unorm, "the picture");
    RequireFormat(renderer.Desc(line), Format::R32Float, "the line");
    if (!(renderer.Desc(line).extent == desc.extent))
        throw Error(ErrorKind::Usage, "outline: the line is not of the picture's extent");
    TextureId display = renderer.CreateTexture("outlined picture", desc);
    renderer.AddPass(
        "DrawOutline", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("post/draw_outline.comp");
            pass.Reads("picture", picture);
            pass.Reads("line", line);
            pass.Constants(glm::vec4(color, 1.0f));
            display = pass.Writes("display", display);
        },
        [extent = desc.extent](CommandList& commands) { commands.DispatchOver(extent); });
    return display;
}

}  // namespace raygraph::passes
