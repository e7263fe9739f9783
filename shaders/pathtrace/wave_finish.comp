// After a wavefront: an infinite or NaN sample is written as black, and counted.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "core/math.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 16, rgba32f) uniform image2D radiance;
layout(set = 0, binding = 24, scalar) buffer PixelQueue {
    uint takenCount;
    uint nonFiniteCount;
} pixelQueue;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(radiance)))) return;
    vec4 value = imageLoad(radiance, texel);
    if (IsFinite(value.xyz)) return;
    atomicAdd(pixelQueue.nonFiniteCount, 1u);
    imageStore(radiance, texel, vec4(vec3(0.0f), value.w));
}
