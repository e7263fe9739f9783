// SideBySide: two pictures of half the size, each in the middle of its half; gray around them.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba8) readonly uniform image2D left;
layout(set = 0, binding = 1, rgba8) readonly uniform image2D right;
layout(set = 0, binding = 2, rgba8) writeonly uniform image2D display;

vec4 At(bool isRight, ivec2 pixel, ivec2 size) {
    pixel = min(pixel, size - 1);
    return isRight ? imageLoad(right, pixel) : imageLoad(left, pixel);
}

void main() {
    ivec2 size = imageSize(display);
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, size))) return;
    int middle = (size.x + 1) / 2;
    bool isRight = pixel.x >= middle;
    ivec2 place = ivec2(isRight ? pixel.x - middle : pixel.x, pixel.y - size.y / 4);
    vec4 shown = vec4(0.1f, 0.1f, 0.1f, 1.0f);
    if (place.y >= 0 && 2 * place.y < size.y) {
        ivec2 first = 2 * place;
        shown = 0.25f * (At(isRight, first, size) + At(isRight, first + ivec2(1, 0), size) +
                         At(isRight, first + ivec2(0, 1), size) + At(isRight, first + ivec2(1, 1), size));
    }
    imageStore(display, pixel, shown);
}
