// LightSet: the lights of the scene on the device. It tracks what has changed since its tables were built.
// Moving, hiding or removing a light, or changing a punctual light, updates its record, its leaf of the light
// tree and the nodes above in place; alias tables are updated only if powers changed. All tables are rebuilt
// when the emission of a material changes, when lights are added, or when most have been removed. When the
// origin moves, all lights are translated. Threads: that of the Renderer.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "renderer/gpu_scene/deform/deform_outline.h"
#include "renderer/gpu_scene/device_array.h"
#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/gpu_scene/instances/instance_set.h"
#include "renderer/gpu_scene/lights/light_table.h"
#include "renderer/gpu_scene/record_table.h"
#include "rhi/device.h"
#include "rhi/transfer.h"

namespace raygraph {

// Who placed a punctual light: the transform of a host must have a direction, that of a node may be
// degenerate.
enum class LightOwner : uint8_t { OfHost, OfNode };

struct LightStatistics {
    uint64_t rebuilds = 0;       // of the tree
    uint64_t updates = 0;        // updates of the tables in place
    uint64_t tableBytes = 0;     // on the device
    uint64_t bytesUploaded = 0;  // bytes uploaded into these tables
};

class LightSet {
  public:
    // Moves the emitters out of `geometry`, and the materials, lights, profiles and instances out of `data`.
    LightSet(rhi::Device& device, rhi::Uploader& uploader, SceneGeometry& geometry,
             std::span<const InstanceSet::Placement> placements, const scene::SceneData& data,
             LightRule rule = LightRule::Decay);

    // --- Adding and removing. Calls that add lights make room for them on the device, at least doubling it.
    // On Error{OutOfMemory} nothing has changed.
    //
    // Adds the emitters of a group that had none; `variants` are their materials in the scene's variants.
    void AddGroup(uint32_t group, std::vector<Emitter> emitters, std::span<const EmitterVariant> variants,
                  bool isDeformed);
    void RemoveGroup(uint32_t group) noexcept;  // requires that the group has no placement left
    // Adds a material at an index that is free or one past the last.
    void AddMaterial(uint32_t material, const glm::vec3& radiance);
    // Adds the placement of a group with that InstanceRecord, if the group has emitters. Transform and
    // visibility are those of the instance, and the same for all its placements.
    void AddPlacement(uint32_t record, uint32_t instance, uint32_t group, const glm::mat4x3& objectToWorld,
                      bool isVisible);
    // Removes all placements of the instance. Does not throw after ReserveRemoval of it.
    void RemovePlacements(uint32_t instance);
    void ReserveRemoval(uint32_t instance);
    // Returns the light's index; indices of removed lights are reused. Errors are those of SetPunctual.
    uint32_t AddPunctual(const scene::Light& values, bool isVisible, LightOwner place = LightOwner::OfHost);
    void RemovePunctual(uint32_t light);  // its slot stays, dark, until it is reused

    // Indices are those of the scene, and in range. Transforms of instances are relative to the scene's
    // origin, those of punctual lights are in world space.
    void SetTransform(uint32_t instance, const glm::mat4x3& objectToWorld);  // requires IsEmitter
    bool IsEmitter(uint32_t instance) const {
        return instance < m_firstPlacement.size() && m_firstPlacement[instance] != kNone;
    }
    void SetVisible(uint32_t instance, bool isVisible);
    void SetEmission(uint32_t material, const glm::vec3& radiance);
    // Moves the emitters of a deformed group, in their order.
    void SetPose(uint32_t group, const OutlinePose& pose);
    // Gives emitters the materials that the parts of their groups now have.
    void SetVariant(const SceneGeometry& geometry, std::span<const gpu::MaterialRecord> materials);
    // Sets whether surfaces of the material emit on both sides.
    void SetSides(uint32_t material, bool isDoubleSided);
    // Throws Error{Usage} for values that no file can have.
    void SetPunctual(uint32_t light, const scene::Light& values, LightOwner place = LightOwner::OfHost);
    const scene::Light& Punctual(uint32_t light) const { return m_punctual[light]; }
    bool HasPunctual(uint32_t light) const {
        return light < PunctualCount() &&
               std::ranges::find(m_removedPunctual, light) == m_removedPunctual.end();
    }
    void SetPunctualVisible(uint32_t light, bool isVisible);
    bool IsPunctualVisible(uint32_t light) const { return !m_scene.isPunctualHidden[light]; }
    // Reads all transforms again, after `instances` has been updated.
    void MoveOrigin(const glm::dvec3& origin, const InstanceSet& instances) noexcept;
    // Groups must have the scene's sizes and be in range.
    void SetGroups(LightGroups groups);
    // Sets the mean radiance over the sphere, and the size of the table from which directions are sampled.
    void SetEnvironment(const glm::vec3& meanRadiance, float skyIrradiance, float rotation, glm::uvec2 cells);

    // Updates the tables, declares their upload, and sets the fields of `ids` that concern lights, except for
    // environmentTable. An upload that is culled, or whose frame is dropped, stays pending. `instances`,
    // which must be declared afterwards, gives the extent that infinite lights shine on, and gets the numbers
    // of its lights.
    void Declare(Renderer& renderer, SceneIds& ids, InstanceSet& instances);

    uint32_t LightCount() const { return m_table.Set().activeCount; }  // number of lights with power above 0
    uint64_t EmissiveTriangleCount() const { return m_table.EmissiveTriangleCount(); }
    uint32_t PunctualCount() const { return static_cast<uint32_t>(m_punctual.size()); }
    const LightStatistics& Statistics() const { return m_statistics; }

  private:
    static constexpr uint32_t kNone = 0xFFFFFFFFu;

    bool HasInfiniteLight() const;
    bool IsMostlyRemoved() const;
    // Returns how many light records a placement of the group takes.
    uint32_t LightsOfOne(uint32_t group) const {
        return m_scene.isShared[group] ? 1u : static_cast<uint32_t>(m_scene.groups[group].size());
    }
    // With LightRule::Decay, a group that is shared stays shared; with Always, each rebuild decides
    // again.
    bool StaysShared() const { return m_rule == LightRule::Decay; }
    void SetPunctual(uint32_t light, scene::Light&& inWorld, scene::Light&& fromOrigin);
    // Returns the values in world space, and relative to the origin.
    std::pair<scene::Light, scene::Light> Checked(const scene::Light& values, uint32_t light,
                                                  LightOwner place) const;
    // Upper bounds of the lights of some placements: as records of their own, as triangles of shared groups,
    // and the number of such groups.
    struct LightCounts {
        uint64_t lights = 0, triangles = 0, meshes = 0;
    };
    LightCounts CountsOf(uint32_t group, uint32_t placementCount) const;
    LightCounts CountsAfter(uint32_t group, uint32_t placementCount) const;
    void ReserveTables(const LightCounts& counts);
    void Place(uint32_t record, uint32_t instance, uint32_t group, const glm::mat4x3& objectToWorld,
               bool isVisible);
    void AssignToRest(std::vector<uint32_t>& groups, uint32_t index);
    void DropRemoved();
    // Renumbers all lights if that is pending.
    void Number();
    // Describes a table of lights or nodes on the device.
    struct Records {
        RecordTable table;
        ChangeList changed;
    };
    void Reserve(Records& records, RecordTableDesc desc);
    void ReserveAlias(uint64_t count);
    void MarkInstanceDirty(uint32_t instance);
    bool MayRefit() const;
    void UpdateTable(InstanceSet& instances);
    void AddDirtyRecords(const LightTableChanges& changes);
    template <typename At>
    BufferId DeclareUpload(Renderer& renderer, Records& records, size_t count, At&& at);
    void RecordAlias(CommandList& commands);

    rhi::Device& m_device;
    LightRule m_rule;
    LightScene m_scene;                    // relative to the origin; of instances, only emitters are updated
    std::vector<scene::Light> m_punctual;  // in world space
    glm::dvec3 m_origin{0.0};
    // By instance, into LightScene::placements; kNone: it does not emit.
    std::vector<uint32_t> m_firstPlacement;
    std::vector<uint32_t> m_nextPlacement;                // by placement: the next one of the same instance
    std::map<uint32_t, std::vector<uint32_t>> m_removed;  // removed placements, by lightCount
    std::vector<uint32_t> m_removedPunctual;
    std::vector<bool> m_isEmitterMaterial;
    std::vector<uint32_t> m_placementCounts;                         // by group: existing placements
    std::map<uint32_t, std::vector<uint32_t>> m_deformedPlacements;  // indexed by group
    LightCounts m_counts;                                            // sum over all placements
    uint64_t m_removedLights = 0;                                    // lights of removed placements
    // Lights of all placements, removed ones included, when they were numbered.
    uint64_t m_numberedLights = 0;

    LightTable m_table;
    LightEdits m_edits;  // edits that are not in the lists below
    ChangeList m_changedPlacements, m_changedPunctual;
    bool m_numberingDirty = true;
    bool m_numbersChanged = true;  // the lights of all instances have to be written into InstanceSet
    // Placements that reuse the numbers of removed ones: only their instances have to be written.
    std::vector<uint32_t> m_newPlacements;
    bool m_aliasDirty = true;
    bool m_meshAliasDirty = true;
    LightStatistics m_statistics;

    // Each has room for at least the records of the scene.
    Records m_lights;
    Records m_nodes;
    rhi::Buffer m_alias;
    DeviceArray<gpu::LightMeshRecord> m_meshes;
    rhi::Buffer m_profiles;  // does not change
    ResourceState m_aliasState;
    ResourceState m_profilesState;
};

}  // namespace raygraph
