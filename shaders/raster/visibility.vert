// Vertices of Visibility: pulled by address, as SurfaceAt pulls them.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/projection.glsl"
#include "scene/bindings.glsl"

layout(set = 0, binding = 16, scalar) readonly buffer VisiblePlacements { uint at[]; } visiblePlacements;
layout(push_constant, scalar) uniform Constants { vec2 shift; } constants;

layout(location = 0) out vec2 barycentrics;
layout(location = 1) flat out uvec2 triangle;  // instance record, primitive

void main() {
    uint index = visiblePlacements.at[gl_InstanceIndex];
    mat4x3 objectToWorld = instances.at[index].objectToWorld;
    uint primitive = uint(gl_VertexIndex) / 3u;
    uint corner = uint(gl_VertexIndex) - 3u * primitive;
    // A face keeps its side under a mirroring transform: its corners are taken the other way round
    bool isMirrored = dot(cross(objectToWorld[0], objectToWorld[1]), objectToWorld[2]) < 0.0f;
    if (isMirrored && corner != 0u) corner = 3u - corner;
    uint vertex = UintStream(instances.at[index].indices).at[3u * primitive + corner];
    vec3 position = Vec3Stream(instances.at[index].positions).at[vertex];
    gl_Position =
        ClipPosition(parameters.value.camera, objectToWorld * vec4(position, 1.0f), constants.shift);
    barycentrics = vec2(corner == 1u ? 1.0f : 0.0f, corner == 2u ? 1.0f : 0.0f);
    triangle = uvec2(index, primitive);
}
