// What SetScene creates on the device: vertex streams, BLASes, textures, geometry and material tables.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "renderer/gpu_scene/emitters.h"
#include "renderer/gpu_scene/light_table.h"
#include "renderer/scene/scene_data.h"
#include "rhi/blas_builder.h"
#include "rhi/device.h"
#include "rhi/resources.h"
#include "rhi/texture_table.h"
#include "rhi/upload.h"
#include "shaders/shared/scene_records.h"

namespace raygraph {

struct BaseShape;
struct DeformResources;

// How rays treat a primitive.
struct GroupKind {
    bool isOpaque = true;      // opaque to rays of all types: no any-hit shader
    bool isBackCulled = true;  // its back faces are culled
    bool isThinWall = false;   // a smooth thin wall somewhere: shadow rays pass through it
    bool isRound = false;      // found by an intersection shader

    bool operator==(const GroupKind&) const = default;
};

// What a part is in a variant of the scene.
struct PartVariant {
    uint32_t variant = scene::kNone;
    uint32_t material = 0;
    float lowestAlpha = 1.0f;
};

// The inputs of a primitive's kind, kept after the primitive itself has been freed.
struct GroupPart {
    uint32_t material = 0;
    float lowestAlpha = 1.0f;                // of vertex colors times the base color's texture
    std::vector<PartVariant> variants = {};  // as Primitive::variants
    bool isRound = false;
};

// The primitives of a mesh that were of one kind when the scene was set, as one list of triangles or of
// capsules in one BLAS: a mesh has up to six groups of either. A changed material may turn a group of one
// kind into one of several.
struct GroupResources {
    GroupKind kind;
    std::vector<GroupPart> parts;
    rhi::Buffer streams;
    std::shared_ptr<rhi::Blas> blas;
    gpu::InstanceRecord record{};   // but for transform, instance and firstLight
    std::vector<Emitter> emitters;  // until they are moved into the light set
    std::vector<EmitterVariant> emitterVariants;
    uint64_t triangleCount = 0;  // 0 of round primitives
    scene::Bounds bounds;        // object space
    // Not null: the group can be deformed. `blas` is null where only its copies are drawn.
    std::shared_ptr<const BaseShape> base;
};

struct MeshResources {
    uint32_t firstGroup = 0;
    uint32_t groupCount = 0;
    uint64_t triangleCount = 0;
    bool isCopy = false;  // a deformed one, of another that is listed before
};

// What a texture of the scene is on the device. Textures that differ in their samplers alone share an image.
struct TextureResources {
    uint32_t image = 0;    // into SceneResources::textureImages
    uint32_t sampler = 0;  // into SceneResources::samplers
    uint32_t slot = 0;     // of the texture table
};

struct SceneResources {
    SceneResources();
    ~SceneResources();

    std::vector<MeshResources> meshes;  // of the scene, in its order; then copies
    std::vector<uint32_t> meshOf;       // by instance: the mesh or copy that it places
    std::vector<GroupResources> groups;
    std::vector<rhi::Sampler> samplers;
    std::vector<rhi::Texture> textureImages;
    std::vector<TextureResources> textures;           // of the scene, in its order
    std::unique_ptr<rhi::TextureTable> textureTable;  // of their number; declared after what is in it
    std::vector<gpu::MaterialRecord> materialRecords;
    std::vector<uint32_t> usedMaterials;  // by some triangle, ascending
    uint32_t variantCount = 0;
    uint32_t variant = scene::kNone;                   // the one shown
    std::vector<gpu::GeometryRecord> geometryRecords;  // empty if there are no variants
    rhi::Buffer geometries;                            // gpu::GeometryRecord[]
    rhi::Buffer materials;                             // gpu::MaterialRecord[]
    std::unique_ptr<DeformResources> deform;           // null: nothing is deformed
    uint32_t geometryCount = 0;
    uint64_t geometryBytes = 0;
    uint64_t textureBytes = 0;
    uint32_t reducedTextures = 0;  // smaller than their images, to fit the budget
    std::string textureReduction;  // says so, if there are any
};

// Of all groups of a mesh; object space.
scene::Bounds BoundsOf(const SceneResources& resources, const MeshResources& mesh);
// Triangles of all meshes, and of all that instances place.
uint64_t TriangleCount(const SceneResources& resources);
uint64_t TriangleCount(const SceneResources& resources, std::span<const scene::Instance> instances);

struct TextureUploadSettings;

// Uploads everything but the instances, and adds the BLASes to the builder. Frees each mesh and image of
// `scene` after its upload. `textures.defaultTexture` outlives what is returned.
std::unique_ptr<SceneResources> UploadScene(rhi::Device& device, rhi::Uploader& uploader,
                                            rhi::BlasBuilder& builder, scene::SceneData& scene,
                                            const TextureUploadSettings& textures);

}  // namespace raygraph
