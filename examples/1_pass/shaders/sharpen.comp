#version 460
#extension GL_GOOGLE_include_directive : require
#include "core/color.glsl"   // of Raygraph: Luminance

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, rgba32f) readonly uniform image2D picture;
layout(set = 0, binding = 1, rgba32f) writeonly uniform image2D sharpened;
layout(push_constant) uniform Constants { float amount; } constants;

// Beyond the edge, the picture goes on as it ends.
float LuminanceAt(ivec2 pixel) {
    return Luminance(imageLoad(picture, clamp(pixel, ivec2(0), imageSize(picture) - 1)).rgb);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(picture)))) return;
    float around = 0.25 * (LuminanceAt(pixel + ivec2(1, 0)) + LuminanceAt(pixel - ivec2(1, 0)) +
                           LuminanceAt(pixel + ivec2(0, 1)) + LuminanceAt(pixel - ivec2(0, 1)));
    vec4 color = imageLoad(picture, pixel);
    float sharper = max(Luminance(color.rgb) + constants.amount * (Luminance(color.rgb) - around), 0.0);
    imageStore(sharpened, pixel, vec4(color.rgb * sharper / max(Luminance(color.rgb), 1e-6), color.a));
}
