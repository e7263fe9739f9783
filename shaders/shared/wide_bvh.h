// A compressed tree of boxes with up to eight children a node, over the triangles of meshes and over the
// placed meshes: one source for C++ and GLSL, scalar layout. Ylitie, Karras and Laine 2017, "Efficient
// Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs". Built by renderer/bvh/, traversed by
// scene/wide_bvh.glsl.
//
// One array of nodes holds the tree of the instances and those of the meshes. The primitives of a tree of
// instances are WideInstances, of a mesh WideTriangles; both in the leaves' order. The first WideInstance is
// none: its `root` is that of the tree of the instances.
//
// Or there is one level: a single tree over the triangles of all instances, placed, each of which has the
// number and the flags of its instance. Its root is that of the first WideInstance as well, the only one.
#ifndef RAYGRAPH_SHARED_WIDE_BVH_H
#define RAYGRAPH_SHARED_WIDE_BVH_H

#ifdef __cplusplus

#include <cstdint>
#include <glm/glm.hpp>

namespace raygraph::gpu {
using glm::vec2;
using glm::vec3;
using glm::vec4;
using uint = uint32_t;
#define RAYGRAPH_CONSTANT inline constexpr
#else
#define RAYGRAPH_CONSTANT const
#endif

RAYGRAPH_CONSTANT uint kWideChildren = 8u;
RAYGRAPH_CONSTANT uint kWideLeafPrimitives = 3u;  // most primitives of a child
RAYGRAPH_CONSTANT uint kWideNodeWords = 5u;       // words of 16 bytes; likewise below
RAYGRAPH_CONSTANT uint kWideTriangleWords = 3u;
RAYGRAPH_CONSTANT uint kWideInstanceWords = 4u;
// Groups of nodes or primitives that wait while a ray is traversed; builders refuse deeper trees.
RAYGRAPH_CONSTANT uint kWideStackSize = 32u;
RAYGRAPH_CONSTANT uint kWideNoInstance = 0xFFFFFFFFu;
// Bits of `flags`.
RAYGRAPH_CONSTANT uint kWideBackCulled = 1u;  // rays pass through the back faces of its triangles
RAYGRAPH_CONSTANT uint kWideTested = 2u;      // whoever traverses decides for each triangle whether it is hit
// Only in a tree of one level: the transform mirrors the triangle, so its front is where its back seems to
// be.
RAYGRAPH_CONSTANT uint kWideMirrored = 4u;

// A child is in one of eight slots. Bit 0 of the slot's number is set where it is on the side of greater x,
// bit 1 of y, bit 2 of z: so (slot xor the ray's octant) is an order from the far to the near ones.
//
// A byte of `meta` a slot: 0: empty. A node: 001 in the highest three bits, 24 + slot in the others.
// Primitives: as many ones in the highest three bits as there are, and their first one's place after
// firstPrimitive.
struct WideNode {
    vec3 origin;  // origin of the coordinates of the boxes
    // Exponents of x, y, z, biased as those of a float: a step is 2^e. Highest byte: bit s: slot s is a node
    uint exponents;
    uint firstChild;  // children that are nodes are one after another, by slot
    uint firstPrimitive;
    uint meta[2];  // a byte a slot; likewise below
    uint low[6];   // low sides of boxes, in steps: two of x, two of y, two of z
    uint high[6];
};

struct WideTriangle {
    vec3 p0;
    uint primitive;  // number in its mesh
    vec3 p1;
    uint instance;  // in one level: number of the instance
    vec3 p2;
    uint flags;  // kWideBackCulled, ...
};

struct WideInstance {
    vec4 toObject[3];  // rows
    uint root;         // root of the mesh's tree
    uint instance;     // number of the instance
    uint flags;        // kWideBackCulled, ...
    uint padding;
};

struct WideHit {
    float t;  // negative: nothing was hit
    uint instance;
    uint primitive;
    vec2 barycentrics;  // weights of p1 and p2
};
// Holds the number of nodes, triangles and instances that a traversal visits.
struct WideCounts {
    uint nodes;
    uint triangles;
    uint instances;
};

// Holds the input of both ways of tracing that a benchmark compares; they give WideHits.
struct BenchRay {
    vec3 origin;
    float tMax;
    vec3 direction;
    uint padding;
};
struct BenchConstants {
    uint rayCount;
};

#undef RAYGRAPH_CONSTANT

#ifdef __cplusplus
static_assert(sizeof(WideNode) == 16 * kWideNodeWords);
static_assert(sizeof(WideTriangle) == 16 * kWideTriangleWords);
static_assert(sizeof(WideInstance) == 16 * kWideInstanceWords);
static_assert(sizeof(BenchRay) == 32);
static_assert(sizeof(WideHit) == 20);
}  // namespace raygraph::gpu
#endif

#endif
