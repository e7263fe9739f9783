#include "renderer/bvh/traversal_scene.h"

#include "base/stopwatch.h"
#include "rhi/upload.h"

namespace raygraph {
namespace {

using rhi::BufferUsage;

// Written by something that has completed.
constexpr ResourceState kWritten{.writeStages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                 .writeAccess = VK_ACCESS_2_MEMORY_WRITE_BIT};

template <typename T>
std::span<const std::byte> BytesOf(const std::vector<T>& values) {
    return std::as_bytes(std::span(values));
}

void Run(rhi::Device& device, const std::function<void(CommandList&)>& record) {
    CommandList commands = device.BeginCommands("traversal scene");
    record(commands);
    device.WaitFor(device.Submit(std::move(commands)));
}

rhi::TlasInstance ToTlasInstance(const BvhInstance& instance, uint32_t number, const rhi::Blas& blas) {
    rhi::TlasInstance placed{.customIndex = number, .blas = blas.Address()};
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
            placed.objectToWorld[4 * row + column] = instance.objectToWorld[column][row];
    return placed;
}

}  // namespace

rhi::Buffer UploadRecords(rhi::Device& device, const char* name, std::span<const std::byte> bytes,
                          ResourceState& state, BufferUsage more) {
    // At least one record, which nothing reads
    rhi::Buffer buffer =
        device.CreateBuffer({.name = name,
                             .size = std::max<uint64_t>(bytes.size(), 64),
                             .usage = BufferUsage::Storage | BufferUsage::CopyDestination | more});
    rhi::Uploader uploader(device);
    uploader.UploadBuffer(buffer, 0, bytes);
    device.WaitFor(uploader.Flush());
    state = kWritten;
    return buffer;
}

DriverScene::DriverScene(rhi::Device& device, const BvhScene& scene, BuildOrder order) {
    ResourceState state;
    const Stopwatch watch;
    for (const BvhMesh& mesh : scene.meshes) m_orders.push_back(OrderBoxes(TriangleBoxes(mesh), order));
    m_orderSeconds = watch.Seconds();
    rhi::BlasBuilder builder(device);
    for (size_t m = 0; m < scene.meshes.size(); ++m) {
        const BvhMesh& mesh = scene.meshes[m];
        std::vector<uint32_t> indices;
        indices.reserve(mesh.indices.size());
        for (const uint32_t triangle : m_orders[m])
            for (uint32_t corner = 0; corner < 3; ++corner)
                indices.push_back(mesh.indices[3 * triangle + corner]);
        const rhi::Buffer& vertices = m_inputs.emplace_back(
            UploadRecords(device, "vertices", BytesOf(mesh.positions), state, BufferUsage::BuildInput));
        const rhi::Buffer& triangles = m_inputs.emplace_back(
            UploadRecords(device, "indices", BytesOf(indices), state, BufferUsage::BuildInput));
        m_blases.push_back(
            builder.Add({.triangles = {{.vertices = vertices.Address(),
                                        .vertexCount = static_cast<uint32_t>(mesh.positions.size()),
                                        .indices = triangles.Address(),
                                        .triangleCount = static_cast<uint32_t>(mesh.TriangleCount())}}}));
    }
    Run(device, [&](CommandList& commands) { builder.RecordBuilds(commands); });
    while (builder.Poll()) Run(device, [&](CommandList& commands) { builder.RecordCompaction(commands); });

    std::vector<rhi::TlasInstance> placed;
    const std::vector<uint32_t> places = OrderBoxes(InstanceBoxes(scene), order);
    for (const uint32_t i : places)
        placed.push_back(ToTlasInstance(scene.instances[i], i, *m_blases[scene.instances[i].mesh]));
    std::vector<std::byte> records(placed.size() * rhi::kTlasInstanceBytes);
    rhi::WriteInstances(placed, records);
    const rhi::Buffer& instances =
        m_inputs.emplace_back(UploadRecords(device, "instances", records, state, BufferUsage::BuildInput));
    m_tlas = rhi::Tlas(device, {.capacity = static_cast<uint32_t>(placed.size()), .allowsUpdate = false});
    Run(device, [&](CommandList& commands) {
        m_tlas.Build(commands, instances, static_cast<uint32_t>(placed.size()));
    });
    m_tlasState = m_blasState = kWritten;
    for (const BvhInstance& instance : scene.instances) m_meshes.push_back(instance.mesh);
}

DriverScene::Ids DriverScene::Declare(Renderer& renderer) {
    return {.tlas = renderer.Import("benchTlas", m_tlas, m_tlasState),
            .blases = renderer.ImportBlasSet("benchBlases", m_blasState)};
}

void DriverScene::NumberTriangles(std::span<gpu::WideHit> hits) const {
    for (gpu::WideHit& hit : hits)
        if (hit.t >= 0.0f) hit.primitive = m_orders[m_meshes[hit.instance]][hit.primitive];
}

uint64_t DriverScene::Bytes() const {
    uint64_t bytes = m_tlas.Bytes();
    for (const std::shared_ptr<rhi::Blas>& blas : m_blases) bytes += blas->Bytes();
    return bytes;
}

WideDeviceScene::WideDeviceScene(rhi::Device& device, const WideScene& scene)
    : m_nodes(UploadRecords(device, "wide nodes", BytesOf(scene.nodes), m_nodesState)),
      m_triangles(UploadRecords(device, "wide triangles", BytesOf(scene.triangles), m_trianglesState)),
      m_instances(UploadRecords(device, "wide instances", BytesOf(scene.instances), m_instancesState)) {}

WideDeviceScene::Ids WideDeviceScene::Declare(Renderer& renderer) {
    return {.nodes = renderer.Import("wideNodes", m_nodes, m_nodesState),
            .triangles = renderer.Import("wideTriangles", m_triangles, m_trianglesState),
            .instances = renderer.Import("wideInstances", m_instances, m_instancesState)};
}

}  // namespace raygraph
