// Texels of surfaces, and distances between surfaces, for the passes of passes/real_time.h.
#ifndef RAYGRAPH_REAL_TIME_SURFACE_GLSL
#define RAYGRAPH_REAL_TIME_SURFACE_GLSL

// A texel holds the normal in the octahedron (Cigolle et al. 2014, "A Survey of Efficient Representations for
// Independent Unit Vectors"), the depth along the camera's forward axis in meters, and the surface's number:
// 0 where no surface was hit, -1 where nothing has been written.
struct Surface {
    vec3 normal;
    float depth;
    float number;
};

vec2 SignNotZero(vec2 v) { return vec2(v.x < 0.0f ? -1.0f : 1.0f, v.y < 0.0f ? -1.0f : 1.0f); }

vec2 ToOctahedron(vec3 n) {
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    return n.z < 0.0f ? (1.0f - abs(p.yx)) * SignNotZero(p) : p;
}

vec3 FromOctahedron(vec2 p) {
    vec3 n = vec3(p, 1.0f - abs(p.x) - abs(p.y));
    if (n.z < 0.0f) n.xy = (1.0f - abs(n.yx)) * SignNotZero(n.xy);
    return normalize(n);
}

vec4 PackSurface(Surface surface) {
    return vec4(ToOctahedron(surface.normal), surface.depth, surface.number);
}

Surface UnpackSurface(vec4 texel) {
    Surface surface;
    surface.normal = FromOctahedron(texel.xy);
    surface.depth = texel.z;
    surface.number = texel.w;
    return surface;
}

// Film holds the frame of a camera and the size of its picture.
struct Film {
    vec3 right;  // those of CameraRecord
    vec3 up;
    vec3 forward;
    uint orthographic;
    vec2 size;  // pixels
};

// The position of a point relative to the camera, from its place in the picture (pixels) and its depth.
vec3 OffsetAt(Film film, vec2 place, float depth) {
    vec2 at = 2.0f * place / film.size - 1.0f;
    float scale = film.orthographic != 0u ? 1.0f : depth;
    return depth * film.forward + scale * (at.x * film.right - at.y * film.up);
}

// The width in meters of what a pixel sees at a depth.
float FootprintAt(Film film, float depth) {
    float width = 2.0f * length(film.up) / film.size.y;
    return film.orthographic != 0u ? width : width * depth;
}

bool IsInside(ivec2 pixel, ivec2 size) {
    return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(pixel, size));
}

// An entry that is infinite or NaN counts as 0.
vec3 FiniteOr0(vec3 value) {
    bvec3 isFinite = lessThanEqual(abs(value), vec3(3.4e38f));  // false for NaN
    return mix(vec3(0.0f), value, isFinite);
}

#endif
