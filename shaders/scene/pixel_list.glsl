// A list of pixels on the device, by its address (passes/pixel_list.h).
#ifndef RAYGRAPH_SCENE_PIXEL_LIST_GLSL
#define RAYGRAPH_SCENE_PIXEL_LIST_GLSL

#include "core/glue.h"
#include "shared/scene_records.h"

#ifndef __cplusplus
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PixelListStream {
    ListedPixel at[];
};
#endif

SHADING_BEGIN

INLINE uvec2 PixelOf(ListedPixel listed) { return uvec2(listed.texel & 0xFFFFu, listed.texel >> 16u); }

SHADING_END

#endif
