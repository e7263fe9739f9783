// Brings the packed meshes of a scene to the device, each when it is needed, at once or in pieces. For
// renderer/gpu_scene. Threads: that of the uploader.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "renderer/gpu_scene/mesh_packing.h"
#include "renderer/gpu_scene/scene_context.h"
#include "rhi/upload.h"

namespace raygraph {

// A triangle that a BLAS is built of counts as much of a frame's budget as so many bytes that are copied.
inline constexpr uint64_t kTriangleCost = 64;

class MeshUpload {
  public:
    // Refers to all of them. `materials` are the numbers on the device of the meshes' materials, which those
    // of a mesh have before it is complete; empty: they are as the meshes have them.
    MeshUpload(SceneContext& context, rhi::Uploader& uploader, std::span<PackedMesh> meshes,
               std::span<const uint32_t> materials = {});

    // Goes on with the mesh, while no other one is on its way, and copies at most `budget` bytes, which it
    // counts down, with kTriangleCost for each triangle that is built. True: everything has been copied.
    // Where Make may not wait for the device, it returns false instead. Each group is disposed of after its
    // upload. Its BLAS is added to the builder.
    bool Make(uint32_t mesh, uint64_t& budget, bool mayWait = true);
    // The groups of the mesh that has been made.
    std::vector<GroupResources> Take() { return std::exchange(m_groups, {}); }
    // Bytes that all meshes together have to copy, and have copied.
    uint64_t Bytes() const { return m_bytes; }
    uint64_t CopiedBytes() const { return m_copiedBytes; }

  private:
    GroupResources Finish(PackedGroup& group, const PackedMesh& mesh);

    SceneContext& m_context;
    rhi::Uploader& m_uploader;
    std::span<PackedMesh> m_meshes;
    std::span<const uint32_t> m_materials;
    uint64_t m_bytes = 0, m_copiedBytes = 0;
    std::vector<GroupResources> m_groups;  // of the mesh on its way: those that are there
    rhi::Buffer m_streams;                 // of its next one, once that is begun
    uint64_t m_offset = 0;                 // bytes of them that have been copied
};

}  // namespace raygraph
