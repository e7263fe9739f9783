// SumGroups: sum and greatest value of each block of 16 x 16 pixels.
#version 460
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 16, local_size_y = 16) in;

layout(set = 0, binding = 0, r32f) readonly uniform image2D values;
layout(set = 0, binding = 1, scalar) writeonly buffer Groups { vec2 at[]; } groups;

const uint kCount = 256u;
shared vec2 partial[kCount];

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    uint lane = gl_LocalInvocationIndex;
    bool isInside = all(lessThan(pixel, imageSize(values)));
    partial[lane] = isInside ? vec2(imageLoad(values, pixel).x) : vec2(0.0f);
    for (uint step = kCount / 2u; step > 0u; step /= 2u) {
        barrier();
        if (lane < step) {
            vec2 a = partial[lane], b = partial[lane + step];
            partial[lane] = vec2(a.x + b.x, max(a.y, b.y));
        }
    }
    if (lane == 0u) groups.at[gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x] = partial[0];
}
