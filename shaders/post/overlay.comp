// Overlay: the finished part of a picture, and a coarser one elsewhere.
#version 460
#extension GL_EXT_shader_image_load_formatted : require
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) readonly uniform image2D coarse;
layout(set = 0, binding = 1) readonly uniform image2D fine;
layout(set = 0, binding = 2, rgba32f) writeonly uniform image2D picture;

// See TileCursor
layout(push_constant) uniform Constants {
    uint x;
    uint y;
    uint bandHeight;
} cursor;

vec4 CoarseAt(ivec2 pixel) { return imageLoad(coarse, clamp(pixel, ivec2(0), imageSize(coarse) - 1)); }

// Filters bilinearly in the shader, since not every device filters 32-bit floats.
vec4 UpscaledAt(ivec2 pixel) {
    vec2 place = (vec2(pixel) + 0.5f) * vec2(imageSize(coarse)) / vec2(imageSize(picture)) - 0.5f;
    ivec2 first = ivec2(floor(place));
    vec2 share = place - vec2(first);
    vec4 above = mix(CoarseAt(first), CoarseAt(first + ivec2(1, 0)), share.x);
    vec4 below = mix(CoarseAt(first + ivec2(0, 1)), CoarseAt(first + ivec2(1, 1)), share.x);
    return mix(above, below, share.y);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(picture)))) return;
    uvec2 at = uvec2(pixel);
    bool isDone = at.y < cursor.y || (at.y < cursor.y + cursor.bandHeight && at.x < cursor.x);
    imageStore(picture, pixel, isDone ? imageLoad(fine, pixel) : UpscaledAt(pixel));
}
