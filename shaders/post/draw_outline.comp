// DrawOutline: an outline of one color over a picture.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba8) readonly uniform image2D picture;
layout(set = 0, binding = 1, r32f) readonly uniform image2D line;
layout(set = 0, binding = 2, rgba8) writeonly uniform image2D display;

layout(push_constant) uniform Constants {
    vec4 color;
} constants;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(display)))) return;
    vec4 shown = imageLoad(picture, pixel);
    float share = imageLoad(line, pixel).x;
    // Alpha is not premultiplied
    float alpha = mix(shown.w, 1.0f, share);
    vec3 color = mix(shown.w * shown.xyz, constants.color.xyz, share);
    imageStore(display, pixel, vec4(alpha > 0.0f ? color / alpha : vec3(0.0f), alpha));
}
