// Texels of surfaces and of halves, and distances between surfaces, for the passes of passes/real_time.h.
#ifndef RAYGRAPH_REAL_TIME_SURFACE_GLSL
#define RAYGRAPH_REAL_TIME_SURFACE_GLSL

#include "post/pixels.glsl"
#include "shared/mix_bits.h"
#include "shared/real_time.h"

const uint kNothingWritten = 0u;  // numbers that no surface has
const uint kNothingHit = 1u;
const uint kFirstNumber = 2u;
const uint kNumbers = 2039u;  // the largest prime with kFirstNumber + 2 * kNumbers <= 4096
// Surfaces that mirrors or clear glass show have numbers from here on. Their depth is the length of the path
// to them, as if that went straight on.
const uint kFirstShownNumber = kFirstNumber + kNumbers;
const float kFarAway = 1e5f;  // length of a path to the environment

struct Surface {
    vec3 normal;
    float depth;  // along the camera's forward axis, in meters
    uint number;
};

bool IsShown(uint number) { return number >= kFirstShownNumber; }

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

// A texel holds the bits of the depth, and from the top 2 x 10 bits of the normal in the octahedron (Cigolle
// et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors") and 12 of the number.
uvec2 PackSurface(Surface surface) {
    uvec2 normal = uvec2(round(511.0f * ToOctahedron(surface.normal)) + 512.0f);
    return uvec2(floatBitsToUint(surface.depth), normal.x << 22 | normal.y << 12 | surface.number);
}

vec3 NormalOf(uvec2 texel) {
    return FromOctahedron((vec2(texel.y >> 22, texel.y >> 12 & 0x3FFu) - 512.0f) / 511.0f);
}
float DepthOf(uvec2 texel) { return uintBitsToFloat(texel.x); }
uint NumberOf(uvec2 texel) { return texel.y & 0xFFFu; }

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

// Returns the pixels to where a surface was in the frame before. Less than a hundredth of a pixel is
// rounding, which must not blur what stands still.
vec2 ShiftOf(vec4 motion) { return dot(motion.xy, motion.xy) < 1e-4f ? vec2(0.0f) : motion.xy; }

// --- Light over albedo ---

const float kMostHalf = 65504.0f;

// Radiance is divided by this and multiplied by it later: an albedo of 0, as of lamps, would lose it.
vec3 DivisorOf(vec4 albedo) { return max(albedo.xyz, vec3(0.01f)); }

vec3 LightOf(vec4 radiance, vec4 albedo) {
    return min(FiniteOr0(radiance.xyz) / DivisorOf(albedo), vec3(kMostHalf));
}

// --- Halves ---

const uint kToNearest = 0x1000u;

// Rounds to what a plane of halves can hold, since devices round differently when they store. `bits`, below
// 2^13, says which of both neighbors is taken: kToNearest, or random ones, with which the mean of many
// roundings is the value itself.
vec4 ToHalf(vec4 value, uint bits) {
    value = clamp(value, -kMostHalf, kMostHalf);
    return uintBitsToFloat((floatBitsToUint(value) + bits) & ~0x1FFFu);
}

// Random bits for ToHalf. A mean to which each frame adds little would not follow it if rounded to nearest.
uint RandomBits(ivec2 pixel, uint frame) {
    return MixBits(uint(pixel.x) ^ MixBits(uint(pixel.y) ^ MixBits(frame))) >> 19;
}

#endif
