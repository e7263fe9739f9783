// Show: a picture's texels as they are, or decoded for a target that encodes.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "core/color.glsl"

layout(set = 0, binding = 0) uniform sampler2D picture;
layout(location = 0) out vec4 shown;

layout(push_constant) uniform Constants { uint isEncoding; } constants;

void main() {
    shown = texelFetch(picture, ivec2(gl_FragCoord.xy), 0);
    if (constants.isEncoding != 0u) shown.xyz = SrgbDecode(shown.xyz);
}
