// Stores the network's planes (passes/denoise_network.h): halves, in blocks of four channels, each
// block a picture.
#ifndef RAYGRAPH_DENOISE_NETWORK_GLSL
#define RAYGRAPH_DENOISE_NETWORK_GLSL

const float kDarkest = 0.02f;  // is added to the albedo by which light is divided
const uint kKernelTaps = 25u;  // 5 x 5
const uint kKernelBlocks =
    7u;  // of one pixel: weights of the taps, the share of the coarser level, and two unused

uvec2 PackHalves(vec4 value) {
    return uvec2(packHalf2x16(value.xy), packHalf2x16(value.zw));
}
vec4 UnpackHalves(uvec2 bits) {
    return vec4(unpackHalf2x16(bits.x), unpackHalf2x16(bits.y));
}

uint IndexOf(uint block, ivec2 pixel, ivec2 size) {
    return (block * uint(size.y) + uint(pixel.y)) * uint(size.x) + uint(pixel.x);
}

#endif
