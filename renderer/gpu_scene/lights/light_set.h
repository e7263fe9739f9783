// LightSet: the lights of the scene on the device. It tracks what has changed since its tables were built.
// Moving, hiding or removing a light, or changing a punctual light, updates its record, its leaf of the light
// tree and the nodes above in place; alias tables only if powers changed. All tables are built again when the
// emission of a material changes, lights are added, or most have been removed. When the origin moves, all
// lights are translated.
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
#include "renderer/gpu_scene/lights/change_list.h"
#include "renderer/gpu_scene/lights/light_table.h"
#include "renderer/gpu_scene/record_table.h"
#include "rhi/device.h"
#include "rhi/upload.h"

namespace raygraph {

// Who placed a punctual light: a host's transform is checked to have a direction, a node's may be degenerate.
enum class LightOwner : uint8_t { OfHost, OfNode };

struct LightStatistics {
    uint64_t rebuilds = 0;       // of the tree
    uint64_t updates = 0;        // of the tables, in place
    uint64_t tableBytes = 0;     // on the device
    uint64_t bytesUploaded = 0;  // into these
};

class LightSet {
  public:
    // Takes the emitters of `geometry`; of `data` the materials, lights, profiles and instances.
    LightSet(rhi::Device& device, rhi::Uploader& uploader, SceneGeometry& geometry,
             std::span<const InstanceSet::Placement> placements, const scene::SceneData& data,
             LightRule rule = LightRule::Decay);

    // --- Objects that come and go. What adds lights makes room for them on the device: at least twice of
    // what there was. Error{OutOfMemory}: nothing has changed.
    //
    // The emitters of a group that had none; `variants` are what they may become.
    void AddGroup(uint32_t group, std::vector<Emitter> emitters, std::span<const EmitterVariant> variants,
                  bool isDeformed);
    void RemoveGroup(uint32_t group) noexcept;  // requires that no placement of it is left
    // Adds a material at that index, which is free or one past the last.
    void AddMaterial(uint32_t material, const glm::vec3& radiance);
    // Adds the placement of a group by that InstanceRecord, if the group has emitters. The transform and the
    // visibility are those of the instance, the same for all its placements.
    void AddPlacement(uint32_t record, uint32_t instance, uint32_t group, const glm::mat4x3& objectToWorld,
                      bool isVisible);
    // Removes all placements of the instance. Throws nothing after ReserveRemoval of it.
    void RemovePlacements(uint32_t instance);
    void ReserveRemoval(uint32_t instance);
    // Returns the light's index; indices of removed lights are used again. Errors as SetPunctual.
    uint32_t AddPunctual(const scene::Light& values, bool isVisible, LightOwner place = LightOwner::OfHost);
    void RemovePunctual(uint32_t light);  // its slot stays, dark, until it is used again

    // Indices are those of the scene, and in range. Transforms of instances are from the scene's origin;
    // those of punctual lights in the world.
    void SetTransform(uint32_t instance, const glm::mat4x3& objectToWorld);  // requires IsEmitter
    bool IsEmitter(uint32_t instance) const {
        return instance < m_firstPlacement.size() && m_firstPlacement[instance] != kNone;
    }
    void SetVisible(uint32_t instance, bool isVisible);
    void SetEmission(uint32_t material, const glm::vec3& radiance);
    // The emitters of a deformed group are at other places, in their order.
    void SetPose(uint32_t group, const OutlinePose& pose);
    // Emitters get the materials that the parts of their groups have by now.
    void SetVariant(const SceneGeometry& geometry, std::span<const gpu::MaterialRecord> materials);
    // Whether surfaces of the material emit on both sides.
    void SetSides(uint32_t material, bool isDoubleSided);
    // Error{Usage} for values that no file can have.
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
    // Of the scene's sizes, and in range.
    void SetGroups(LightGroups groups);
    // Mean radiance over the sphere, and the table that chooses directions.
    void SetEnvironment(const glm::vec3& meanRadiance, float rotation, glm::uvec2 cells);

    // Brings the tables up to date, declares their upload, and sets the fields of `ids` that have to do with
    // lights but for environmentTable. An upload that is culled, or whose frame is dropped, stays pending.
    // `instances`, which are declared after this, tell what infinite lights shine on, and are told the
    // numbers of their lights.
    void Declare(Renderer& renderer, SceneIds& ids, InstanceSet& instances);

    uint32_t LightCount() const { return m_table.Set().activeCount; }  // those with power above 0
    uint64_t EmissiveTriangleCount() const { return m_table.EmissiveTriangleCount(); }
    uint32_t PunctualCount() const { return static_cast<uint32_t>(m_punctual.size()); }
    const LightStatistics& Statistics() const { return m_statistics; }

  private:
    static constexpr uint32_t kNone = 0xFFFFFFFFu;

    bool HasInfiniteLight() const;
    bool AreMostRemoved() const;
    // Returns how many light records a placement of the group takes.
    uint32_t LightsOfOne(uint32_t group) const {
        return m_scene.isShared[group] ? 1u : static_cast<uint32_t>(m_scene.groups[group].size());
    }
    // LightRule::Decay keeps groups shared once they are; Always decides anew.
    bool StaysShared() const { return m_rule == LightRule::Decay; }
    void SetPunctual(uint32_t light, scene::Light&& inWorld, scene::Light&& fromOrigin);
    // The values in the world, and from the origin.
    std::pair<scene::Light, scene::Light> Checked(const scene::Light& values, uint32_t light,
                                                  LightOwner place) const;
    // Lights of some placements, at most: as records of their own, as triangles of shared groups, and how
    // many such groups there are.
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
    // Numbers all lights again if that is due.
    void Number();
    // A table of lights or nodes.
    struct Records {
        RecordTable table;
        ChangeList changed;
    };
    void Reserve(Records& records, RecordTableDesc desc);
    void ReserveAlias(uint64_t count);
    void MarkInstanceDirty(uint32_t instance);
    bool MayRefit() const;
    void UpdateTable(InstanceSet& instances);
    void NoteChanges(const LightTableChanges& changes);
    template <typename At>
    BufferId DeclareUpload(Renderer& renderer, Records& records, size_t count, At&& at);
    void RecordAlias(CommandList& commands);

    rhi::Device& m_device;
    LightRule m_rule;
    LightScene m_scene;                    // from the origin; of instances, only emitters are kept up to date
    std::vector<scene::Light> m_punctual;  // in the world
    glm::dvec3 m_origin{0.0};
    std::vector<uint32_t> m_firstPlacement;  // by instance, into LightScene::placements; kNone: no emitter
    std::vector<uint32_t> m_nextPlacement;   // by placement, of the same instance
    std::map<uint32_t, std::vector<uint32_t>> m_removed;  // placements, by lightCount
    std::vector<uint32_t> m_removedPunctual;
    std::vector<bool> m_isEmitterMaterial;
    std::vector<uint32_t> m_placementCounts;                         // by group; those that are there
    std::map<uint32_t, std::vector<uint32_t>> m_deformedPlacements;  // by group
    LightCounts m_counts;                                            // of all of them
    uint64_t m_removedLights = 0;                                    // of placements that were removed
    uint64_t m_numberedLights = 0;  // of all placements, removed ones included, when they were numbered

    LightTable m_table;
    LightEdits m_edits;  // edits that the lists below do not hold
    ChangeList m_changedPlacements, m_changedPunctual;
    bool m_numberingDirty = true;
    bool m_numbersChanged = true;           // all instances have yet to be told their lights
    std::vector<uint32_t> m_newPlacements;  // only the instances of these have, as they took free lights
    bool m_aliasDirty = true;
    bool m_meshAliasDirty = true;
    LightStatistics m_statistics;

    // Each has room for at least what the scene has.
    Records m_lights;
    Records m_nodes;
    rhi::Buffer m_alias;
    DeviceArray<gpu::LightMeshRecord> m_meshes;
    rhi::Buffer m_profiles;  // does not change
    ResourceState m_aliasState;
    ResourceState m_profilesState;
};

}  // namespace raygraph
