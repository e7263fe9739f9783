#include "renderer/gpu_scene/mesh_upload.h"

#include <algorithm>
#include <utility>

#include "renderer/gpu_scene/group_kinds.h"

namespace raygraph {
namespace {

// The places of a group, once it has a buffer at `start`.
void PlaceGroup(PackedGroup& group, VkDeviceAddress start) {
    for (size_t i = 0; i < group.records.size(); ++i) {
        gpu::GeometryRecord& record = group.records[i];
        const uint64_t first = group.firstVertices[i];
        if (group.base) PlaceBase(group.base->parts[i], record, group.positions, first, start, group.streams);
        record.normals = StreamPacker::Address(record.normals, start, first, sizeof(glm::vec3));
        record.tangents = StreamPacker::Address(record.tangents, start, first, sizeof(glm::vec4));
        record.frameTurns = StreamPacker::Address(record.frameTurns, start, first, sizeof(glm::vec2));
        record.uv0 = StreamPacker::Address(record.uv0, start, first, sizeof(glm::vec2));
        record.uv1 = StreamPacker::Address(record.uv1, start, first, sizeof(glm::vec2));
        record.colors = StreamPacker::Address(record.colors, start, first, sizeof(glm::vec4));
        record.primitives = StreamPacker::Address(record.primitives, start);
    }
}

rhi::BlasDesc BlasOf(const PackedGroup& group, const std::string& name, VkDeviceAddress start) {
    rhi::BlasDesc blas;
    blas.name = name;
    if (group.kind.isRound)
        blas.aabbs.push_back(
            {.boxes = StreamPacker::Address(group.boxes, start), .boxCount = group.boxCount});
    else
        blas.triangles.push_back({.vertices = StreamPacker::Address(group.positions, start),
                                  .vertexCount = group.vertexCount,
                                  .indices = StreamPacker::Address(group.indices, start),
                                  .triangleCount = static_cast<uint32_t>(group.triangleCount)});
    SetFlags(blas, group.kind);
    return blas;
}

// Of a group whose streams have been copied. `firstGeometry` counts in its mesh.
GroupResources FinishGroup(rhi::BlasBuilder& builder, const std::string& name, PackedGroup& group,
                           const MeshUse& use, rhi::Buffer&& streams, uint32_t firstGeometry) {
    GroupResources result;
    result.streams = std::move(streams);
    const VkDeviceAddress start = result.streams.Address();
    if (!group.base || use.isBaseDrawn) result.blas = builder.Add(BlasOf(group, name, start));
    result.kind = group.kind;
    result.parts = std::move(group.parts);
    result.record.positions = StreamPacker::Address(group.positions, start);
    result.record.indices = StreamPacker::Address(group.indices, start);
    result.record.triangleGeometries = StreamPacker::Address(group.geometries, start);
    result.record.triangleLights = StreamPacker::Address(group.lights, start);
    result.record.firstGeometry = firstGeometry;
    result.emitters = std::move(group.emitters.emitters);
    result.emitterVariants = std::move(group.emitters.variants);
    result.triangleCount = group.triangleCount;
    result.bounds = group.bounds;
    result.base = std::move(group.base);
    result.tree = std::move(group.tree);
    return result;
}

}  // namespace

bool MeshUpload::Continue(rhi::Device& device, rhi::Uploader& uploader, rhi::BlasBuilder& builder,
                          Disposer& disposer, uint64_t& budget) {
    while (m_group < m_mesh.groups.size()) {
        PackedGroup& group = m_mesh.groups[m_group];
        if (budget == 0) return false;
        if (!m_streams) {
            m_streams =
                device.CreateBuffer({.name = m_mesh.name + " streams",
                                     .size = group.streams.Bytes().size(),
                                     .usage = rhi::BufferUsage::Storage | rhi::BufferUsage::BuildInput |
                                              rhi::BufferUsage::CopyDestination});
            PlaceGroup(group, m_streams.Address());
            m_copied = 0;
        }
        const std::span<const std::byte> left = group.streams.Bytes().subspan(m_copied);
        const std::span<const std::byte> piece = left.first(std::min<uint64_t>(left.size(), budget));
        uploader.UploadBuffer(m_streams, m_copied, piece);
        m_copied += piece.size();
        budget -= piece.size();
        if (piece.size() < left.size()) return false;
        m_result.bytes += m_streams.Size();
        m_result.groups.push_back(FinishGroup(builder, m_mesh.name, group, m_mesh.use, std::move(m_streams),
                                              static_cast<uint32_t>(m_result.records.size())));
        m_result.records.insert(m_result.records.end(), group.records.begin(), group.records.end());
        m_streams = {};
        budget -= std::min(budget, group.triangleCount * kTriangleCost);
        disposer.Dispose(std::exchange(group, {}));  // its memory may be needed for what follows
        ++m_group;
    }
    return true;
}

UploadedMesh UploadMesh(rhi::Device& device, rhi::Uploader& uploader, rhi::BlasBuilder& builder,
                        Disposer& disposer, PackedMesh&& mesh) {
    MeshUpload upload(std::move(mesh));
    uint64_t budget = UINT64_MAX;
    upload.Continue(device, uploader, builder, disposer, budget);
    return upload.Take();
}

}  // namespace raygraph
