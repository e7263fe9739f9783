// The meshes of a scene on the device: vertex streams, BLASes and the table of geometries. Meshes come and
// go; the others keep their numbers. Threads: those of the Renderer.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "renderer/gpu_scene/device_array.h"
#include "renderer/gpu_scene/lights/emitters.h"
#include "renderer/gpu_scene/lights/light_table.h"
#include "renderer/gpu_scene/slot_ranges.h"
#include "renderer/scene/model/scene_data.h"
#include "rhi/blas_builder.h"
#include "rhi/device.h"
#include "rhi/resources.h"
#include "rhi/upload.h"
#include "shaders/shared/scene_records.h"

namespace raygraph {

class SceneMaterials;
struct BaseShape;
struct DeformResources;
struct WideMesh;

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

inline gpu::InstanceRecord EmptyInstanceRecord() {
    gpu::InstanceRecord record{};
    record.draw = gpu::kNotDrawn;
    return record;
}

// The primitives of a mesh that were of one kind when the scene was set, as one list of triangles or of
// capsules in one BLAS: a mesh has up to six groups of either. A changed material may turn a group of one
// kind into one of several.
struct GroupResources {
    GroupKind kind;
    std::vector<GroupPart> parts;
    rhi::Buffer streams;
    std::shared_ptr<rhi::Blas> blas;
    VkDeviceAddress hostBlas = 0;                        // a host's own, in its place
    gpu::InstanceRecord record = EmptyInstanceRecord();  // but for transform, instance and firstLight
    std::vector<gpu::GeometryRecord> records;            // one a part, until SceneGeometry takes them
    std::vector<Emitter> emitters;                       // until they are moved into the light set
    std::vector<EmitterVariant> emitterVariants;
    uint64_t triangleCount = 0;  // 0 of round primitives
    scene::Bounds bounds;        // object space
    // Not null: the group can be deformed. `blas` is null where only its copies are drawn.
    std::shared_ptr<const BaseShape> base;
    std::shared_ptr<WideMesh> tree;  // for own traversal, taken by WideSet; null: it has none

    VkDeviceAddress BlasAddress() const { return hostBlas != 0 ? hostBlas : blas->Address(); }
    // Returns whether raster views draw it, which they do not once the group has been removed.
    bool IsDrawn() const { return !kind.isRound && triangleCount > 0; }
};

struct MeshResources {
    uint32_t firstGroup = 0;
    uint32_t groupCount = 0;
    uint64_t triangleCount = 0;
    uint32_t instanceCount = 0;
    bool isDeformed = false;  // there are copies of it, or it is one
    bool isCopy = false;      // a deformed one, of another that is listed before
    bool exists = true;
};

struct SceneGeometry {
    // Makes geometry that the host alone has, for tests.
    SceneGeometry();
    explicit SceneGeometry(rhi::Device& device);
    SceneGeometry(SceneGeometry&&) noexcept;
    ~SceneGeometry();

    // Gives the groups of a mesh places, and returns its number; its parts count as users of their materials.
    // On an Error nothing has changed.
    uint32_t AddMesh(std::vector<GroupResources>&& mesh, SceneMaterials& materials);
    // Removes a mesh that nothing places.
    void RemoveMesh(uint32_t mesh, SceneMaterials& materials) noexcept;
    // Takes the slots of meshes, groups and geometries that were appended without a number.
    void AllocateSlots();
    bool HasMesh(uint32_t mesh) const { return mesh < meshes.size() && meshes[mesh].exists; }
    std::span<GroupResources> GroupsOf(const MeshResources& mesh) {
        return std::span(groups).subspan(mesh.firstGroup, mesh.groupCount);
    }
    std::span<const GroupResources> GroupsOf(const MeshResources& mesh) const {
        return std::span(groups).subspan(mesh.firstGroup, mesh.groupCount);
    }

    std::vector<MeshResources> meshes;  // of the scene, in its order; then copies
    std::vector<uint32_t> meshOf;       // by instance: the mesh or copy that it places
    std::vector<GroupResources> groups;
    DeviceArray<gpu::GeometryRecord> records;
    std::unique_ptr<DeformResources> deform;  // null: nothing is deformed
    uint32_t variantCount = 0;
    uint32_t variant = scene::kNone;  // the one shown
    uint64_t streamBytes = 0;
    bool hasVertexColors = false;  // some mesh has or had them: pipelines differ by it
    uint32_t tangentSets = 0;      // gpu::kTangents* of all meshes that are or were there; likewise

  private:
    SlotRanges m_meshSlots, m_groupSlots, m_recordSlots;
};

}  // namespace raygraph
