// A triangle in the picture, and the pixels that it covers. Nothing is clipped: edges are compared in
// homogeneous coordinates (Olano and Greer, Triangle Scan Conversion using 2D Homogeneous Coordinates, 1997),
// relative to each pixel's center (Woop, Benthin and Wald, Watertight Ray/Triangle Intersection, 2013).
// Triangles that share an edge compute it from the same numbers by the same operations except for the sign,
// so no pixel falls between them; `precise` keeps the compiler from changing that.
#ifndef RAYGRAPH_RASTER_TRIANGLE_GLSL
#define RAYGRAPH_RASTER_TRIANGLE_GLSL

#include "raster/projection.glsl"
#include "scene/bindings.glsl"

// Vertices in clip space, with x and y in pixels, times w.
struct PictureTriangle {
    vec4 corners[3];
    bool isMirrored;  // its placement mirrors it: it keeps its sides
};

mat4 OffsetToPicture(CameraRecord camera, vec2 shift, uvec2 size) {
    vec2 scale = 0.5f * vec2(size);
    precise mat4 result = mat4(scale.x, 0.0f, 0.0f, 0.0f,  //
                               0.0f, scale.y, 0.0f, 0.0f,  //
                               0.0f, 0.0f, 1.0f, 0.0f,     //
                               scale.x, scale.y, 0.0f, 1.0f) *
                          OffsetToClip(camera, shift);
    return result;
}

PictureTriangle ProjectTriangle(uint placement, uint primitive, vec3 origin, mat4 offsetToPicture) {
    mat4x3 objectToWorld = instances.at[placement].objectToWorld;
    UintStream indices = UintStream(instances.at[placement].indices);
    Vec3Stream positions = Vec3Stream(instances.at[placement].positions);
    PictureTriangle triangle;
    triangle.isMirrored = dot(cross(objectToWorld[0], objectToWorld[1]), objectToWorld[2]) < 0.0f;
    for (uint i = 0u; i < 3u; ++i) {
        vec3 at = positions.at[indices.at[3u * primitive + i]];
        precise vec3 offset = objectToWorld[0] * at.x + objectToWorld[1] * at.y + objectToWorld[2] * at.z +
                              (objectToWorld[3] - origin);
        precise vec4 corner = offsetToPicture[0] * offset.x + offsetToPicture[1] * offset.y +
                              offsetToPicture[2] * offset.z + offsetToPicture[3];
        triangle.corners[i] = corner;
    }
    return triangle;
}

// Proportional to the barycentrics where the line of sight through `place` (pixels) meets the triangle's
// plane: all of one sign inside, negative on the front face.
vec3 EdgesAt(PictureTriangle triangle, vec2 place) {
    precise vec2 a = triangle.corners[0].xy - place * triangle.corners[0].w;
    precise vec2 b = triangle.corners[1].xy - place * triangle.corners[1].w;
    precise vec2 c = triangle.corners[2].xy - place * triangle.corners[2].w;
    precise vec3 edges = vec3(b.x * c.y - b.y * c.x, c.x * a.y - c.y * a.x, a.x * b.y - a.y * b.x);
    return triangle.isMirrored ? -edges : edges;
}

// Returns whether the triangle covers the pixel's center: its unnormalized barycentrics there, and the depth.
bool CoversPixelCenter(PictureTriangle triangle, vec2 place, bool isCulled, out vec3 edges, out float depth) {
    edges = EdgesAt(triangle, place);
    float minimum = min(min(edges.x, edges.y), edges.z), maximum = max(max(edges.x, edges.y), edges.z);
    depth = 0.0f;
    if (maximum > 0.0f && (minimum < 0.0f || isCulled)) return false;
    float w = dot(edges, vec3(triangle.corners[0].w, triangle.corners[1].w, triangle.corners[2].w));
    if (w == 0.0f) return false;
    depth = dot(edges, vec3(triangle.corners[0].z, triangle.corners[1].z, triangle.corners[2].z)) / w;
    return depth > 0.0f && depth <= 1.0f;
}

vec2 BarycentricsOf(vec3 edges) { return edges.yz / (edges.x + edges.y + edges.z); }

// Returns whether it is back-facing, from everywhere in the picture; evaluated near to it.
bool IsBackFacing(PictureTriangle triangle, vec2 place) {
    return dot(EdgesAt(triangle, place),
               vec3(triangle.corners[0].w, triangle.corners[1].w, triangle.corners[2].w)) > 0.0f;
}

// The pixels whose centers the triangle may cover, from `low` to before `high`.
void BoundsOf(PictureTriangle triangle, uvec2 size, out ivec2 low, out ivec2 high) {
    vec2 minimum = vec2(size) + 1.0f, maximum = vec2(-1.0f);
    for (uint i = 0u; i < 3u; ++i) {
        vec4 from = triangle.corners[i], to = triangle.corners[i < 2u ? i + 1u : 0u];
        float inFront = from.w - from.z;  // what is nearer than zNear has less than 0
        float inFrontTo = to.w - to.z;
        if (inFront >= 0.0f) {
            minimum = min(minimum, from.xy / from.w);
            maximum = max(maximum, from.xy / from.w);
        }
        if ((inFront < 0.0f) != (inFrontTo < 0.0f)) {
            vec4 cut = mix(from, to, inFront / (inFront - inFrontTo));
            minimum = min(minimum, cut.xy / cut.w);
            maximum = max(maximum, cut.xy / cut.w);
        }
    }
    const float kMargin = 0.01f;  // above the rounding of a position in the picture
    low = ivec2(ceil(clamp(minimum - 0.5f - kMargin, vec2(0.0f), vec2(size))));
    high = ivec2(floor(clamp(maximum - 0.5f + kMargin, vec2(-1.0f), vec2(size) - 1.0f))) + 1;
}

// Returns false if the triangle covers no point of the rectangle [low, high]. Edges are linear in the
// position, so that their signs at the corners bound those inside.
bool OverlapsRectangle(PictureTriangle triangle, vec2 low, vec2 high, bool isCulled) {
    vec3 e0 = EdgesAt(triangle, low), e1 = EdgesAt(triangle, high);
    vec3 e2 = EdgesAt(triangle, vec2(low.x, high.y)), e3 = EdgesAt(triangle, vec2(high.x, low.y));
    vec3 minimum = min(min(e0, e1), min(e2, e3)), maximum = max(max(e0, e1), max(e2, e3));
    bool isFront = all(lessThanEqual(minimum, vec3(0.0f)));
    bool isBack = all(greaterThanEqual(maximum, vec3(0.0f)));
    return isFront || (isBack && !isCulled);
}

// --- Vertices of drawn triangles, fetched by address as in SurfaceAt ---

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
