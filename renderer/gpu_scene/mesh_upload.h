// Brings packed meshes to the device, all at once or in pieces. Threads: that of the uploader.
#pragma once

#include <cstdint>
#include <vector>

#include "base/disposer.h"
#include "renderer/gpu_scene/mesh_packing.h"
#include "rhi/blas_builder.h"
#include "rhi/upload.h"

namespace raygraph {

// A mesh on the device that has no place in the tables yet: InstanceRecord::firstGeometry counts from the
// first of its own records.
struct UploadedMesh {
    std::vector<GroupResources> groups;
    std::vector<gpu::GeometryRecord> records;
    uint64_t bytes = 0;  // of streams
};

// A triangle that a BLAS is built of counts as much of a frame's budget as so many bytes that are copied.
inline constexpr uint64_t kTriangleCost = 64;

class MeshUpload {
  public:
    explicit MeshUpload(PackedMesh&& mesh) : m_mesh(std::move(mesh)) {}

    // Goes on, and copies at most `budget` bytes, which it counts down, with kTriangleCost for each triangle
    // that is built. True: everything has been copied. Each group is disposed of after its upload. Its BLASes
    // are added to the builder.
    bool Continue(rhi::Device& device, rhi::Uploader& uploader, rhi::BlasBuilder& builder, Disposer& disposer,
                  uint64_t& budget);
    uint64_t CopiedBytes() const { return m_result.bytes + (m_streams ? m_copied : 0); }
    // Once everything has been copied.
    UploadedMesh Take() { return std::move(m_result); }

  private:
    PackedMesh m_mesh;
    UploadedMesh m_result;
    size_t m_group = 0;     // the next one
    rhi::Buffer m_streams;  // of it, once it is begun
    uint64_t m_copied = 0;  // bytes of it
};

// All of it.
UploadedMesh UploadMesh(rhi::Device& device, rhi::Uploader& uploader, rhi::BlasBuilder& builder,
                        Disposer& disposer, PackedMesh&& mesh);

}  // namespace raygraph
