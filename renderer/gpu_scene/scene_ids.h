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

// Classes of triangles for drawing: by how rays treat them.
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

// The scene of one frame, for passes.
struct SceneIds {
    TlasId tlas;  // "sceneTlas"
    // The scene again, as trees that shaders traverse themselves (shaders/shared/wide_bvh.h). Invalid ids:
    // there are no trees (GpuSceneDesc::traversal).
    BufferId wideNodes, wideTriangles, wideInstances;
    bool hasOneWideLevel = false;
    BlasSetId blases;  // referenced by the TLAS, with the vertex streams: ReadsByAddress
    // Invalid: nothing is deformed. Otherwise passes that read vertices declare ReadsByAddress for it.
    BufferId deformedStreams;
    BufferId instances;        // "instances": gpu::InstanceRecord[]
    BufferId geometries;       // "geometries": gpu::GeometryRecord[]
    BufferId materials;        // "materials": gpu::MaterialRecord[]
    TextureSetId textures;     // set 1
    TextureId environmentMap;  // "environmentMap": equirectangular; a black texel when there is none
    gpu::EnvironmentRecord environment;
    uint64_t environmentVersion = 0;  // changes with environmentMap's content
    BufferId lights;                  // "lights": gpu::LightRecord[]
    BufferId lightNodes;              // "lightNodes": gpu::LightNode[]
    BufferId lightAlias;              // "lightAlias": gpu::AliasEntry[]
    BufferId lightMeshes;             // "lightMeshes": gpu::LightMeshRecord[]
    BufferId lightProfiles;           // "lightProfiles": float[], see shaders/lights/light_profile.glsl
    BufferId environmentTable;        // "environmentTable": gpu::EnvironmentEntry[]
    gpu::LightSetRecord lightSet{};
    BufferId energyTables;  // "energyTables": float[], see shaders/shared/energy_tables.h
    // The features that programs need for the scene, as far as settings use them. TextureLod is the only one
    // of kind Settings: it says that textures have mip levels (GpuSceneDesc::textureLevels).
    TraceFeatures features;
    uint32_t triangleLights = 0;  // how many lights are triangles or meshes, dark ones too
    uint32_t punctualLights = 0;
    uint32_t lightGroupCount = gpu::kLightGroupNamed;  // rest, environment, and those of SetLightGroups
    BufferId draws;               // "draws": gpu::DrawRecord[], one per group of triangles
    uint32_t placementCount = 0;  // records of `instances`; some are free
    std::array<DrawRange, kDrawKindCount> drawsOfKind{};  // by DrawKind, ascending
    uint64_t chunkCount = 0;  // of all placements, see shaders/shared/chunk_records.h
    glm::dvec3 origin{0.0};   // in world space: positions on the device are relative to it
};

}  // namespace raygraph
