// SceneIds: what GpuScene::Declare returns for the passes of a frame. Threads: plain values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>

#include "renderer/gpu_scene/lights/light_groups.h"
#include "renderer/graph/ids.h"
#include "shaders/shared/scene_records.h"
#include "shaders/shared/trace_options.h"

namespace raygraph {

// Classes of triangles for drawing, by how rays treat them.
enum class DrawKind : uint8_t {
    Opaque,  // no alpha test; back faces are culled
    OpaqueTwoSided,
    AlphaTested,  // alpha-tested; back faces are culled
    AlphaTestedTwoSided,
};
inline constexpr size_t kDrawKindCount = 4;

struct DrawRange {
    uint32_t first = 0;
    uint32_t count = 0;
};

// Holds the scene of one frame, for passes.
struct SceneIds {
    TlasId tlas;  // "sceneTlas"
    // The wide BVHs of the scene, which shaders traverse themselves (shaders/shared/wide_bvh.h). The ids are
    // invalid if there are none (GpuSceneDesc::traversal).
    BufferId wideNodes, wideTriangles, wideInstances;
    bool hasOneWideLevel = false;
    BlasSetId blases;  // referenced by the TLAS, together with the vertex streams: ReadsByAddress
    // Invalid if nothing is deformed. Otherwise passes that read vertices declare ReadsByAddress for it.
    BufferId deformedStreams;
    BufferId instances;        // "instances": gpu::InstanceRecord[]
    BufferId geometries;       // "geometries": gpu::GeometryRecord[]
    BufferId materials;        // "materials": gpu::MaterialRecord[]
    TextureSetId textures;     // set 1
    TextureId environmentMap;  // "environmentMap": equirectangular; a black texel when there is none
    gpu::EnvironmentRecord environment;
    uint64_t environmentVersion = 0;  // changes with the content of environmentMap
    BufferId lights;                  // "lights": gpu::LightRecord[]
    BufferId lightNodes;              // "lightNodes": gpu::LightNode[]
    BufferId lightAlias;              // "lightAlias": gpu::AliasEntry[]
    BufferId lightMeshes;             // "lightMeshes": gpu::LightMeshRecord[]
    BufferId lightProfiles;           // "lightProfiles": float[], see shaders/lights/light_profile.glsl
    BufferId environmentTable;        // "environmentTable": gpu::EnvironmentEntry[]
    gpu::LightSetRecord lightSet{};
    BufferId energyTables;  // "energyTables": float[], see shaders/shared/energy_tables.h
    // The features that programs need for the scene, as far as the settings use them. TextureLod is the only
    // one of kind Settings: it tells that textures have mip levels (GpuSceneDesc::textureLevels).
    TraceFeatures features;
    uint32_t triangleLights = 0;  // number of lights that are triangles or meshes, dark ones included
    uint32_t punctualLights = 0;
    uint32_t lightGroupCount = gpu::kLightGroupNamed;  // rest, environment, and the groups of SetLightGroups
    BufferId draws;               // "draws": gpu::DrawRecord[], one per group of triangles
    uint32_t placementCount = 0;  // number of records of `instances`, free ones included
    std::array<DrawRange, kDrawKindCount> drawsOfKind{};  // by DrawKind, ascending
    uint64_t chunkCount = 0;  // sum over all placements, see shaders/shared/draw_records.h
    glm::dvec3 origin{0.0};   // in world space; positions on the device are relative to it
};

}  // namespace raygraph
