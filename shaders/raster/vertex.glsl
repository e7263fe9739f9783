// Vertices of drawn triangles, fetched by address as in SurfaceAt.
#ifndef RAYGRAPH_RASTER_VERTEX_GLSL
#define RAYGRAPH_RASTER_VERTEX_GLSL

#include "scene/bindings.glsl"

struct Corner {
    vec3 position;  // world space
    vec2 barycentrics;
    uint primitive;
};

// Returns a corner of a triangle of a placement of a group: number `vertex`, with three for each triangle.
Corner CornerOf(uint placement, uint vertex) {
    mat4x3 objectToWorld = instances.at[placement].objectToWorld;
    Corner result;
    result.primitive = vertex / 3u;
    uint corner = vertex - 3u * result.primitive;
    // A face keeps its side under a mirroring transform: reverse the order of its vertices
    bool isMirrored = dot(cross(objectToWorld[0], objectToWorld[1]), objectToWorld[2]) < 0.0f;
    if (isMirrored && corner != 0u) corner = 3u - corner;
    uint index = UintStream(instances.at[placement].indices).at[3u * result.primitive + corner];
    vec3 position = Vec3Stream(instances.at[placement].positions).at[index];
    result.position = objectToWorld * vec4(position, 1.0f);
    result.barycentrics = vec2(corner == 1u ? 1.0f : 0.0f, corner == 2u ? 1.0f : 0.0f);
    return result;
}

#endif
