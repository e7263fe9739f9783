// Pixels of DrawUi: the vertex's color times the font atlas (source 0), the picture (1) or the thumbnails
// (2).
#version 460

layout(set = 0, binding = 1) uniform sampler2D atlas;
layout(set = 0, binding = 2) uniform sampler2D picture;
layout(set = 0, binding = 3) uniform sampler2D thumbnails;

layout(location = 0) in vec2 uv;
layout(location = 1) in vec4 color;
layout(location = 2) flat in uint source;

layout(location = 0) out vec4 target;

void main() {
    vec4 texel = source == 0u   ? textureLod(atlas, uv, 0.0f)
                 : source == 1u ? textureLod(picture, uv, 0.0f)
                                : textureLod(thumbnails, uv, 0.0f);
    target = color * texel;
}
