// ReduceBlocks computes the sum and the maximum of each block of 16 x 16 pixels. One invocation reads a whole
// block, always in the same order.
#version 460
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, r32f) readonly uniform image2D values;
layout(set = 0, binding = 1, scalar) writeonly buffer Blocks { vec2 at[]; } blocks;

const int kBlock = 16;

void main() {
    ivec2 size = imageSize(values);
    ivec2 counts = (size + kBlock - 1) / kBlock;
    ivec2 block = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(block, counts))) return;
    float sum = 0.0f, maximum = 0.0f;
    ivec2 first = block * kBlock, end = min(first + kBlock, size);
    for (int y = first.y; y < end.y; ++y)
        for (int x = first.x; x < end.x; ++x) {
            float value = imageLoad(values, ivec2(x, y)).x;
            sum += value;
            maximum = max(maximum, value);
        }
    blocks.at[block.y * counts.x + block.x] = vec2(sum, maximum);
}
