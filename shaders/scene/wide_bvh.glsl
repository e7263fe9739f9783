// Traversal of the compressed wide tree of shared/wide_bvh.h, over placed meshes. In the common subset of
// GLSL and C++ (core/glue.h): the tests run this text on the CPU. Ylitie, Karras and Laine 2017, section 4;
// triangles as by Woop, Benthin and Wald 2013, "Watertight Ray/Triangle Intersection".
//
// Bridge: whoever includes this declares, before it,
//     uvec4 WideNodeWord(uint at), WideTriangleWord(uint at), WideInstanceWord(uint at)   16 bytes each
//     void PushGroup(uint at, uvec2 group), uvec2 GroupAt(uint at)                    kWideStackSize of them
//     bool IsAccepted(WideHit hit, bool isBack, bool isAny)     whether a triangle of a kWideTested instance
//                                                               is hit; asked once for each on the ray
//
// No ray passes between two triangles that share an edge. So nothing below may be rounded in one place as
// it is not in another: expressions that are PRECISE are not contracted.
//
// A group is (x) the first of some nodes or primitives and (y) which of them are still to come. Of nodes: a
// bit for each from bit 24 on, in the order of the ray's octant, the highest first, and in the lowest byte
// which slots are nodes. Of primitives: a bit for each below bit 24.
#ifndef RAYGRAPH_SCENE_WIDE_BVH_GLSL
#define RAYGRAPH_SCENE_WIDE_BVH_GLSL

#include "core/glue.h"
#include "shared/wide_bvh.h"

#ifdef __cplusplus
namespace raygraph::shading {
using glm::bitCount;
using glm::findMSB;
using gpu::WideCounts;
using gpu::WideHit;
using gpu::kWideBackCulled;
using gpu::kWideInstanceWords;
using gpu::kWideMirrored;
using gpu::kWideNodeWords;
using gpu::kWideNoInstance;
using gpu::kWideTested;
using gpu::kWideTriangleWords;
}  // namespace raygraph::shading
#define WIDE_UNROLL
#define PRECISE
#else
#define WIDE_UNROLL [[unroll]]
#define PRECISE precise
#endif

SHADING_BEGIN

CONST uint kLowestNodeBit = 0x01000000u;
CONST float kMinDirection = 1e-20f;  // limit of a component: its inverse is finite
CONST float kFarSlack = 1.000001f;      // more than the roundings of the distance of a side of a box

// Describes a ray in the space of a tree.
struct WideRay {
    vec3 origin;
    vec3 inverse;
    // Rows of a shear that turns the direction into (0, 0, 1)
    vec3 shearX;
    vec3 shearY;
    vec3 shearZ;
    uint octant;  // bit 0: towards greater x; bit 1: y; bit 2: z. The slot of that number is the farthest one
};

INLINE float AwayFromZero(float x) {
    return abs(x) < kMinDirection ? (x < 0.0f ? -kMinDirection : kMinDirection) : x;
}

INLINE WideRay MakeWideRay(vec3 origin, vec3 direction) {
    WideRay ray;
    ray.origin = origin;
    ray.inverse = vec3(1.0f / AwayFromZero(direction.x), 1.0f / AwayFromZero(direction.y),
                       1.0f / AwayFromZero(direction.z));
    ray.octant = (ray.inverse.x > 0.0f ? 1u : 0u) | (ray.inverse.y > 0.0f ? 2u : 0u) |
                 (ray.inverse.z > 0.0f ? 4u : 0u);
    vec3 size = abs(direction);
    bool isX = size.x > size.y && size.x > size.z;
    bool isY = !isX && size.y > size.z;
    float inverse = 1.0f / (isX ? direction.x : (isY ? direction.y : direction.z));
    vec3 slope = direction * inverse;
    // The two other axes, in cyclic order: turned around if the direction is, so that sides stay
    vec3 first = isX ? vec3(-slope.y, 1.0f, 0.0f)
                     : (isY ? vec3(0.0f, -slope.z, 1.0f) : vec3(1.0f, 0.0f, -slope.x));
    vec3 second = isX ? vec3(-slope.z, 0.0f, 1.0f)
                      : (isY ? vec3(1.0f, -slope.x, 0.0f) : vec3(0.0f, 1.0f, -slope.y));
    ray.shearX = inverse > 0.0f ? first : second;
    ray.shearY = inverse > 0.0f ? second : first;
    ray.shearZ = inverse * vec3(isX ? 1.0f : 0.0f, isY ? 1.0f : 0.0f, isX || isY ? 0.0f : 1.0f);
    return ray;
}

INLINE float WideStep(uint biasedExponent) { return uintBitsToFloat(biasedExponent << 23u); }
INLINE float ByteOf(uint word, uint byte) { return float((word >> (8u * byte)) & 0xFFu); }

// Returns the bits of the four children in these words that the ray meets: where they are in a group of
// nodes, or of primitives.
INLINE uint IntersectChildren(uint meta, uint nearX, uint farX, uint nearY, uint farY, uint nearZ, uint farZ,
                         vec3 scale, vec3 offset, float tMax, uint octant) {
    // Per byte: all ones for a node, whose place depends on the octant
    uint isNode = ((meta & (meta << 1u)) & 0x10101010u) >> 4u;
    uint places = (meta ^ (octant * 0x01010101u & (isNode * 0xFFu))) & 0x1F1F1F1Fu;
    uint ones = (meta >> 5u) & 0x07070707u;
    uint met = 0u;
    WIDE_UNROLL for (uint i = 0u; i < 4u; ++i) {
        float tNear = max(max(ByteOf(nearX, i) * scale.x + offset.x, ByteOf(nearY, i) * scale.y + offset.y),
                          max(ByteOf(nearZ, i) * scale.z + offset.z, 0.0f));
        float tFar = min(min(ByteOf(farX, i) * scale.x + offset.x, ByteOf(farY, i) * scale.y + offset.y),
                         min(ByteOf(farZ, i) * scale.z + offset.z, tMax));
        if (tNear <= tFar * kFarSlack) met |= ((ones >> (8u * i)) & 0xFFu) << ((places >> (8u * i)) & 0x1Fu);
    }
    return met;
}

// Makes the two groups of a node's children.
INLINE void VisitWideNode(WideRay ray, float tMax, uint node, OUT(uvec2) nodes, OUT(uvec2) leaves) {
    uint at = kWideNodeWords * node;
    uvec4 head = WideNodeWord(at);
    uvec4 firsts = WideNodeWord(at + 1u);
    uvec4 a = WideNodeWord(at + 2u);
    uvec4 b = WideNodeWord(at + 3u);
    uvec4 c = WideNodeWord(at + 4u);
    vec3 origin = vec3(uintBitsToFloat(head.x), uintBitsToFloat(head.y), uintBitsToFloat(head.z));
    vec3 scale = vec3(WideStep(head.w & 0xFFu), WideStep((head.w >> 8u) & 0xFFu),
                      WideStep((head.w >> 16u) & 0xFFu)) *
                 ray.inverse;
    vec3 offset = (origin - ray.origin) * ray.inverse;
    bool isUpX = (ray.octant & 1u) != 0u;
    bool isUpY = (ray.octant & 2u) != 0u;
    bool isUpZ = (ray.octant & 4u) != 0u;
    uint met = IntersectChildren(firsts.z, isUpX ? a.x : b.z, isUpX ? b.z : a.x, isUpY ? a.z : c.x,
                            isUpY ? c.x : a.z, isUpZ ? b.x : c.z, isUpZ ? c.z : b.x,
                            scale, offset, tMax, ray.octant) |
               IntersectChildren(firsts.w, isUpX ? a.y : b.w, isUpX ? b.w : a.y, isUpY ? a.w : c.y,
                            isUpY ? c.y : a.w, isUpZ ? b.y : c.w, isUpZ ? c.w : b.y,
                            scale, offset, tMax, ray.octant);
    nodes = uvec2(firsts.x, (met & 0xFF000000u) | (head.w >> 24u));
    leaves = uvec2(firsts.y, met & 0x00FFFFFFu);
}

INLINE float Along(vec3 row, vec3 p) {
    PRECISE float sum = row.x * p.x + row.y * p.y + row.z * p.z;
    return sum;
}
// Twice the signed area of a triangle with a corner at 0. Its sign is exact, or it is 0.
INLINE float Turn(vec2 a, vec2 b) {
    PRECISE float turn = a.x * b.y - a.y * b.x;
    return turn;
}

// Sets `hit` if the triangle is nearer than tMax. `isBack`: the ray hits the back face. `instance` and
// `flags` are given, or, of one level, those of the triangle.
INLINE bool IntersectTriangle(WideRay ray, float tMax, bool hasOneLevel, uint triangle, INOUT(uint) instance,
                         INOUT(uint) flags, INOUT(WideHit) hit, OUT(bool) isBack) {
    uint at = kWideTriangleWords * triangle;
    uvec4 a = WideTriangleWord(at);
    uvec4 b = WideTriangleWord(at + 1u);
    uvec4 c = WideTriangleWord(at + 2u);
    if (hasOneLevel) {
        instance = b.w;
        flags = c.w;
    }
    vec3 p0 = vec3(uintBitsToFloat(a.x), uintBitsToFloat(a.y), uintBitsToFloat(a.z)) - ray.origin;
    vec3 p1 = vec3(uintBitsToFloat(b.x), uintBitsToFloat(b.y), uintBitsToFloat(b.z)) - ray.origin;
    vec3 p2 = vec3(uintBitsToFloat(c.x), uintBitsToFloat(c.y), uintBitsToFloat(c.z)) - ray.origin;
    vec2 q0 = vec2(Along(ray.shearX, p0), Along(ray.shearY, p0));
    vec2 q1 = vec2(Along(ray.shearX, p1), Along(ray.shearY, p1));
    vec2 q2 = vec2(Along(ray.shearX, p2), Along(ray.shearY, p2));
    float w0 = Turn(q2, q1);
    float w1 = Turn(q0, q2);
    float w2 = Turn(q1, q0);
    float least = min(w0, min(w1, w2));
    float most = max(w0, max(w1, w2));
    isBack = (least < 0.0f) != (hasOneLevel && (flags & kWideMirrored) != 0u);
    if ((isBack && (flags & kWideBackCulled) != 0u) || (least < 0.0f && most > 0.0f)) return false;
    float inverse = 1.0f / (w0 + w1 + w2);
    float t = (w0 * Along(ray.shearZ, p0) + w1 * Along(ray.shearZ, p1) + w2 * Along(ray.shearZ, p2)) *
              inverse;
    // Also false if t is not a number, as of triangles without an area.
    if (!(t > 0.0f && t < tMax)) return false;
    hit.t = t;
    hit.instance = instance;
    hit.primitive = a.w;
    hit.barycentrics = vec2(w1 * inverse, w2 * inverse);
    return true;
}

INLINE WideRay ToInstance(vec3 origin, vec3 direction, uvec4 x, uvec4 y, uvec4 z) {
    vec3 rowX = vec3(uintBitsToFloat(x.x), uintBitsToFloat(x.y), uintBitsToFloat(x.z));
    vec3 rowY = vec3(uintBitsToFloat(y.x), uintBitsToFloat(y.y), uintBitsToFloat(y.z));
    vec3 rowZ = vec3(uintBitsToFloat(z.x), uintBitsToFloat(z.y), uintBitsToFloat(z.z));
    vec3 moved = vec3(dot(rowX, origin) + uintBitsToFloat(x.w), dot(rowY, origin) + uintBitsToFloat(y.w),
                      dot(rowZ, origin) + uintBitsToFloat(z.w));
    return MakeWideRay(moved, vec3(dot(rowX, direction), dot(rowY, direction), dot(rowZ, direction)));
}

// Returns the nearest triangle below tMax, or any, where `isAny`. The direction may have any length, t is in
// it. `hasOneLevel`: see shared/wide_bvh.h.
INLINE WideHit TraverseWide(vec3 origin, vec3 direction, float tMax, bool isAny, bool hasOneLevel,
                            INOUT(WideCounts) counts) {
    WideHit hit;
    hit.t = -1.0f;
    hit.instance = kWideNoInstance;
    hit.primitive = 0u;
    hit.barycentrics = vec2(0.0f, 0.0f);
    WideRay ray = MakeWideRay(origin, direction);
    uvec2 nodes = uvec2(WideInstanceWord(kWideInstanceWords - 1u).x, 0x80000000u);
    uint stackSize = 0u;
    uint stackBase = 0u;                     // base of the mesh's tree
    bool isInInstance = hasOneLevel;         // the ray is in a tree of triangles
    uint instance = 0u;
    uint flags = 0u;
    for (;;) {
        uvec2 leaves = nodes;
        if (nodes.y >= kLowestNodeBit) {
            // Take the nearest node of the group; the rest waits
            uint bit = uint(findMSB(nodes.y));
            uint slot = (bit - 24u) ^ ray.octant;
            uint place = uint(bitCount(nodes.y & ((1u << slot) - 1u)));
            uint node = nodes.x + place;
            nodes.y &= ~(1u << bit);
            if (nodes.y >= kLowestNodeBit) {
                PushGroup(stackSize, nodes);
                ++stackSize;
            }
            VisitWideNode(ray, tMax, node, nodes, leaves);
            ++counts.nodes;
        } else {
            nodes = uvec2(0u, 0u);
        }
        while (leaves.y != 0u) {
            uint bit = uint(findMSB(leaves.y));
            leaves.y &= ~(1u << bit);
            if (!hasOneLevel && !isInInstance) {
                // Go down into the tree of a mesh; the rest of this one waits
                if (nodes.y >= kLowestNodeBit) {
                    PushGroup(stackSize, nodes);
                    ++stackSize;
                }
                if (leaves.y != 0u) {
                    PushGroup(stackSize, leaves);
                    ++stackSize;
                }
                stackBase = stackSize;
                isInInstance = true;
                uint at = kWideInstanceWords * (leaves.x + bit);
                uvec4 numbers = WideInstanceWord(at + 3u);
                ray = ToInstance(origin, direction, WideInstanceWord(at), WideInstanceWord(at + 1u),
                                 WideInstanceWord(at + 2u));
                instance = numbers.y;
                flags = numbers.z;
                nodes = uvec2(numbers.x, 0x80000000u);
                leaves.y = 0u;
                ++counts.instances;
            } else {
                ++counts.triangles;
                WideHit met;
                bool isBack;
                if (IntersectTriangle(ray, tMax, hasOneLevel, leaves.x + bit, instance, flags, met, isBack)) {
                    if ((flags & kWideTested) == 0u || IsAccepted(met, isBack, isAny)) {
                        hit = met;
                        if (isAny) return hit;
                        tMax = hit.t;
                    }
                }
            }
        }
        if (nodes.y >= kLowestNodeBit) continue;
        if (!hasOneLevel && stackSize == stackBase && isInInstance) {
            isInInstance = false;
            stackBase = 0u;
            ray = MakeWideRay(origin, direction);
        }
        if (stackSize == 0u) return hit;
        --stackSize;
        nodes = GroupAt(stackSize);
    }
}

SHADING_END

#endif
