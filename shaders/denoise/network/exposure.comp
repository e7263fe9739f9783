// Finds the factor that brings a picture to the exposure that the network knows: the squared ratio of the
// sums of sqrt(L) and of L. Pixels without light have no part in it.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 64) in;

layout(set = 0, binding = 0, rg32f) readonly uniform image2D sums;
layout(set = 0, binding = 1, r32f) writeonly uniform image2D exposure;

shared vec2 partial[64];

void main() {
    ivec2 size = imageSize(sums);
    uint own = gl_LocalInvocationIndex;
    vec2 sum = vec2(0.0f);
    for (int i = int(own); i < size.x * size.y; i += 64)
        sum += imageLoad(sums, ivec2(i % size.x, i / size.x)).xy;
    partial[own] = sum;
    barrier();
    if (own != 0u) return;
    for (int i = 1; i < 64; ++i) sum += partial[i];
    float ratio = sum.x > 0.0f ? sum.y / sum.x : 1.0f;
    imageStore(exposure, ivec2(0), vec4(ratio * ratio));
}
