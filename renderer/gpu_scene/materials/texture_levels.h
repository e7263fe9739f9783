// MakeTextureLevels: passes that make the mip levels of a material texture. Threads: that of the Renderer.
#pragma once

#include <optional>

#include "base/api.h"
#include "renderer/graph/renderer.h"

namespace raygraph {

// What the texels of a texture are, and so how they are averaged.
enum class TexelContent : uint8_t {
    Data,              // as they stand
    Color,             // sRGB, with linear alpha: in linear light
    TransparentColor,  // the same, weighted by alpha
    Normals,           // unit vectors, from [-1, 1]; every level has unit vectors again
};

// The means of an image as floats (rgba32f), from its level 1 on: what its levels were encoded from.
struct TextureMeans {
    TextureId levels;
    Extent2D extent;  // of the image
};

// A material whose roughness is in the texture's green, and what its surface is bent by.
struct RoughnessWidening {
    TextureMeans normals;  // of its normal map, at the same texture coordinates
    // The levels of the normal map's image that materials read: what it is without those before the first is
    // seen nowhere, and what the last one has is seen at any distance.
    uint32_t firstNormals = 0, lastNormals = UINT32_MAX;
    float normalScale = 1.0f;
    float roughnessFactor = 1.0f;  // greater than 0
};

struct TextureLevelSettings {
    TexelContent content = TexelContent::Data;
    std::optional<RoughnessWidening> widening;
    std::optional<TextureId> means;  // where a normal map's go: rgba32f, its level 1 and all below
    uint32_t firstLevel = 0;         // of the image: the target's level 0
};

struct TextureLevels {
    TextureId texture;                  // the target
    std::optional<TextureMeans> means;  // none of an image of one texel
};

// `image` is rgba8 of one level; the target has a format of four bytes a texel, the size of level
// `firstLevel` of it, and any number of levels. Fills all of them: level 0 is the image itself if firstLevel
// is 0. Each level is the mean of the one above over the area of its texels, also where that has an odd
// number of them, by floats that are rounded once. A roughness grows by the variance of the normals that a
// texel covers: the picture keeps the highlights' width as details of the normal map vanish (the formulas are
// in shaders/scene/texture_level_main.glsl). The target's level 0, which is also read from near, grows by
// those before firstNormals alone. Error{Usage} for sizes that do not fit.
[[nodiscard]] RAYGRAPH_API TextureLevels MakeTextureLevels(Renderer& renderer, TextureId image,
                                                           TextureId target,
                                                           const TextureLevelSettings& settings);

}  // namespace raygraph
