// Computes a convolution of 3 x 3 pixels (of one with POINT; with STRIDED, the result has half the size of
// its source), of four pixels of a row and eight channels in each invocation. Borders are repeated. Sources
// are one after the other: the second one has the size of the result, the first one may have half of it and
// is then doubled.
#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef LANES
#extension GL_KHR_shader_subgroup_ballot : require
#endif
layout(local_size_x = 8, local_size_y = 8) in;

#include "denoise/network/network.glsl"

#if !defined(STRIDED) && !defined(POINT)
#define HAS_SKIP
#endif
#ifdef STRIDED
const int kStride = 2;
#else
const int kStride = 1;
#endif
const int kPixels = 4;  // of an invocation
#ifdef POINT
const int kRows = 1, kColumns = kPixels;
#else
const int kRows = 3, kColumns = (kPixels - 1) * kStride + 3;
#endif

layout(set = 0, binding = 0) readonly buffer Source { uvec2 at[]; } source;
#ifdef HAS_SKIP
layout(set = 0, binding = 1) readonly buffer Skip { uvec2 at[]; } skip;
#endif
#ifdef LANES
layout(set = 0, binding = 2) readonly buffer Weights { float at[]; } weights;
#else
layout(set = 0, binding = 2) readonly buffer Weights { vec4 at[]; } weights;
#endif
layout(set = 0, binding = 3) writeonly buffer Result { uvec2 at[]; } result;

layout(push_constant) uniform Constants {
    ivec2 size, sourceSize;
    uint sourceBlocks, skipBlocks;
    uint firstWeight;  // in eight floats, of the layer
    uint doubling;     // 1 if the source is doubled
    float slope;       // of negative results
} constants;

vec4 sums[2 * kPixels];  // of pixels, four channels each, then the other four channels
vec4 columns[kColumns];

// WEIGHTS sets `low` and `high` to the weights of eight results. With LANES, eight neighboring lanes load
// one each and hand them to the others: CPU drivers load in loops lane by lane, even where all lanes load
// the same.
#ifdef LANES
#define WEIGHTS(i)                                                                                       \
    float own = weights.at[8 * (at + i) + lane];                                                         \
    vec4 low = vec4(subgroupBroadcast(own, 0u), subgroupBroadcast(own, 1u), subgroupBroadcast(own, 2u),  \
                    subgroupBroadcast(own, 3u)),                                                         \
         high = vec4(subgroupBroadcast(own, 4u), subgroupBroadcast(own, 5u), subgroupBroadcast(own, 6u), \
                     subgroupBroadcast(own, 7u));
#else
#define WEIGHTS(i) vec4 low = weights.at[2 * (at + i)], high = weights.at[2 * (at + i) + 1];
#endif

#define MULTIPLY(c, i)          \
    {                           \
        WEIGHTS(i)              \
        sums[0] += p0.c * low;  \
        sums[1] += p1.c * low;  \
        sums[2] += p2.c * low;  \
        sums[3] += p3.c * low;  \
        sums[4] += p0.c * high; \
        sums[5] += p1.c * high; \
        sums[6] += p2.c * high; \
        sums[7] += p3.c * high; \
    }
#define TAP(k)                                                                          \
    {                                                                                   \
        vec4 p0 = columns[k], p1 = columns[kStride + k], p2 = columns[2 * kStride + k], \
             p3 = columns[3 * kStride + k];                                             \
        MULTIPLY(x, 0)                                                                  \
        MULTIPLY(y, 1)                                                                  \
        MULTIPLY(z, 2)                                                                  \
        MULTIPLY(w, 3)                                                                  \
        at += 4;                                                                        \
    }
#ifdef POINT
#define TAPS TAP(0)
#else
#define TAPS TAP(0) TAP(1) TAP(2)
#endif

#define ADD(buffer_, blocks, bufferSize, shift)                                                         \
    for (int block = 0; block < int(blocks); ++block)                                                   \
        for (int row = 0; row < kRows; ++row) {                                                         \
            int y = clamp(first.y + row, 0, (bufferSize.y << shift) - 1) >> shift;                      \
            int begin = (block * bufferSize.y + y) * bufferSize.x;                                      \
            for (int i = 0; i < kColumns; ++i)                                                          \
                columns[i] = UnpackHalves(                                                              \
                    buffer_.at[begin + (clamp(first.x + i, 0, (bufferSize.x << shift) - 1) >> shift)]); \
            TAPS                                                                                        \
        }

void main() {
    ivec2 pixel = ivec2(kPixels * int(gl_GlobalInvocationID.x), int(gl_GlobalInvocationID.y));
    int group = int(gl_WorkGroupID.z);
#ifdef LANES
    int lane = int(gl_SubgroupInvocationID & 7u);
#endif
    ivec2 size = constants.size;
#ifndef LANES  // which needs all of them
    if (pixel.x >= size.x || pixel.y >= size.y) return;
#endif
    int blocks = int(constants.sourceBlocks + constants.skipBlocks);
    int at = int(constants.firstWeight) + group * (1 + 4 * blocks * kRows * kRows);
    {
        WEIGHTS(0)
        for (int i = 0; i < kPixels; ++i) {
            sums[i] = low;
            sums[i + kPixels] = high;
        }
    }
    at += 1;
    ivec2 first = kStride * pixel - kRows / 2;
    ADD(source, constants.sourceBlocks, constants.sourceSize, int(constants.doubling))
#ifdef HAS_SKIP
    ADD(skip, constants.skipBlocks, size, 0)
#endif
    for (int i = 0; i < kPixels; ++i) {
        if (pixel.x + i >= size.x || pixel.y >= size.y) break;
        int to = (2 * group * size.y + pixel.y) * size.x + pixel.x + i;
        vec4 low = sums[i], high = sums[i + kPixels];
        result.at[to] = PackHalves(max(low, constants.slope * low));
        result.at[to + size.x * size.y] = PackHalves(max(high, constants.slope * high));
    }
}
