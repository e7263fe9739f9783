// DeformSet updates the deformed copies of a scene in each frame. It tracks which joints and weights have
// changed, and declares the least work for them: none in a frame without a change, and none for a copy of
// which no instance is visible until one is shown. Threads: that of the Renderer.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "renderer/gpu_scene/deform/deform_resources.h"
#include "renderer/gpu_scene/instances/draw_table.h"
#include "renderer/gpu_scene/instances/instance_set.h"
#include "renderer/gpu_scene/lights/light_set.h"

namespace raygraph {

class DeformSet {
  public:
    // `geometry` and `instances` outlive the set. At least one mesh of theirs deforms.
    DeformSet(rhi::Device& device, SceneGeometry& geometry, InstanceSet& instances);

    // `matrices` has one matrix per joint of the skin. Returns true if anything visible changes. Throws
    // Error{Usage} naming the call for numbers that are not finite.
    bool SetJointMatrices(uint32_t skin, std::span<const glm::mat4x3> matrices);
    bool SetMorphWeights(uint32_t instance, std::span<const float> weights);
    // Does the same, but gives a joint whose matrix is not finite the identity instead of throwing.
    bool FollowJoints(uint32_t skin, std::span<const glm::mat4x3> matrices);
    uint32_t WeightCount(uint32_t instance) const;
    bool IsDeformed(uint32_t instance) const;

    // Updates boxes, emitters and draws on the host, and declares the passes that upload the changes and
    // deform the vertices. Sets `deformedStreams`.
    void DeclareDeformation(Renderer& renderer, SceneIds& ids, LightSet& lights, DrawTable& draws);
    // Returns the copies whose first build a pass of the caller does. They are marked built when it is
    // submitted.
    std::vector<DeformedGroup*> UnbuiltGroups();
    static void MarkBuilt(std::span<DeformedGroup* const> groups) noexcept;
    // Must be declared after builds. The passes are not culled if something needs `blases`.
    void DeclareRefits(Renderer& renderer, SceneIds& ids, rhi::BlasBuilder& builder);

    bool HasWork() const;
    uint64_t DeformCount() const { return m_deformCount; }

  private:
    bool IsVisible(const DeformedMesh& mesh) const;
    // Tells whether the next frame has to update its pose.
    bool IsPoseDirty(const DeformedMesh& mesh) const;
    void Follow(DeformedMesh& mesh, LightSet& lights, DrawTable& draws);
    void DeclareUpload(Renderer& renderer);
    void RecordUpload(CommandList& commands);
    void DeclareDeform(Renderer& renderer, SceneIds& ids);

    rhi::Device& m_device;
    SceneGeometry& m_geometry;
    DeformResources& m_deform;
    InstanceSet& m_instances;
    std::vector<gpu::DeformTask> m_tasks;  // those of the current frame
    uint32_t m_groupCount = 0;
    uint64_t m_deformCount = 0;
    BufferId m_matrices, m_weights, m_taskIds;  // those of the current frame
    ResourceState m_streamsState, m_recordsState, m_tasksState, m_matricesState, m_weightsState;
};

}  // namespace raygraph
