#include "renderer/gpu_scene/geometry/mesh_upload.h"

#include <algorithm>
#include <utility>

#include "renderer/gpu_scene/instances/group_kinds.h"

namespace raygraph {
namespace {

// Turns the offsets of a group into addresses in its buffer at `start`.
void ResolveGroupAddresses(PackedGroup& group, VkDeviceAddress start) {
    for (size_t i = 0; i < group.records.size(); ++i) {
        gpu::GeometryRecord& record = group.records[i];
        const uint64_t first = group.firstVertices[i];
        if (group.base)
            ResolveBaseAddresses(group.base->parts[i], record, group.positions, first, start, group.streams);
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

void RenumberMaterials(PackedGroup& group, std::span<const uint32_t> numbers) {
    if (numbers.empty()) return;
    const auto renumber = [&](auto& thing) { thing.material = numbers[thing.material]; };
    for (GroupPart& part : group.parts) {
        renumber(part);
        std::ranges::for_each(part.variants, renumber);
    }
    std::ranges::for_each(group.records, renumber);
    std::ranges::for_each(group.emitters.emitters, renumber);
    std::ranges::for_each(group.emitters.variants, renumber);
}

}  // namespace

MeshUpload::MeshUpload(SceneContext& context, rhi::Uploader& uploader, std::span<PackedMesh> meshes,
                       std::span<const uint32_t> materials)
    : m_context(context), m_uploader(uploader), m_meshes(meshes), m_materials(materials) {
    for (const PackedMesh& mesh : meshes) m_bytes += mesh.Bytes();
}

bool MeshUpload::Make(uint32_t mesh, uint64_t& budget, bool mayWait) {
    PackedMesh& packed = m_meshes[mesh];
    while (m_groups.size() < packed.groups.size()) {
        if (budget == 0 || (!mayWait && m_uploader.WouldBlock())) return false;
        PackedGroup& group = packed.groups[m_groups.size()];
        if (!m_streams) {
            m_streams = m_context.device.CreateBuffer({.name = packed.name + " streams",
                                                       .size = group.streams.Bytes().size(),
                                                       .usage = rhi::BufferUsage::Storage |
                                                                rhi::BufferUsage::BuildInput |
                                                                rhi::BufferUsage::CopyDestination});
            ResolveGroupAddresses(group, m_streams.Address());
            m_offset = 0;
        }
        const std::span<const std::byte> left = group.streams.Bytes().subspan(m_offset);
        const std::span<const std::byte> piece = left.first(std::min<uint64_t>(left.size(), budget));
        m_uploader.UploadBuffer(m_streams, m_offset, piece);
        m_offset += piece.size();
        m_copiedBytes += piece.size();
        budget -= piece.size();
        if (piece.size() < left.size()) return false;
        m_groups.push_back(Finish(group, packed));
        budget -= std::min(budget, group.triangleCount * kTriangleCost);
        m_context.disposer.Dispose(std::exchange(group, {}));  // the next group may need this memory
    }
    return true;
}

// Requires that the streams of the group have been copied.
GroupResources MeshUpload::Finish(PackedGroup& group, const PackedMesh& mesh) {
    RenumberMaterials(group, m_materials);
    GroupResources result;
    result.streams = std::exchange(m_streams, {});
    const VkDeviceAddress start = result.streams.Address();
    if (!group.base || mesh.use.isBaseDrawn)
        result.blas = m_context.builder.Add(BlasOf(group, mesh.name, start));
    result.kind = group.kind;
    result.parts = std::move(group.parts);
    result.record.positions = StreamPacker::Address(group.positions, start);
    result.record.indices = StreamPacker::Address(group.indices, start);
    result.record.triangleGeometries = StreamPacker::Address(group.geometries, start);
    result.record.triangleLights = StreamPacker::Address(group.lights, start);
    result.records = std::move(group.records);
    result.emitters = std::move(group.emitters.emitters);
    result.emitterVariants = std::move(group.emitters.variants);
    result.triangleCount = group.triangleCount;
    result.bounds = group.bounds;
    result.base = std::move(group.base);
    result.tree = std::move(group.tree);
    return result;
}

}  // namespace raygraph
