// The lights of a scene as the shaders read them: one source for C++ and GLSL, scalar layout.
//
// A light is a number: first the bounded ones (triangles, points, spots), then the directional ones, and last
// the environment, which has no record: number `lightCount`. Every surface that may emit keeps its number as
// long as no other is added or removed; one that is dark or hidden at present has probability 0.
//
// The emitting triangles of a mesh that is placed often are there once, in object space, and each placement
// is one light (kLightMesh). Their records follow those of the lights. The light tree chooses a placement,
// the mesh's own tree one of its triangles, whose number counts from the first of the mesh.
//
// The alias buffer starts with three tables, one after the other:
//   power       lightCount + 1 entries: choose among all lights by power
//   unbounded   lightCount + 1 - boundedCount entries: among directional lights and environment, by power
//   active      activeCount entries: `alias` is the number of a light that shines
// and goes on, where LightMeshRecord::firstAlias says, with two tables a mesh, likewise of its triangles:
//   power       triangleCount entries
//   active      activeCount entries
// The environment has a table of its own kind, EnvironmentEntry.
#ifndef RAYGRAPH_SHARED_LIGHT_RECORDS_H
#define RAYGRAPH_SHARED_LIGHT_RECORDS_H

#ifdef __cplusplus

#include <cstdint>
#include <glm/glm.hpp>

namespace raygraph::gpu {
using glm::vec3;
using uint = uint32_t;
#define RAYGRAPH_CONSTANT inline constexpr
#else
#define RAYGRAPH_CONSTANT const
#endif

// LightRecord::kind
RAYGRAPH_CONSTANT uint kLightTriangle = 0u;
RAYGRAPH_CONSTANT uint kLightPoint = 1u;
RAYGRAPH_CONSTANT uint kLightSpot = 2u;
RAYGRAPH_CONSTANT uint kLightDirectional = 3u;
RAYGRAPH_CONSTANT uint kLightMesh = 4u;  // a placement of a mesh, bounded

// LightRecord::flags
RAYGRAPH_CONSTANT uint kLightDoubleSided = 1u;  // the triangle emits from both sides
// A triangle's front is the side that -cross(e1, e2) points to; of a profile y is negated. Of a mesh: that of
// its triangles, once they are placed.
RAYGRAPH_CONSTANT uint kLightMirrored = 2u;
RAYGRAPH_CONSTANT uint kLightProfile = 4u;  // the intensity of the point light is times that of a profile

RAYGRAPH_CONSTANT uint kLightOutward = 8u;  // the triangles of the mesh emit from their fronts alone

// The rest of LightRecord::flags is the light's group: of a mesh that of its instance, of its triangles that
// of their material, and a placed triangle is in the lower one that is not kLightGroupRest.
RAYGRAPH_CONSTANT uint kLightGroupShift = 8u;

// Groups of lights, which Trace renders separately on request. Every light is in one.
RAYGRAPH_CONSTANT uint kLightGroupRest = 0u;         // all other lights, and surfaces that are no lights
RAYGRAPH_CONSTANT uint kLightGroupEnvironment = 1u;  // the environment, and nothing else
RAYGRAPH_CONSTANT uint kLightGroupNamed = 2u;        // the first of the named groups
RAYGRAPH_CONSTANT uint kMaxNamedLightGroups = 8u;
RAYGRAPH_CONSTANT uint kMaxLightGroups = 10u;

// The first word of a profile (lights/light_profile.glsl).
RAYGRAPH_CONSTANT uint kProfileTypeA = 0u;
RAYGRAPH_CONSTANT uint kProfileTypeB = 1u;
RAYGRAPH_CONSTANT uint kProfileTypeC = 2u;

// "No light": in a group's triangleLights and in InstanceRecord::firstLight.
RAYGRAPH_CONSTANT uint kNoLight = 0xFFFFFFFFu;
// A bit of InstanceRecord::firstLight. Without it, the number is that of the one light that the placement is,
// and triangleLights counts from the first triangle of the mesh.
RAYGRAPH_CONSTANT uint kFirstLightIsMesh = 0x80000000u;

// World space from the scene's origin, but for the triangles of meshes. A triangle keeps the order of its
// vertices, so that barycentrics mean the same here and in a hit.
struct LightRecord {
    vec3 p0;         // triangle: vertex 0. Point, spot: position
    uint kind;       // kLight*
    vec3 e1;         // triangle: vertex 1 - vertex 0. Spot, directional: unit vector the light travels along.
                     // Profile: with spotScale a unit quaternion, from the world's axes to the profile's
    uint flags;      // kLight*, and the group
    vec3 e2;         // triangle: vertex 2 - vertex 0. Point, spot: intensity in cd. Directional: lx
    uint instance;   // triangle, mesh: index of its InstanceRecord
    uint primitive;  // triangle: its number in the BLAS. Profile: its first word in the buffer of profiles.
                     // Mesh: its LightMeshRecord
    uint bitTrail;   // path through the tree: bit d says which child is taken at depth d
    float spotScale;              // spot: falls off by clamp(cos * spotScale + spotOffset, 0, 1)^2, with
                                  // KHR_lights_punctual's lightAngleScale and lightAngleOffset
    float spotOffsetOrClearance;  // spot: spotOffset. Triangle: the RayClearance of its points
};

// LightNode::link
RAYGRAPH_CONSTANT uint kLightNodeLeaf = 0x80000000u;  // the rest is a light, else the first of two children
RAYGRAPH_CONSTANT uint kLightNodeTwoSided = 0x40000000u;  // emits about -axis as it does about axis
RAYGRAPH_CONSTANT uint kLightNodeIndex = 0x3FFFFFFFu;

// Holds bounds of the lights below a node of the light tree: node 0 is the root, children are adjacent.
// Emission leaves within an angle of thetaE about directions within thetaO of the axis.
struct LightNode {
    vec3 boundsMin;
    float power;  // luminance of all lights below
    vec3 boundsMax;
    uint link;   // kLightNode*
    vec3 axis;   // unit length
    uint cones;  // packSnorm2x16(cos thetaO, cos thetaE), both rounded to the wider angle
};

// Holds the values that all placements of a mesh share.
struct LightMeshRecord {
    uint firstLight;  // record of its first triangle
    uint triangleCount;
    uint activeCount;  // number of those that shine
    uint firstNode;    // root of its tree, in object space; leaves count from its first triangle
    uint firstAlias;
};

// Describes one slot of an alias table: a slot is drawn uniformly, then stays with probability `keep`, else
// becomes `alias`.
struct AliasEntry {
    float keep;
    uint alias;
    float probability;  // probability of this outcome, over all slots
};

struct LightSetRecord {
    uint lightCount;             // records: bounded, then directional
    uint boundedCount;           // triangles, meshes, points and spots
    uint activeCount;            // lights with power above 0, environment included
    uint nodeCount;              // nodes of the tree; 0: no bounded light has power
    float unboundedProbability;  // Bvh: probability of the unbounded table, else the tree
    float environmentRotation;
    uint hasEnvironment;    // 0: black
    uint environmentWidth;  // cells of the environment's table; a map without texture is one cell
    uint environmentHeight;
    uint firstPunctual;   // records from here on are of punctual lights
    float skyIrradiance;  // luminance, W/m^2, of the environment's light on a surface that faces +y
};

// --- The table by which directions to the environment are chosen ---
// The buffer holds an entry for each row of the map's cells, then those of each row's cells.

// Ends are multiples of 1 / this, as random numbers are.
RAYGRAPH_CONSTANT uint kEnvironmentSteps = 0x1000000u;

// u chooses the first entry whose `end` is above it. So neighbors of u choose neighbors, and samples that are
// spread evenly stay so; those of an alias table do not.
struct EnvironmentEntry {
    float end;
    // For entry i of n: no u in the i-th nth, nor one that rounds to it, chooses an entry before `guide`.
    uint guide;
    float probability;  // probability of this row; of this cell in the whole map
};

// --- The environment map, prefiltered for rough surfaces ---
// It has levels of equirectangular pictures, one below the other. Level i is filtered for a roughness of (i
// + 1) kFilteredStep, the last one for diffuse surfaces. Without rotation and scale, like the map.

RAYGRAPH_CONSTANT uint kFilteredWidth = 128u;
RAYGRAPH_CONSTANT uint kFilteredHeight = 64u;  // rows of a level
RAYGRAPH_CONSTANT uint kFilteredLevels = 6u;
RAYGRAPH_CONSTANT uint kFilteredDiffuse = kFilteredLevels - 1u;
RAYGRAPH_CONSTANT float kFilteredStep = 0.2f;

#undef RAYGRAPH_CONSTANT

#ifdef __cplusplus
static_assert(sizeof(LightRecord) == 16 * 4);
static_assert(sizeof(LightNode) == 12 * 4);
static_assert(sizeof(LightMeshRecord) == 5 * 4);
static_assert(sizeof(AliasEntry) == 3 * 4);
static_assert(sizeof(LightSetRecord) == 11 * 4);
static_assert(sizeof(EnvironmentEntry) == 3 * 4);
}  // namespace raygraph::gpu
#endif

#endif
