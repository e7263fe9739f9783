// Rays and what they hit. Shared by the device and by the tests' own scenes on the CPU.
#ifndef RAYGRAPH_SCENE_RAY_GLSL
#define RAYGRAPH_SCENE_RAY_GLSL

#include "core/glue.h"
#include "core/ray_cone.glsl"
#include "shared/scene_records.h"

#ifdef __cplusplus
namespace raygraph::shading {
using gpu::kMaterialShadowCatcher;
using gpu::kMaterialUnlit;
using gpu::kMaterialVolume;
}  // namespace raygraph::shading
#endif

SHADING_BEGIN

struct Ray {
    vec3 origin;
    vec3 direction;  // unit length
    RayCone cone;    // for the level of textures; set if kTraceTextureLod is
};

// Holds the result of closest-hit: only 20 bytes. SurfaceAt looks up everything else.
struct Hit {
    float t;            // distance along the ray; negative: nothing was hit
    uint instance;      // index of the InstanceRecord
    uint primitive;     // triangle or capsule, in the order of the BLAS
    vec2 barycentrics;  // weights of the second and the third vertex; of a capsule, CapsulePlaceOf
};

INLINE bool IsHit(Hit hit) { return hit.t >= 0.0f; }

CONST uint kVacuum = 0xFFFFFFFFu;

// Describes a material evaluated at one point, including its textures.
struct SurfaceMaterial {
    vec3 baseColor;
    float metallic;
    float roughness;  // perceptual: alpha = roughness^2
    float anisotropy;  // strength of the stretch of highlights; set if kTraceAnisotropy is
    float specular;
    vec3 specularColor;
    float ior;
    float transmission;
    float iridescenceThickness;  // thickness of the film, nm; set if kTraceIridescence is
    uint flags;  // kMaterial* of shared/scene_records.h
    uint id;     // index of the MaterialRecord
    // Each is set if its feature is
#define RAYGRAPH_MATERIAL_FACTOR(type, name, object, key, channels, space, feature, quantity) type name;
#define RAYGRAPH_MATERIAL_NUMBER(type, name, field, object, key, feature, quantity) type name;
#include "shared/material_list.h"
};

// Holds the inside of a closed surface.
struct Medium {
    vec3 extinction;  // 1/m
    vec3 scattering;  // the part that scatters, and the mean cosine of the angle; set if kTraceScattering is
    float anisotropy;
    float ior;
    float dispersion;  // 20 / Abbe number; set if kTraceDispersion is
    uint priority;
};

// Describes a point on a surface as the integrator sees it. Normals have unit length and are on the side of
// `wo`, the direction back along the ray.
struct SurfaceInteraction {
    vec3 position;
    vec3 instanceOrigin;  // position is the sum of these two, rounded
    vec3 fromInstance;
    float clearance;  // offset of a ray that leaves here, along the geometric normal: RayClearance
    vec3 geometricNormal;
    vec3 shadingNormal;
    vec3 coatNormal;  // normal of the clear coat; set if kTraceClearcoat is
    float curvature;  // mean, 1/m; positive: convex on the side of wo. Set if kTraceTextureLod is
    vec3 stretch;  // along which facets are rougher, any length; 0: none. Set if kTraceAnisotropy is
    vec3 emission;  // radiance towards wo
    uint light;     // index of the light that this is, or kNoLight: light sampling does not find it
    uint lightTriangle;  // for a mesh that is one light: the triangle within it. Set if kTraceMeshLights is
    bool isFront;   // wo is on the front of the surface
    SurfaceMaterial material;
};

SHADING_END

#endif
