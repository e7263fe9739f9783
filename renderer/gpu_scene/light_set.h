// LightSet: the lights of the scene on the device. It tracks what has changed since its tables were built,
// and rebuilds them only when an emitter's transform, visibility or emission changed, or when infinite lights
// shine on much more or less of the scene because something was shown, hidden or moved. When the origin
// moves, all lights are translated.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/gpu_scene/deform_outline.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/gpu_scene/instance_set.h"
#include "renderer/gpu_scene/light_table.h"
#include "renderer/gpu_scene/scene_resources.h"
#include "rhi/device.h"
#include "rhi/upload.h"

namespace raygraph {

// Where a punctual light comes from: a host's must have a direction, a node may be scaled to nothing.
enum class LightPlace : uint8_t { OfHost, OfNode };

class LightSet {
  public:
    // Takes the emitters of `resources`; of `data` the materials, lights, profiles and instances.
    LightSet(rhi::Device& device, rhi::Uploader& uploader, SceneResources& resources,
             std::span<const InstanceSet::Placement> placements, const scene::SceneData& data);

    // Indices are those of the scene, and in range. Transforms of instances are from the scene's origin;
    // those of punctual lights in the world.
    void SetTransform(uint32_t instance, const glm::mat4x3& objectToWorld);  // of an emitter
    bool IsEmitter(uint32_t instance) const { return m_isEmitterInstance[instance]; }
    void SetVisible(uint32_t instance, bool isVisible);
    void SetEmission(uint32_t material, const glm::vec3& radiance);
    // The emitters of a group are at other places, in their order.
    void SetPose(uint32_t group, const OutlinePose& pose);
    // Emitters get the materials that the parts of their groups have by now.
    void SetVariant(const SceneResources& resources);
    // Whether surfaces of the material emit on both sides.
    void SetSides(uint32_t material, bool isDoubleSided);
    // Error{Usage} for values that no file can have.
    void SetPunctual(uint32_t light, const scene::Light& values, LightPlace place = LightPlace::OfHost);
    const scene::Light& Punctual(uint32_t light) const { return m_punctual[light]; }
    void SetPunctualVisible(uint32_t light, bool isVisible);
    bool IsPunctualVisible(uint32_t light) const { return !m_scene.isPunctualHidden[light]; }
    // Reads all transforms again, after `instances` has been updated.
    void MoveOrigin(const glm::dvec3& origin, const InstanceSet& instances) noexcept;
    // Of the scene's sizes, and in range.
    void SetGroups(LightGroups groups);
    // Mean radiance over the sphere, and the table that chooses directions.
    void SetEnvironment(const glm::vec3& meanRadiance, float rotation, glm::uvec2 cells);

    // Builds the tables if something has changed, declares their upload, and sets the fields of `ids` that
    // have to do with lights but for environmentAlias. An upload that is culled, or whose frame is dropped,
    // stays pending. `instances` tells what infinite lights shine on.
    void Declare(Renderer& renderer, SceneIds& ids, InstanceSet& instances);

    uint32_t LightCount() const { return m_table.set.activeCount; }  // those with power above 0
    uint32_t EmissiveTriangleCount() const { return m_table.emissiveTriangleCount; }
    uint32_t PunctualCount() const { return static_cast<uint32_t>(m_punctual.size()); }
    uint64_t RebuildCount() const { return m_rebuildCount; }

  private:
    bool HasInfiniteLight() const;
    void RecordUpload(CommandList& commands);

    rhi::Device& m_device;
    LightScene m_scene;                    // from the origin; of instances, only emitters are kept up to date
    std::vector<scene::Light> m_punctual;  // in the world
    glm::dvec3 m_origin{0.0};
    std::vector<bool> m_isEmitterInstance;
    std::vector<bool> m_isEmitterMaterial;
    LightTable m_table;
    bool m_isTableDue = true;
    bool m_arePlacesDue = false;  // the origin has moved
    bool m_isUploadDue = true;
    bool m_isAliasUploadDue = true;
    uint64_t m_rebuildCount = 0;

    rhi::Buffer m_lights;  // as many as the scene can have; likewise the others
    rhi::Buffer m_nodes;
    rhi::Buffer m_alias;
    rhi::Buffer m_profiles;  // does not change
    ResourceState m_lightsState;
    ResourceState m_nodesState;
    ResourceState m_aliasState;
    ResourceState m_profilesState;
};

}  // namespace raygraph
