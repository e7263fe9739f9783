// RelativeError: the relative error of a picture's luminance against a reference.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "core/color.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D reference;
layout(set = 0, binding = 1, rgba32f) readonly uniform image2D test;
layout(set = 0, binding = 2, r32f) writeonly uniform image2D error;

layout(push_constant) uniform Constants { float minimum; } constants;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(error)))) return;
    float truth = Luminance(imageLoad(reference, pixel).xyz);
    float value = Luminance(imageLoad(test, pixel).xyz);
    imageStore(error, pixel, vec4(abs(value - truth) / max(abs(truth), constants.minimum)));
}
