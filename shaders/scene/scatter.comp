// Scatter: puts records that have changed into their places in a table. A workgroup copies as many records
// as it has invocations, word by word, so that neighboring invocations read neighboring words.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

layout(local_size_x = 128) in;

// The places of all records, then the records.
layout(set = 0, binding = 0, scalar) readonly buffer Scattered { uint at[]; } scattered;
layout(set = 0, binding = 1, scalar) buffer Table { uint at[]; } table;
layout(push_constant, scalar) uniform Constants { uint count; uint words; } constants;

void main() {
    uint first = gl_WorkGroupID.x * gl_WorkGroupSize.x;
    uint end = min(gl_WorkGroupSize.x, constants.count - first) * constants.words;
    for (uint i = gl_LocalInvocationIndex; i < end; i += gl_WorkGroupSize.x) {
        uint record = first + i / constants.words;
        uint word = i % constants.words;
        table.at[scattered.at[record] * constants.words + word] =
            scattered.at[constants.count + record * constants.words + word];
    }
}
