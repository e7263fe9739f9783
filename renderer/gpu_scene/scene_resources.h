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
    bool isOpaque = true;      // no any-hit shader looks at its alpha
    bool isBackCulled = true;  // its back faces are not there

    bool operator==(const GroupKind&) const = default;
};

// The primitives of a mesh that are of one kind, as one list of triangles in one BLAS: a mesh has up to four
// groups.
struct GroupResources {
    GroupKind kind;
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

// `values` with the texture fields of `textures`.
gpu::MaterialRecord ToRecord(const scene::Material& values, const gpu::MaterialRecord& textures);

}  // namespace raygraph
