// What SetScene makes on the device: vertex streams, BLASes, textures, geometry and material tables.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "renderer/gpu_scene/light_table.h"
#include "renderer/scene/scene_data.h"
#include "rhi/blas_builder.h"
#include "rhi/device.h"
#include "rhi/resources.h"
#include "rhi/texture_table.h"
#include "rhi/upload.h"
#include "shaders/shared/scene_records.h"

namespace raygraph {

// How rays treat a primitive.
struct GroupKind {
    bool isOpaque = true;      // to rays of all types it is there: no any-hit shader decides that
    bool isBackCulled = true;  // its back faces are not there
    bool isThinWall = false;   // a smooth thin wall somewhere: shadow rays go on through it

    bool operator==(const GroupKind&) const = default;
};

// What the kind of a primitive hangs on, while the primitive itself has been freed.
struct GroupPart {
    uint32_t material = 0;
    bool hasColors = false;
};

// The primitives of a mesh that were of one kind when the scene was set, as one list of triangles in one
// BLAS: a mesh has up to six groups. Materials that change may make a group of one kind into one of several.
struct GroupResources {
    GroupKind kind;
    std::vector<GroupPart> parts;
    rhi::Buffer streams;
    std::shared_ptr<rhi::Blas> blas;
    gpu::InstanceRecord record{};   // but for transform, instance and firstLight
    std::vector<Emitter> emitters;  // until the light set takes them
    uint64_t triangleCount = 0;
    scene::Bounds bounds;  // object space
};

struct MeshResources {
    uint32_t firstGroup = 0;
    uint32_t groupCount = 0;
    uint64_t triangleCount = 0;
};

struct TextureResources {
    rhi::Texture texture;
    uint32_t sampler = 0;             // into SceneResources::samplers
    uint32_t slot = gpu::kNoTexture;  // of the texture table, once it has one
};

// Move-only through unique_ptr; textures give their slots back when it is destroyed.
struct SceneResources {
    explicit SceneResources(rhi::TextureTable& table) : textureTable(table) {}
    ~SceneResources();
    SceneResources(const SceneResources&) = delete;
    SceneResources& operator=(const SceneResources&) = delete;

    rhi::TextureTable& textureTable;
    std::vector<MeshResources> meshes;
    std::vector<GroupResources> groups;
    std::vector<rhi::Sampler> samplers;
    std::vector<TextureResources> textures;
    std::vector<gpu::MaterialRecord> materialRecords;
    rhi::Buffer geometries;  // gpu::GeometryRecord[]
    rhi::Buffer materials;   // gpu::MaterialRecord[]
    uint32_t geometryCount = 0;
    uint64_t geometryBytes = 0;
    uint64_t textureBytes = 0;
};

// Uploads everything but the instances, and adds the BLASes to the builder. Frees the meshes and images
// of `scene` as it goes: a host copy lives no longer than its upload.
std::unique_ptr<SceneResources> UploadScene(rhi::Device& device, rhi::Uploader& uploader,
                                            rhi::BlasBuilder& builder, rhi::TextureTable& table,
                                            scene::SceneData& scene);

// Whether rays go through the back of a surface as if it were not there.
bool IsBackCulled(const gpu::MaterialRecord& material);

// Gives a material another record, and brings the groups that have it up to date. A BLAS whose geometry flags
// change is added to the builder again, with the memory for its build. On an Error nothing has changed. What
// has:
struct KindChanges {
    bool areStructures = false;  // BLASes wait to be built
    bool areSides = false;       // backs or holes have come or gone
};
KindChanges ChangeMaterial(SceneResources& resources, rhi::BlasBuilder& builder, uint32_t material,
                           const gpu::MaterialRecord& record);

// `values` with the texture fields of `textures`.
gpu::MaterialRecord ToRecord(const scene::Material& values, const gpu::MaterialRecord& textures);

}  // namespace raygraph
