// Show: a picture at the target's size, decoded for a target that encodes.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "core/color.glsl"

layout(set = 0, binding = 0) uniform sampler2D picture;
layout(location = 0) out vec4 shown;

layout(push_constant) uniform Constants {
    vec2 size;  // size of the target
    uint isEncoding;
} constants;

void main() {
    shown = textureLod(picture, gl_FragCoord.xy / constants.size, 0.0f);
    if (constants.isEncoding != 0u) shown.xyz = SrgbDecode(shown.xyz);
}
