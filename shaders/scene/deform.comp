// Deform: the vertices of the meshes whose joints have moved or whose morph weights have changed.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "core/deform.glsl"
#include "shared/deform_records.h"

layout(local_size_x = 64) in;  // kDeformGroupSize

layout(set = 0, binding = 0, scalar) readonly buffer DeformRecords { DeformRecord at[]; } deformRecords;
layout(set = 0, binding = 1, scalar) readonly buffer DeformTasks { DeformTask at[]; } deformTasks;
layout(set = 0, binding = 2, scalar) readonly buffer JointMatrices { mat4x3 at[]; } jointMatrices;
layout(set = 0, binding = 3, scalar) readonly buffer MorphWeights { float at[]; } morphWeights;
layout(push_constant, scalar) uniform Constants { uint taskCount; uint groupCount; } constants;

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer UintStream { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer FloatStream { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vec3Stream { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vec4Stream { vec4 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer TargetStream {
    DeformTarget at[];
};
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Vec3Result { vec3 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Vec4Result { vec4 at[]; };

bool IsPresent(uvec2 address) { return (address.x | address.y) != 0u; }

vec3 DisplacementAt(uvec2 stream, uint vertex) {
    return IsPresent(stream) ? Vec3Stream(stream).at[vertex] : vec3(0.0f);
}

ShapedVertex BaseAt(DeformRecord record, uint vertex) {
    ShapedVertex base;
    base.position = Vec3Stream(record.positions).at[vertex];
    base.normal = IsPresent(record.normals) ? Vec3Stream(record.normals).at[vertex] : vec3(0.0f);
    base.tangent = IsPresent(record.tangents) ? Vec4Stream(record.tangents).at[vertex] : vec4(0.0f);
    return base;
}

mat4x3 JointsOf(DeformRecord record, uint vertex) {
    mat4x3 sum = mat4x3(0.0f);
    uint end = record.perVertex * (vertex + 1u);
    for (uint i = record.perVertex * vertex; i < end; ++i) {
        float weight = FloatStream(record.weights).at[i];
        if (weight == 0.0f) continue;
        uint joint = (UintStream(record.joints).at[i / 2u] >> (16u * (i & 1u))) & 0xFFFFu;
        sum += weight * jointMatrices.at[record.firstMatrix + joint];
    }
    return sum;
}

// A position that is beyond the numbers stays where the base shape has it: a triangle of a structure that is
// updated must not become inactive.
ShapedVertex DeformedAt(DeformRecord record, uint vertex) {
    ShapedVertex base = BaseAt(record, vertex);
    ShapedVertex moved = base;
    if (record.targetCount > 0u) {
        TargetStream targets = TargetStream(record.targets);
        for (uint i = 0u; i < record.targetCount; ++i) {
            float weight = morphWeights.at[record.firstWeight + i];
            if (weight == 0.0f) continue;
            AddMorphTarget(moved, weight, DisplacementAt(targets.at[i].positions, vertex),
                      DisplacementAt(targets.at[i].normals, vertex),
                      DisplacementAt(targets.at[i].tangents, vertex));
        }
        moved = NormalizeMorphed(moved, base);
    }
    if (record.perVertex > 0u) moved = ApplySkinning(JointsOf(record, vertex), moved);
    if (!IsFinite(moved.position)) moved.position = base.position;
    return moved;
}

// Returns the task that has this workgroup.
uint TaskOf(uint group) {
    uint low = 0u, high = constants.taskCount;
    while (high - low > 1u) {
        uint middle = (low + high) / 2u;
        if (deformTasks.at[middle].firstGroup <= group)
            low = middle;
        else
            high = middle;
    }
    return low;
}

void main() {
    uint group = gl_WorkGroupID.y * kDeformRowGroups + gl_WorkGroupID.x;
    if (group >= constants.groupCount) return;
    DeformTask task = deformTasks.at[TaskOf(group)];
    DeformRecord record = deformRecords.at[task.record];
    uint vertex = (group - task.firstGroup) * kDeformGroupSize + gl_LocalInvocationIndex;
    if (vertex >= record.vertexCount) return;

    ShapedVertex moved;
    if (record.isFlat != 0u) {
        uint corner = vertex % 3u;
        vec3 corners[3];
        [[unroll]] for (uint i = 0u; i < 3u; ++i) {
            ShapedVertex at = DeformedAt(record, vertex - corner + i);
            if (i == corner) moved = at;
            corners[i] = at.position;
        }
        moved.normal = FlatNormal(corners[0], corners[1], corners[2]);
    } else {
        moved = DeformedAt(record, vertex);
    }
    // Targets displace normals and tangents each by themselves, and flat normals follow the positions
    if (record.targetCount > 0u || record.isFlat != 0u)
        moved.tangent = TangentInPlane(moved.tangent, moved.normal);
    Vec3Result(record.deformedPositions).at[vertex] = moved.position;
    if (IsPresent(record.deformedNormals)) Vec3Result(record.deformedNormals).at[vertex] = moved.normal;
    if (IsPresent(record.deformedTangents)) Vec4Result(record.deformedTangents).at[vertex] = moved.tangent;
}
