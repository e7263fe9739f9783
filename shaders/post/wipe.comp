// Wipe: one picture left of a line, another right of it.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba8) readonly uniform image2D left;
layout(set = 0, binding = 1, rgba8) readonly uniform image2D right;
layout(set = 0, binding = 2, rgba8) writeonly uniform image2D display;

layout(push_constant) uniform Constants {
    int column;     // the first of the right picture
    int lineWidth;  // columns of the line from there on
} constants;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(display)))) return;
    vec4 shown = pixel.x < constants.column ? imageLoad(left, pixel) : imageLoad(right, pixel);
    bool isLine = pixel.x >= constants.column && pixel.x < constants.column + constants.lineWidth;
    imageStore(display, pixel, isLine ? vec4(1.0f, 0.75f, 0.2f, 1.0f) : shown);
}
