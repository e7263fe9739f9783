// Tonemap: radiance to display values, in a region of the display. Radiance of another extent is scaled, each
// pixel from the texel that it lies in.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require
#include "core/tonemap.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) uniform sampler2D radiance;
layout(set = 0, binding = 1, rgba8) uniform image2D display;

layout(push_constant, scalar) uniform Constants {
    uvec2 offset;  // position of the region
    uvec2 size;
    float exposureEv;
    uint tonemapOperator;
    uint flags;
    vec4 whiteBalance[3];  // columns
} constants;

const uint kOpaque = 1u, kUnassociated = 2u, kBalanced = 4u;

vec3 Balanced(vec3 color) {
    vec4 columns[3] = constants.whiteBalance;
    return mat3(columns[0].xyz, columns[1].xyz, columns[2].xyz) * color;
}

void main() {
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, constants.size))) return;
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy + constants.offset);
    vec4 value = texelFetch(radiance, pixel * textureSize(radiance, 0) / imageSize(display), 0);
    vec3 color = value.xyz;
    if ((constants.flags & kUnassociated) != 0u) color = value.w > 0.0f ? color / value.w : vec3(0.0f);
    if ((constants.flags & kBalanced) != 0u) color = Balanced(color);
    vec3 shown = Tonemap(color, constants.exposureEv, constants.tonemapOperator);
    float alpha = (constants.flags & kOpaque) != 0u ? 1.0f : clamp(value.w, 0.0f, 1.0f);
    imageStore(display, pixel, vec4(shown, alpha));
}
