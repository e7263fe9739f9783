// SceneObjects: the geometry, instances, materials, textures and lights of one scene, with the calls that
// add, remove and change them, and the work of a frame for them. Before it, the choice of the origin of the
// device's coordinates. For renderer/gpu_scene alone. Threads: that of the Renderer.
//
// Callers check the arguments, except for AddMesh(scene::Mesh&&), which checks its mesh. An Add... that
// throws leaves everything unchanged.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "renderer/gpu_scene/deform/deform_set.h"
#include "renderer/gpu_scene/geometry/blas_set.h"
#include "renderer/gpu_scene/geometry/wide_set.h"
#include "renderer/gpu_scene/instances/draw_table.h"
#include "renderer/gpu_scene/instances/group_kinds.h"
#include "renderer/gpu_scene/instances/instance_set.h"
#include "renderer/gpu_scene/lights/light_set.h"
#include "renderer/gpu_scene/materials/scene_materials.h"
#include "renderer/gpu_scene/scene_context.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph {

// --- The origin of the device's coordinates ---

// In meters. The origin lies on a grid of this size, and stays until the reference point is farther than this
// along an axis: a camera that moves back and forth does not move it.
inline constexpr double kOriginGrid = 128.0;

// Returns the origin for an eye at this position. The reference point is the point of the scene's box nearest
// to the eye: everything visible is there or beyond. Scenes that are seen within 128 m of the world's origin
// keep (0, 0, 0). `scene` is in world space. Returns `current` for an empty scene and for an eye that is not
// finite.
glm::dvec3 ChooseSceneOrigin(const glm::dvec3& current, const glm::dvec3& eye, const scene::Bounds& scene);

// In meters: up to this distance, the steps of floats are at most 0.06 mm.
inline constexpr double kOriginReach = 1024.0;
inline constexpr uint32_t kFarViewpointsToMove = 8;

// Decides when the origin follows the viewpoint. Alternating viewpoints of several viewports would move it
// back and forth in every frame: while one of the last kFarViewpointsToMove viewpoints was near, the origin
// stays for others within kOriginReach.
class OriginHysteresis {
  public:
    // Tells whether one viewpoint moves the origin; `wanted` is what ChooseSceneOrigin returns.
    bool Moves(const glm::dvec3& current, const glm::dvec3& wanted);

  private:
    // Far viewpoints in a row; the first one moves the origin at once.
    uint32_t m_farCount = kFarViewpointsToMove;
};

// --- The objects of a scene ---

class SceneObjects {
  public:
    // Also allocates the memory in which BLASes are built: if a frame ran out of it, neither that frame nor
    // any later one could be drawn.
    SceneObjects(SceneContext& context, std::unique_ptr<SceneMaterials> newMaterials,
                 std::unique_ptr<SceneGeometry> newGeometry, const scene::SceneData& data);

    uint32_t AddMaterial(const scene::Material& material, std::span<const uint32_t> textures);
    uint32_t AddTexture(const HostTexture& texture);
    // The caller still has to reserve memory for its builds (BlasBuilder::Reserve); the other two overloads
    // do so.
    uint32_t AddMesh(std::vector<GroupResources>&& uploaded);
    uint32_t AddMesh(scene::Mesh&& mesh);
    uint32_t AddMesh(const HostMesh& mesh);
    uint32_t AddInstance(uint32_t mesh, const scene::PlacedTransform& objectToWorld, bool isVisible);
    uint32_t AddLight(const scene::Light& light, bool isVisible, LightOwner place);
    // The following calls remove objects that nothing uses, which the caller has checked.
    void RemoveInstance(uint32_t instance);
    void ReleaseMesh(uint32_t mesh) noexcept;
    void RemoveMaterial(uint32_t material);
    void RemoveTexture(uint32_t texture);
    void RemoveLight(uint32_t light);
    // Removes the objects that the part has added, if it still owns them and nothing else uses them.
    void Remove(const AddedPart& part);

    void SetTransforms(std::span<const uint32_t> indices,
                       std::span<const scene::PlacedTransform> objectToWorld);
    void SetVisible(std::span<const uint32_t> indices, bool isVisible);
    void SetMaterial(uint32_t material, const gpu::MaterialRecord& record);
    void SwapTextures(std::span<const uint32_t> a, std::span<const uint32_t> b);
    void SetVariant(uint32_t variant);
    void SetViewpoint(const glm::dvec3& eye);
    // Chooses the origin by the current instances alone, not by former ones.
    void RestartOrigin();
    void MarkChanged(uint32_t mesh, const scene::Bounds& bounds);

    bool IsMeshUsed(uint32_t mesh) const;
    // Returns whether instances can place the mesh itself: some meshes have only deformed copies on the
    // device.
    bool CanBePlaced(uint32_t mesh) const;
    // Returns whether the mesh was added as a HostMesh.
    bool IsHostMesh(uint32_t mesh) const;
    bool IsDeformed(uint32_t instance) const;
    bool Emits(uint32_t mesh) const;
    // Throws Error{Usage} if the instance does not exist, or no longer does.
    void RequireInstance(uint32_t instance) const;
    void RequireMesh(uint32_t mesh) const;
    void RequireMaterial(uint32_t material) const;
    void RequireTexture(uint32_t texture) const;
    void RequireLight(uint32_t light) const;
    // Throws Error{Usage} naming the call if the skin does not exist or has another number of joints.
    void RequireMatrices(const char* call, uint32_t skin, size_t count) const;
    void RequireWeights(const char* call, uint32_t instance, size_t count) const;

    void Declare(Renderer& renderer, SceneIds& ids);
    bool IsSettled() const;
    void RefreshStatistics() const;

  private:
    void MoveOrigin(const glm::dvec3& wanted);
    // Lets what depends on the kinds of groups follow them.
    void Follow(const KindChanges& changes);
    // Reserves the memory for building a mesh's BLASes. If that fails, it removes the mesh and rethrows.
    void ReserveBuilds(uint32_t mesh);

    SceneContext& m_context;
    glm::dvec3 m_origin{0.0};
    OriginHysteresis m_originHysteresis;
    // By mesh of the host: the instances that place it.
    std::map<uint32_t, std::vector<uint32_t>> m_hostPlacements;

  public:
    // The order matters: members refer to others that are declared before them.
    const std::unique_ptr<SceneMaterials> materials;
    const std::unique_ptr<SceneGeometry> geometry;
    InstanceSet instances;
    BlasSet blases;
    DrawTable draws;
    LightSet lights;
    std::optional<DeformSet> deform;  // nullopt: no mesh is deformed
    std::optional<WideSet> trees;     // nullopt with Traversal::Driver
    ObjectOwners owners;
    // These count the objects that SetScene and Extend added; SetPose requires as many.
    size_t setInstances, setMaterials, setLights;
    const size_t firstExtendedLight;  // by Extend: whether they shine counts for DefaultLight::Auto
};

}  // namespace raygraph
