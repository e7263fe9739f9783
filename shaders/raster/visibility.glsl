// The texels of the visibility texture: the hit that a ray through the same film position would find, without
// its distance. Zero: no surface.
#ifndef RAYGRAPH_RASTER_VISIBILITY_GLSL
#define RAYGRAPH_RASTER_VISIBILITY_GLSL

#include "scene/ray.glsl"

uvec4 PackVisibility(uint instance, uint primitive, vec2 barycentrics) {
    return uvec4(instance + 1u, primitive, floatBitsToUint(barycentrics.x), floatBitsToUint(barycentrics.y));
}

Hit UnpackVisibility(uvec4 texel) {
    Hit hit;
    hit.t = texel.x == 0u ? -1.0f : 0.0f;
    hit.instance = texel.x - 1u;
    hit.primitive = texel.y;
    hit.barycentrics = vec2(uintBitsToFloat(texel.z), uintBitsToFloat(texel.w));
    return hit;
}

#endif
