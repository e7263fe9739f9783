// The meshes of a scene on the device: vertex streams, BLASes and the table of geometries. Adding or removing
// a mesh does not change the numbers of others. Threads: that of the Renderer.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "renderer/gpu_scene/device_array.h"
#include "renderer/gpu_scene/lights/emitters.h"
#include "renderer/gpu_scene/lights/light_table.h"
#include "renderer/gpu_scene/record_table.h"
#include "renderer/scene/model/scene_data.h"
#include "rhi/blas_builder.h"
#include "rhi/device.h"
#include "rhi/resources.h"
#include "rhi/transfer.h"
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
    bool isThinWall = false;   // some part is a smooth thin wall: shadow rays pass through it
    bool isRound = false;      // found by an intersection shader

    bool operator==(const GroupKind&) const = default;
};

// Holds the material of a part in a variant of the scene.
struct PartVariant {
    uint32_t variant = scene::kNone;
    uint32_t material = 0;
};

// Holds the inputs from which a part's kind is found, kept after the primitive has been freed.
struct GroupPart {
    uint32_t material = 0;
    float lowestAlpha = 1.0f;                // of vertex colors
    std::vector<PartVariant> variants = {};  // as Primitive::variants
    bool isRound = false;
    bool isShadowCatcher = false;  // as its material, in which no edit changes it
};

inline gpu::InstanceRecord EmptyInstanceRecord() {
    gpu::InstanceRecord record{};
    record.draw = gpu::kNotDrawn;
    return record;
}

// Holds the primitives of a mesh that were of one kind when the scene was set, as one list of triangles or of
// capsules in one BLAS: a mesh has up to six groups of either. A changed material may turn a group of one
// kind into one of several.
struct GroupResources {
    GroupKind kind;
    std::vector<GroupPart> parts;
    rhi::Buffer streams;
    std::shared_ptr<rhi::Blas> blas;
    VkDeviceAddress hostBlas = 0;                        // a BLAS of the host that is used instead
    gpu::InstanceRecord record = EmptyInstanceRecord();  // without transform, instance and firstLight
    std::vector<gpu::GeometryRecord> records;            // one per part, until SceneGeometry takes them
    std::vector<Emitter> emitters;                       // until they are moved into the light set
    std::vector<EmitterVariant> emitterVariants;
    uint64_t triangleCount = 0;  // 0 for round primitives
    uint32_t capsuleCount = 0;   // 0 for triangles
    scene::Bounds bounds;        // object space
    // Not null if the group can be deformed. `blas` is null where only deformed copies are drawn.
    std::shared_ptr<const BaseShape> base;
    std::shared_ptr<WideMesh> tree;  // for software traversal, moved into WideSet; null: none

    VkDeviceAddress BlasAddress() const { return hostBlas != 0 ? hostBlas : blas->Address(); }
    // Tells whether raster views draw the group. They draw neither one that has been removed nor a ground.
    bool IsDrawn() const {
        const bool isGround = !parts.empty() && std::ranges::all_of(parts, &GroupPart::isShadowCatcher);
        return !kind.isRound && !isGround && triangleCount > 0;
    }
};

struct MeshResources {
    uint32_t firstGroup = 0;
    uint32_t groupCount = 0;
    uint64_t triangleCount = 0;
    uint32_t instanceCount = 0;
    bool isDeformed = false;  // it has deformed copies, or is one
    bool isCopy = false;      // it is a deformed copy of a mesh that is listed before
    bool exists = true;
};

struct SceneGeometry {
    // Makes geometry without a device, for tests.
    SceneGeometry();
    explicit SceneGeometry(rhi::Device& device);
    SceneGeometry(SceneGeometry&&) noexcept;
    ~SceneGeometry();

    // Allocates slots for the groups of a mesh, and returns its number. Its parts count as users of their
    // materials. On an Error nothing has changed.
    uint32_t AddMesh(std::vector<GroupResources>&& mesh, SceneMaterials& materials);
    // Removes a mesh that no instance places.
    void RemoveMesh(uint32_t mesh, SceneMaterials& materials) noexcept;
    // Allocates the slots of meshes, groups and geometries that were appended without one.
    void AllocateSlots();
    bool HasMesh(uint32_t mesh) const { return mesh < meshes.size() && meshes[mesh].exists; }
    std::span<GroupResources> GroupsOf(const MeshResources& mesh) {
        return std::span(groups).subspan(mesh.firstGroup, mesh.groupCount);
    }
    std::span<const GroupResources> GroupsOf(const MeshResources& mesh) const {
        return std::span(groups).subspan(mesh.firstGroup, mesh.groupCount);
    }

    std::vector<MeshResources> meshes;  // of the scene, in its order; then copies
    std::vector<uint32_t> meshOf;       // by instance: the mesh or deformed copy that it places
    std::vector<GroupResources> groups;
    DeviceArray<gpu::GeometryRecord> records;
    std::unique_ptr<DeformResources> deform;  // null: no mesh is deformed
    uint32_t variantCount = 0;
    uint32_t variant = scene::kNone;  // the variant that is shown
    uint64_t streamBytes = 0;
    bool hasVertexColors = false;  // some mesh has or had vertex colors: pipelines differ by it
    // Gpu::kTangents* of all meshes that exist or existed: pipelines differ by it.
    uint32_t tangentSets = 0;

  private:
    SlotRanges m_meshSlots, m_groupSlots, m_recordSlots;
};

}  // namespace raygraph
