#version 460
#extension GL_GOOGLE_include_directive : require
// Subtract: the difference of two pictures.
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D whole;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D part;
layout(set = 0, binding = 2, rgba32f) writeonly uniform image2D difference;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(difference)))) return;
    imageStore(difference, pixel, imageLoad(whole, pixel) - imageLoad(part, pixel));
}
