// Constants of the computation of mip levels of material textures: scene/texture_level_main.glsl and
// renderer/gpu_scene/materials/texture_set.h.
#ifndef RAYGRAPH_SHARED_TEXTURE_LEVELS_H
#define RAYGRAPH_SHARED_TEXTURE_LEVELS_H

#ifdef __cplusplus
#include <cstdint>

namespace raygraph::gpu {
using uint = uint32_t;
#define RAYGRAPH_CONSTANT inline constexpr
#else
#define RAYGRAPH_CONSTANT const
#endif

// The meaning of the four numbers of a texel.
RAYGRAPH_CONSTANT uint kTexelsData = 0u;              // averaged as they stand
RAYGRAPH_CONSTANT uint kTexelsColor = 1u;             // sRGB, with linear alpha: averaged in linear light
RAYGRAPH_CONSTANT uint kTexelsTransparentColor = 2u;  // as kTexelsColor, weighted by alpha
RAYGRAPH_CONSTANT uint kTexelsNormals = 3u;           // unit vectors, from [-1, 1]

struct TextureLevelConstants {
    uint texels;   // kTexels*
    uint isFirst;  // the finer level is the image itself, as it is stored; else means of it
    // The fields below are for a level of roughness that is widened by a normal map.
    float normalsLod;       // the level of the normal map whose waves are lost in this one
    uint hasOtherTexels;    // not as large as those of this level: normalsLod is a whole number
    float slopeScale;       // the normal map's scale
    float roughnessFactor;  // the material's factor on the texels
};

#undef RAYGRAPH_CONSTANT

#ifdef __cplusplus
}  // namespace raygraph::gpu
#endif

#endif
