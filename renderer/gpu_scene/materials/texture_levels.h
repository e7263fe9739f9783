// MakeTextureLevels: passes that make the mip levels of a material texture. Threads: that of the Renderer.
#pragma once

#include <optional>

#include "base/api.h"
#include "renderer/graph/renderer.h"

namespace raygraph {

// The kind of texels of a texture, which says how they are averaged.
enum class TexelContent : uint8_t {
    Data,              // averaged as they are
    Color,             // sRGB with linear alpha, averaged in linear light
    TransparentColor,  // as Color, weighted by alpha
    Normals,           // unit vectors, encoded from [-1, 1]; those of each level are normalized again
};

// The means of an image as floats (rgba32f), from its level 1 on: the values before encoding.
struct TextureMeans {
    TextureId levels;
    Extent2D extent;  // that of the image
};

// A texture with roughness in its green channel, and the normal map that bends its surface.
struct RoughnessWidening {
    TextureMeans normals;  // means of its normal map, at the same texture coordinates
    // The levels of the normal map's image that materials read. The variance of levels before the first is
    // visible nowhere, and the detail of the last one at any distance.
    uint32_t firstNormals = 0, lastNormals = UINT32_MAX;
    float normalScale = 1.0f;
    float roughnessFactor = 1.0f;  // greater than 0
};

struct TextureLevelSettings {
    TexelContent content = TexelContent::Data;
    std::optional<RoughnessWidening> widening;
    std::optional<TextureId> means;  // rgba32f, for a normal map: its level 1 and all below
    uint32_t firstLevel = 0;         // level of the image that is the target's level 0
};

struct TextureLevels {
    TextureId texture;                  // the target
    std::optional<TextureMeans> means;  // empty for an image of one texel
};

// Fills all levels of the target. `image` is rgba8 with one level; the target has a format of four bytes per
// texel, the size of level `firstLevel` of the image, and any number of levels. Level 0 is the image itself
// if firstLevel is 0. Each level is the mean of the one above over the area of its texels, also if that has
// an odd number of them, computed in floats that are rounded once. A roughness grows by the variance of the
// normals that a texel covers: highlights keep their width in the picture as details of the normal map vanish
// (the formulas are in shaders/scene/texture_level_main.glsl). The target's level 0, which is also read from
// near, grows by the variance of the levels before firstNormals alone. Throws Error{Usage} for sizes that do
// not fit.
[[nodiscard]] RAYGRAPH_API TextureLevels MakeTextureLevels(Renderer& renderer, TextureId image,
                                                           TextureId target,
                                                           const TextureLevelSettings& settings);

}  // namespace raygraph
