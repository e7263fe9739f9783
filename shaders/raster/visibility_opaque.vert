// Vertices of DrawBehindGlass: without surfaces of glass.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NO_TLAS
#include "scene/extensions.glsl"

#include "raster/projection.glsl"
#include "raster/triangle.glsl"
#include "scene/material_textures.glsl"

layout(set = 0, binding = 16, scalar) readonly buffer VisiblePlacements { uint at[]; } visiblePlacements;
layout(push_constant, scalar) uniform Constants { vec2 shift; } constants;

layout(location = 0) out vec2 barycentrics;
layout(location = 1) flat out uvec2 triangle;  // instance record, primitive

void main() {
    uint placement = visiblePlacements.at[gl_InstanceIndex];
    Corner corner = CornerOf(placement, uint(gl_VertexIndex));
    uint geometry = GeometryIndex(instances.at[placement], corner.primitive);
    bool isGlass = (materials.at[geometries.at[geometry].material].flags & kMaterialGlass) != 0u;
    gl_Position = ClipPosition(parameters.value.camera, corner.position, constants.shift);
    if (isGlass) gl_Position = vec4(2.0f, 2.0f, 2.0f, 1.0f);  // all three corners: nothing is drawn
    barycentrics = corner.barycentrics;
    triangle = uvec2(placement, corner.primitive);
}
