#include "renderer/gpu_scene/materials/texture_levels.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/text.h"
#include "shaders/shared/texture_levels.h"

namespace raygraph {

namespace {

static_assert(static_cast<uint32_t>(TexelContent::Data) == gpu::kTexelsData);
static_assert(static_cast<uint32_t>(TexelContent::Color) == gpu::kTexelsColor);
static_assert(static_cast<uint32_t>(TexelContent::TransparentColor) == gpu::kTexelsTransparentColor);
static_assert(static_cast<uint32_t>(TexelContent::Normals) == gpu::kTexelsNormals);

uint64_t TexelCount(Extent2D extent) {
    return uint64_t{extent.width} * extent.height;
}

// Returns the level of the normal map whose texels are as large as those of level `level` of the image.
float MatchingLevel(const TextureMeans& normals, Extent2D image, uint32_t level) {
    const double ratio =
        static_cast<double>(TexelCount(normals.extent)) / static_cast<double>(TexelCount(image));
    return static_cast<float>(level + 0.5 * std::log2(ratio));
}

// Returns the level of the normal map whose variance widens the roughness of this level. The target's first
// level is also read from near, where all levels of the normal map are visible.
float NormalsLod(const RoughnessWidening& widening, Extent2D image, uint32_t level, bool isFirst) {
    const auto first = static_cast<float>(widening.firstNormals);
    if (isFirst) return first;
    return std::clamp(MatchingLevel(widening.normals, image, level), first,
                      static_cast<float>(widening.lastNormals));
}

}  // namespace

TextureLevels MakeTextureLevels(Renderer& renderer, TextureId image, TextureId target,
                                const TextureLevelSettings& settings) {
    const Extent2D extent = renderer.Desc(image).extent;
    const GraphTextureDesc wanted = renderer.Desc(target);
    const uint32_t levelCount = rhi::FullMipCount(extent);
    if (settings.firstLevel >= levelCount || wanted.extent != rhi::MipExtent(extent, settings.firstLevel))
        throw MakeError(
            ErrorKind::Usage, "MakeTextureLevels: an image of {}x{} texels has no level {} of {}x{} texels",
            extent.width, extent.height, settings.firstLevel, wanted.extent.width, wanted.extent.height);
    const uint32_t last = settings.firstLevel + wanted.levels - 1;  // FullMipCount bounds wanted.levels
    TextureLevels made{.texture = target, .means = {}};
    const auto& widening = settings.widening;
    const bool widensImage = settings.firstLevel == 0 && widening && widening->firstNormals > 0;
    TextureId means, encoded, widenedImage;
    if (levelCount > 1 || widensImage) {
        // The means of a normal map are read by roughness textures, so that all levels are needed
        const bool isAll = settings.content == TexelContent::Normals;
        const GraphTextureDesc chain{.extent = rhi::MipExtent(extent, 1),
                                     .format = Format::Rgba32Float,
                                     .levels = std::max(isAll ? levelCount - 1 : last, 1u)};
        means = settings.means ? *settings.means : renderer.CreateTexture("textureMeans", chain);
        encoded = renderer.CreateTexture(
            "textureLevels", {.extent = chain.extent, .format = Format::Rgba8Unorm, .levels = chain.levels});
        if (widensImage)
            widenedImage =
                renderer.CreateTexture("widenedImage", {.extent = extent, .format = Format::Rgba8Unorm});
        const uint32_t end = std::min(chain.levels + 1, levelCount);
        for (uint32_t level = widensImage ? 0 : 1; level < end; ++level)
            renderer.AddPass(
                "TextureLevel", PassKind::Compute,
                [&](PassBuilder& pass) {
                    pass.Compute(widening ? "scene/texture_level_widened.comp" : "scene/texture_level.comp");
                    gpu::TextureLevelConstants constants{
                        .texels = static_cast<uint32_t>(settings.content),
                        .isFirst = level <= 1 ? 1u : 0u,
                        .normalsLod = 0.0f,
                        .hasOtherTexels = 0,
                        .slopeScale = 0.0f,
                        .roughnessFactor = 1.0f,
                    };
                    if (widening) {
                        pass.Reads("normals", widening->normals.levels, rhi::SamplerDesc{});
                        constants.normalsLod =
                            NormalsLod(*widening, extent, level, level == settings.firstLevel);
                        constants.hasOtherTexels =
                            constants.normalsLod != MatchingLevel(widening->normals, extent, level);
                        constants.slopeScale = widening->normalScale;
                        constants.roughnessFactor = widening->roughnessFactor;
                    }
                    pass.Constants(constants);
                    if (level <= 1)
                        pass.Reads("finer", image, rhi::SamplerDesc{});
                    else
                        pass.Reads("finer", means, rhi::Level(level - 2), rhi::SamplerDesc{});
                    means = pass.Writes("means", means, rhi::Level(std::max(level, 1u) - 1));
                    if (level == 0)
                        widenedImage = pass.Writes("encoded", widenedImage);
                    else
                        encoded = pass.Writes("encoded", encoded, rhi::Level(level - 1));
                },
                [size = rhi::MipExtent(extent, level)](CommandList& commands) {
                    commands.DispatchOver(size);
                });
        if (levelCount > 1) made.means = {.levels = means, .extent = extent};
    }
    const TextureId top = widensImage ? widenedImage : image;
    renderer.AddPass(
        "CopyTextureLevels", PassKind::Transfer,
        [&](PassBuilder& pass) {
            if (settings.firstLevel == 0) pass.CopiesFrom(top);
            if (last > 0) pass.CopiesFrom(encoded);
            made.texture = pass.CopiesTo(target);
        },
        [top, encoded, copied = target, first = settings.firstLevel, last](CommandList& commands,
                                                                           const PassResources& resources) {
            for (uint32_t level = first; level <= last; ++level) {
                const rhi::Texture& source = resources.Texture(level == 0 ? top : encoded);
                commands.CopyTexture(source, {.level = level == 0 ? 0 : level - 1}, resources.Texture(copied),
                                     {.level = level - first});
            }
        });
    return made;
}

}  // namespace raygraph
