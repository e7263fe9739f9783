// The scene as the shaders read it: one source for C++ and GLSL, scalar layout (no padding beyond what
// is written).
//
//   TLAS instance    --customIndex-->  InstanceRecord: one group of a mesh's primitives, placed
//   triangle, capsule  --triangleGeometries-->  GeometryRecord: one primitive of the file
//   GeometryRecord   --material-->  MaterialRecord  --texture slots-->  texture table (set 1)
//
// A group is the content of one BLAS, as a single list of triangles, or of capsules. Streams are reached
// by device address; 0 means that there is none. All streams of a group's geometries are indexed by the
// group's vertex numbers: their addresses are shifted accordingly.
#ifndef RAYGRAPH_SHARED_SCENE_RECORDS_H
#define RAYGRAPH_SHARED_SCENE_RECORDS_H

#include "light_records.h"

#ifdef __cplusplus

#include <cstdint>
#include <glm/glm.hpp>

namespace raygraph::gpu {
using glm::mat3x2;
using glm::mat4x3;
using glm::uvec2;
using glm::vec2;
using glm::vec3;
using glm::vec4;
using uint = uint32_t;
#define RAYGRAPH_ADDRESS  uint64_t
#define RAYGRAPH_CONSTANT inline constexpr
#else
#define RAYGRAPH_ADDRESS  uvec2
#define RAYGRAPH_CONSTANT const
#endif

RAYGRAPH_CONSTANT uint kNoTexture = 0xFFFFFFFFu;
RAYGRAPH_CONSTANT uint kSecondTexCoord = 0x80000000u;

RAYGRAPH_CONSTANT uint kNotDrawn = 0xFFFFFFFFu;

struct InstanceRecord {
    mat4x3 objectToWorld;        // columns: x, y, z axes and translation, from the scene's origin
    RAYGRAPH_ADDRESS positions;  // vec3 a vertex of the group; or CapsuleRecord, in the order of the BLAS
    RAYGRAPH_ADDRESS indices;    // uint, three a triangle, in the order of the BLAS; 0: these are capsules
    // uint a triangle: its geometry, from firstGeometry; 0: the first for all
    RAYGRAPH_ADDRESS triangleGeometries;
    // uint a triangle: its light, from firstLight, or kNoLight; 0: no lights
    RAYGRAPH_ADDRESS triangleLights;
    uint firstGeometry;  // index of the group's first GeometryRecord
    uint instance;       // index of the scene's instance
    uint firstLight;     // number of the group's first light
    uint draw;           // index of the group's DrawRecord, or kNotDrawn: it is hidden
};

// Describes a round primitive, in object space (core/capsule.glsl).
struct CapsuleRecord {
    vec3 p0;
    float radius;
    vec3 p1;
    uint first;  // vertices of the group
    uint second;
};

// Values of GeometryRecord::tangentSet. Tangents that were made along a texture coordinate set are the frame
// of maps that are read by this set without a transform; tangents that were given are the frame of all maps.
// The values of the sets are bits, so that a mask can name several.
RAYGRAPH_CONSTANT uint kTangentsOfAllMaps = 0u;
RAYGRAPH_CONSTANT uint kTangentsOfFirstSet = 1u;
RAYGRAPH_CONSTANT uint kTangentsOfSecondSet = 2u;

struct GeometryRecord {
    RAYGRAPH_ADDRESS normals;   // vec3
    RAYGRAPH_ADDRESS tangents;  // vec4
    // vec2: cosine and sine of the angle about the normal from the tangent to the tangent of the set that
    // tangentSet does not name; 0: maps of that set use the frame of each triangle
    RAYGRAPH_ADDRESS frameTurns;
    RAYGRAPH_ADDRESS uv0;     // vec2
    RAYGRAPH_ADDRESS uv1;     // vec2
    RAYGRAPH_ADDRESS colors;  // vec4, linear
    // uint a triangle of the group: its index in the file's primitive; 0: the same
    RAYGRAPH_ADDRESS primitives;
    uint material;
    uint tangentSet;  // kTangents*: which maps are read along the tangents
};

// The index for which KHR_materials_ior's special value 0 stands: F0 is 1 to the last bit, and the square is
// in the range of float.
RAYGRAPH_CONSTANT float kInfiniteIor = 1e8f;

// Bits of MaterialRecord::flags.
RAYGRAPH_CONSTANT uint kMaterialTwoSided = 1u;  // else back faces are culled
RAYGRAPH_CONSTANT uint kMaterialUnlit = 2u;     // emits its base color, scatters nothing
// The surface bounds a medium; else transmission is thin-walled.
RAYGRAPH_CONSTANT uint kMaterialVolume = 4u;
// The alpha of specularColor's texture scales glossiness: roughness is 1 - (1 - that of the record) *
// alpha.
RAYGRAPH_CONSTANT uint kMaterialGlossiness = 8u;
// Some light may pass through as through glass: there is transmission, and not all of it is scattered.
RAYGRAPH_CONSTANT uint kMaterialGlass = 16u;
RAYGRAPH_CONSTANT uint kMaterialShadowCatcher = 32u;  // integrator/shadow_catcher.glsl

// Values and textures are those of material_list.h, with those that ToRecord computes from other fields of
// scene::Material.
struct MaterialRecord {
    vec3 emission;    // radiance, W/(sr m^2)
    uint alphaMode;   // kAlpha* (choice.h)
    uint flags;       // kMaterial*
    float ior;        // kInfiniteIor: reflects all
    vec3 extinction;  // of the medium inside, 1/m: the share that passes d meters is exp(-extinction d)
    vec3 scattering;  // the part of it that scatters, 1/m
    float scatterAnisotropy;    // mean cosine of the medium's scattering angle
    vec2 iridescenceThickness;  // minimum, maximum; nm
#define RAYGRAPH_MATERIAL_VALUE(type, name, field, object, key, quantity) type name;
#include "material_list.h"
    // Slots of the texture table, or kNoTexture. kSecondTexCoord set: read through uv1.
#define RAYGRAPH_MATERIAL_TEXTURE(name, object, key, space) uint name##Texture;
#include "material_list.h"
    // Transforms (u, v, 1) to the place where the texture is read. Only scenes with such transforms read it.
#define RAYGRAPH_MATERIAL_TEXTURE(name, object, key, space) mat3x2 name##Transform;
#include "material_list.h"
};

struct CameraRecord {
    // Relative to the scene's origin on the device. As ToRecord returns it and passes take it, it is in world
    // space, with originResidual: the remainder of the rounding to float.
    vec3 origin;
    uint orthographic;    // 1: rays are parallel, origin moves over the film
    vec3 right;           // half the film's width at distance 1 (perspective), or in meters (orthographic)
    vec3 up;              // half the film's height, likewise; points to the top row
    vec3 forward;         // unit length
    float lensRadius;     // meters; 0: a pinhole. An orthographic camera has none
    float focusDistance;  // meters along forward to the plane that is sharp
    // Only for raster views, which see nothing nearer (perspective) or farther (orthographic); meters
    float zNear;
    float zFar;
    vec3 originResidual;
};

struct EnvironmentRecord {
    vec3 radiance;   // W/(sr m^2); scales the map if there is one
    float rotation;  // radians about +y
    uint hasMap;
};

// Describes a pixel that Trace samples, where pixels have different numbers of samples (passes/pixel_list.h).
struct ListedPixel {
    uint texel;        // texel of the traced part of the picture: x + y * 65536
    uint sampleIndex;  // index of its first sample
};

// Holds all parameters of a camera-ray pass; a uniform block.
struct TraceParameters {
    CameraRecord camera;
    EnvironmentRecord environment;
    LightSetRecord lights;
    uvec2 pictureSize;   // pixels
    uvec2 regionOffset;  // pixels: of the part that is traced
    uint seed;
    uint sampleIndex;     // index of the first sample that is traced
    uint sampleRows;      // rows of the outputs of Trace for each sample
    uint maxDepth;        // bounces; 0xFFFFFFFF: no limit
    uint rouletteStart;   // first bounce at which Russian roulette may terminate the path
    float survival;       // survival probability of a bounce, for roulettes not by throughput
    uint frameDepth;      // bounces of this sample's paths, where they all have the same
    float clampIndirect;  // largest component of a contribution after the first bounce; infinity: off
    float regularize;     // least alpha of a surface after the first bounce; 0: off
    float textureLod;     // added to the level at which paths read textures, if kTraceTextureLod is set
    vec3 sceneOrigin;     // in world space; all other positions on the device are relative to it
    uvec2 pixelList;      // address of a ListedPixel for each texel of a sample, if kTracePixelList is set
    uint pixelListWidth;  // texels
    uint pixelListCount;  // number of a sample's texels that belong to a pixel
};

#undef RAYGRAPH_CONSTANT

#ifdef __cplusplus
#undef RAYGRAPH_ADDRESS

static_assert(sizeof(InstanceRecord) == 24 * 4);
static_assert(sizeof(CapsuleRecord) == 9 * 4);
static_assert(sizeof(GeometryRecord) == 16 * 4);
static_assert(sizeof(MaterialRecord) == 15 * 4
#define RAYGRAPH_MATERIAL_VALUE(type, name, field, object, key, quantity) +sizeof(type)
#define RAYGRAPH_MATERIAL_TEXTURE(name, object, key, space)               +sizeof(uint) + sizeof(mat3x2)
#include "material_list.h"
);
static_assert(sizeof(TraceParameters) == 57 * 4);
}  // namespace raygraph::gpu
#endif

#endif
