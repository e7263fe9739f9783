// DeformSet: the deformed copies of a scene in its frames. It tracks which joints and weights have changed,
// and declares the least work for it: nothing in a frame without a change, and for a copy without a visible
// instance nothing until one is shown.
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
    // `geometry` and `instances` outlive the set; something in them deforms.
    DeformSet(rhi::Device& device, SceneGeometry& geometry, InstanceSet& instances);

    // As many as there are. True if what is visible changes by it. Error{Usage} naming the call for numbers
    // that are not finite.
    bool SetJointMatrices(uint32_t skin, std::span<const glm::mat4x3> matrices);
    bool SetMorphWeights(uint32_t instance, std::span<const float> weights);
    // As SetJointMatrices; but a joint whose matrix is not finite has the identity.
    bool FollowJoints(uint32_t skin, std::span<const glm::mat4x3> matrices);
    uint32_t WeightCount(uint32_t instance) const;
    bool IsDeformed(uint32_t instance) const;

    // Boxes, emitters and draws follow on the host; then the passes that upload what has changed and deform
    // the vertices. Sets `deformedStreams`.
    void DeclareDeformation(Renderer& renderer, SceneIds& ids, LightSet& lights, DrawTable& draws);
    // The copies that are built for the first time, in a pass that the caller declares; told when it is
    // submitted.
    std::vector<DeformedGroup*> UnbuiltGroups();
    static void MarkBuilt(std::span<DeformedGroup* const> groups) noexcept;
    // After builds. Not culled if something needs `blases`.
    void DeclareRefits(Renderer& renderer, SceneIds& ids, rhi::BlasBuilder& builder);

    bool HasWork() const;
    uint64_t DeformCount() const { return m_deformCount; }

  private:
    bool IsVisible(const DeformedMesh& mesh) const;
    // Its pose is to be followed in the next frame.
    bool IsPoseDirty(const DeformedMesh& mesh) const;
    void Follow(DeformedMesh& mesh, LightSet& lights, DrawTable& draws);
    void DeclareUpload(Renderer& renderer);
    void RecordUpload(CommandList& commands);
    void DeclareDeform(Renderer& renderer, SceneIds& ids);

    rhi::Device& m_device;
    SceneGeometry& m_geometry;
    DeformResources& m_deform;
    InstanceSet& m_instances;
    std::vector<gpu::DeformTask> m_tasks;  // of the frame
    uint32_t m_groupCount = 0;
    uint64_t m_deformCount = 0;
    BufferId m_matrices, m_weights, m_taskIds;  // of the frame
    ResourceState m_streamsState, m_recordsState, m_tasksState, m_matricesState, m_weightsState;
};

}  // namespace raygraph
