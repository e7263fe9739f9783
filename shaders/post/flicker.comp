// Flicker: the variance of a pixel's luminance over pictures, of which the newest count most.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "core/color.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba32f) readonly uniform image2D picture;
layout(set = 0, binding = 1, rg32f) uniform image2D moments;  // mean, variance
layout(set = 0, binding = 2, r32f) writeonly uniform image2D flicker;

layout(push_constant) uniform Constants { float weight; } constants;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(picture)))) return;
    float value = Luminance(imageLoad(picture, pixel).xyz);
    vec2 now = vec2(value, 0.0f);
    if (constants.weight < 1.0f) {
        vec2 before = imageLoad(moments, pixel).xy;
        float change = value - before.x;
        now.x = before.x + constants.weight * change;
        now.y = (1.0f - constants.weight) * (before.y + constants.weight * change * change);
    }
    imageStore(moments, pixel, vec4(now, 0.0f, 0.0f));
    imageStore(flicker, pixel, vec4(now.y / (now.x * now.x + 0.01f)));
}
