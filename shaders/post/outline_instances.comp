// OutlineInstances: coverage of each pixel by an outline around the visible part of some instances.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, rgba32ui) readonly uniform uimage2D hits;  // raster/visibility.glsl
layout(set = 0, binding = 1, std430) readonly buffer Outlined {
    uint bits[];  // one for each instance
} outlined;
layout(set = 0, binding = 2, r32f) writeonly uniform image2D line;

layout(push_constant) uniform Constants {
    float width;  // pixels
} constants;

bool IsOutlined(ivec2 pixel, ivec2 size) {
    ivec2 from = imageSize(hits);
    // The texel that the pixel's center lies in
    ivec2 texel = (2 * pixel + 1) * from / (2 * size);
    uint seen = imageLoad(hits, clamp(texel, ivec2(0), from - 1)).x;
    if (seen == 0u) return false;
    uint instance = seen - 1u;
    uint word = instance / 32u;
    return word < uint(outlined.bits.length()) && (outlined.bits[word] >> (instance % 32u) & 1u) != 0u;
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = imageSize(line);
    if (any(greaterThanEqual(pixel, size))) return;
    float share = 0.0f;
    if (!IsOutlined(pixel, size)) {
        int reach = int(ceil(constants.width));
        float nearest = 1e9f;  // squared, to a pixel within
        for (int y = -reach; y <= reach; ++y)
            for (int x = -reach; x <= reach; ++x) {
                ivec2 other = pixel + ivec2(x, y);
                float apart = float(x * x + y * y);
                if (apart >= nearest || any(lessThan(other, ivec2(0))) || any(greaterThanEqual(other, size)))
                    continue;
                if (IsOutlined(other, size)) nearest = apart;
            }
        // The outlined part ends half a pixel before the center of the next
        share = clamp(constants.width + 1.0f - sqrt(nearest), 0.0f, 1.0f);
    }
    imageStore(line, pixel, vec4(share));
}
