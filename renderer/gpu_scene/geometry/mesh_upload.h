// Copies the packed meshes of a scene to the device when they are needed, whole or in pieces. For
// renderer/gpu_scene. Threads: that of the uploader.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "renderer/gpu_scene/geometry/mesh_packing.h"
#include "renderer/gpu_scene/scene_context.h"
#include "rhi/upload.h"

namespace raygraph {

// Cost of a triangle whose BLAS is built, in copied bytes of a frame's budget.
inline constexpr uint64_t kTriangleCost = 64;

class MeshUpload {
  public:
    // Keeps references to all arguments. `materials` maps a material index of the meshes to its index on the
    // device; if it is empty, indices do not change. The entries that a mesh uses must be set before the last
    // Make for it.
    MeshUpload(SceneContext& context, rhi::Uploader& uploader, std::span<PackedMesh> meshes,
               std::span<const uint32_t> materials = {});

    // Continues copying the mesh; one mesh is finished before the next is begun. Subtracts from `budget` the
    // copied bytes and kTriangleCost for each triangle. Returns true when the mesh is complete, false if the
    // budget is used up or, with mayWait false, if it would have to wait for the device. Adds the BLAS of
    // each group to the builder and frees its host memory.
    bool Make(uint32_t mesh, uint64_t& budget, bool mayWait = true);
    // Returns the groups of the mesh that is complete.
    std::vector<GroupResources> Take() { return std::exchange(m_groups, {}); }
    // Bytes that all meshes together will have copied in the end, and bytes copied so far.
    uint64_t Bytes() const { return m_bytes; }
    uint64_t CopiedBytes() const { return m_copiedBytes; }

  private:
    GroupResources Finish(PackedGroup& group, const PackedMesh& mesh);

    SceneContext& m_context;
    rhi::Uploader& m_uploader;
    std::span<PackedMesh> m_meshes;
    std::span<const uint32_t> m_materials;
    uint64_t m_bytes = 0, m_copiedBytes = 0;
    std::vector<GroupResources> m_groups;  // the finished groups of the current mesh
    rhi::Buffer m_streams;                 // streams of the group that is being copied
    uint64_t m_offset = 0;                 // bytes of m_streams that have been copied
};

}  // namespace raygraph
