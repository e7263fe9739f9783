// The deformed copies of a scene: the resources of skinned and morphed meshes, and DeformSet, which updates
// the copies in each frame. Threads: that of the Renderer.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "renderer/gpu_scene/deform/deform_outline.h"
#include "renderer/gpu_scene/geometry/blas_set.h"
#include "renderer/gpu_scene/geometry/scene_geometry.h"
#include "renderer/gpu_scene/geometry/stream_packer.h"
#include "renderer/gpu_scene/instances/draw_table.h"
#include "renderer/gpu_scene/instances/instance_set.h"
#include "renderer/gpu_scene/lights/light_set.h"
#include "shaders/shared/deform_records.h"

namespace raygraph {

// --- Resources of skinned and morphed meshes, created by SetScene ---
// A group that may deform stores joints, weights and morph targets beside its vertex streams. Each deformed
// copy of a mesh (deform_outline.h) has groups with positions, normals and tangents of their own; all other
// streams are shared with the mesh.

struct SceneContext;

// Holds the shape of a group as the file has it.
struct BaseShape {
    struct Part {
        gpu::DeformRecord record{};                // without output addresses and fields of a copy
        uint64_t targets = StreamPacker::kAbsent;  // offset of its DeformTarget[]
        uint32_t firstVertex = 0;                  // index of the part's first vertex in the group
    };
    uint32_t vertexCount = 0;
    std::vector<Part> parts = {};
    DeformOutline outline;
};

// Returns whether joints or morph targets move some vertex.
bool MayDeform(std::span<scene::Primitive* const> primitives);
// Appends joints, weights and targets of the primitive. Address fields hold offsets until
// ResolveBaseAddresses.
void PackDeformInputs(const scene::Primitive& primitive, StreamPacker& packer, BaseShape& base);
// Turns the part's offsets into addresses. `geometry` and `positions` must still hold offsets.
void ResolveBaseAddresses(BaseShape::Part& part, const gpu::GeometryRecord& geometry, uint64_t positions,
                          uint64_t firstVertex, VkDeviceAddress start, StreamPacker& packer);

struct DeformedGroup {
    uint32_t group = 0;  // index into SceneGeometry::groups
    OutlinePose pose;    // as the joints and weights are now
    RefitQuality quality;
    bool refitPending = false;    // the vertices have changed since the BLAS was built or refitted
    bool rebuildPending = false;  // refits have degraded the BLAS
};

struct DeformedMesh {
    std::vector<uint32_t> instances;
    uint32_t mesh = 0;  // index into SceneGeometry::meshes
    uint32_t skin = scene::kNone;
    uint32_t firstWeight = 0, weightCount = 0;
    uint32_t firstRecord = 0, recordCount = 0;  // index into DeformResources::records
    std::vector<DeformedGroup> groups;
    bool poseDirty = false;      // joints or weights changed, and Follow has not run since
    bool deformPending = false;  // Follow has run, and the device has yet to deform the vertices
    bool weightsDirty = true;    // the weights have yet to be uploaded
};

struct SkinMatrices {
    uint32_t first = 0, count = 0;  // into DeformResources::matrices; none for a skin that moves nothing
    bool isDirty = false;           // they have changed since they were uploaded
};

struct DeformResources {
    std::vector<DeformedMesh> meshes;
    std::vector<uint32_t> meshOf;     // by instance; kNone: it is not deformed
    std::vector<SkinMatrices> skins;  // by skin of the scene
    std::vector<glm::mat4x3> matrices;
    std::vector<float> weights;
    std::vector<gpu::DeformRecord> records;

    rhi::Buffer streams;  // deformed positions, normals and tangents
    rhi::Buffer recordBuffer, taskBuffer, matrixBuffer, weightBuffer;

    std::span<const glm::mat4x3> MatricesOf(const DeformedMesh& mesh) const;
    std::span<const float> WeightsOf(const DeformedMesh& mesh) const;
    // Updates the poses on the host, and the boxes of the groups. The device follows later.
    void Follow(DeformedMesh& mesh, SceneGeometry& geometry) const;
};

// Moves the emitters of a group to where its pose has them.
void PoseEmitters(const OutlinePose& pose, std::span<Emitter> emitters);

// The form in which a mesh that nothing deforms is kept for software traversal.
enum class WideBvhUse {
    None,
    Triangles,  // a WideMesh whose tree is not built
    Tree,
};

// How a mesh is drawn.
struct MeshUse {
    bool isDeformed = false;  // deformed copies of it exist
    bool isBaseDrawn = true;  // the shape that the file has is drawn
    WideBvhUse tree = WideBvhUse::None;
    uint32_t bvhThreads = 0;  // threads that build the BVH; 0: one per core
};

// Appends the plan's copies to `geometry`, which must hold all meshes of the scene in their order, and
// creates their buffers, records and BLASes.
void AddDeformedCopies(SceneContext& context, const scene::SceneData& scene, const DeformPlan& plan,
                       SceneGeometry& geometry);

// DeformSet tracks which joints and weights have changed, and declares the least work for them: none in a
// frame without a change, and none for a copy of which no instance is visible until one is shown.
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
