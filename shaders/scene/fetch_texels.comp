// Fetches the texels of a level of a texture of the scene, or of the environment map, as shaders see them:
// decoded, in linear values.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "scene/bindings.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 16, scalar) writeonly buffer Texels { vec4 at[]; } texels;

layout(push_constant, scalar) uniform Constants {
    uint slot;  // kNoTexture: the environment map
    int level;
    uvec2 size;  // of the level
} constants;

void main() {
    uvec2 texel = gl_GlobalInvocationID.xy;
    if (texel.x >= constants.size.x || texel.y >= constants.size.y) return;
    vec4 value = constants.slot == kNoTexture
                     ? texelFetch(environmentMap, ivec2(texel), constants.level)
                     : texelFetch(textures[constants.slot], ivec2(texel), constants.level);
    texels.at[texel.y * constants.size.x + texel.x] = value;
}
