#include "renderer/bvh/traversal.h"

#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include "base/log.h"
#include "base/median.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "rhi/transfer.h"
#include "shaders/shared/mix_bits.h"

namespace raygraph {
namespace {

constexpr uint32_t kSide = 96;  // squares of the terrain
constexpr uint32_t kRays = 1u << 19;
constexpr uint32_t kWarmUpRounds = 2, kTimedRounds = 9;
constexpr double kMinSpeedup = 1.1;
constexpr std::string_view kName = "speed of software traversal over the driver's, 1";

// Returns a hash in [0, 1).
float Uniform(uint32_t index) {
    return static_cast<float>(gpu::MixBits(index) >> 8) * 0x1p-24f;
}

float HeightAt(uint32_t x, uint32_t y) {
    return 3.0f * std::sin(0.21f * static_cast<float>(x)) * std::cos(0.17f * static_cast<float>(y)) +
           Uniform(x * (kSide + 1) + y);
}

BvhScene Terrain() {
    BvhMesh mesh;
    for (uint32_t y = 0; y <= kSide; ++y)
        for (uint32_t x = 0; x <= kSide; ++x)
            mesh.positions.emplace_back(static_cast<float>(x), static_cast<float>(y), HeightAt(x, y));
    for (uint32_t y = 0; y < kSide; ++y)
        for (uint32_t x = 0; x < kSide; ++x) {
            const uint32_t corner = y * (kSide + 1) + x, above = corner + kSide + 1;
            mesh.indices.insert(mesh.indices.end(),
                                {corner, corner + 1, above, above, corner + 1, above + 1});
        }
    return {.meshes = {std::move(mesh)}, .instances = {{}}};
}

// Returns rays from points just above the terrain, in directions of its upper hemisphere, distributed by the
// cosine.
std::vector<gpu::BenchRay> MakeBenchRays() {
    std::vector<gpu::BenchRay> rays(kRays);
    for (uint32_t i = 0; i < kRays; ++i) {
        const float x = Uniform(4 * i) * kSide, y = Uniform(4 * i + 1) * kSide;
        const float angle = 2.0f * std::numbers::pi_v<float> * Uniform(4 * i + 2);
        const float square = Uniform(4 * i + 3), radius = std::sqrt(square);
        rays[i] = {
            .origin = {x, y, HeightAt(static_cast<uint32_t>(x), static_cast<uint32_t>(y)) + 1.0f},
            .tMax = 1e3f,
            .direction = {radius * std::cos(angle), radius * std::sin(angle), std::sqrt(1.0f - square)},
            .padding = 0};
    }
    return rays;
}

}  // namespace

double MeasureSoftwareSpeed(rhi::Device& device) {
    if (device.Info().timestampPeriodNs <= 0.0) return 0.0;
    const BvhScene terrain = Terrain();
    DriverScene driver(device, terrain);
    WideDeviceScene own(device, BuildOneLevel(terrain));
    const std::vector<gpu::BenchRay> rays = MakeBenchRays();
    ResourceState raysState;
    const rhi::Buffer buffer = UploadRecords(device, "rays", std::as_bytes(std::span(rays)), raysState);
    Renderer renderer(device);
    std::vector<double> driverMs, softwareMs;
    for (uint32_t round = 0; round < kWarmUpRounds + kTimedRounds; ++round) {
        renderer.BeginFrame();
        const BufferId rayIds = renderer.Import("rays", buffer, raysState);
        std::ignore = TraceByDriver(renderer, driver.Declare(renderer), rayIds, kRays);
        std::ignore = TraceBySoftware(renderer, own.Declare(renderer), rayIds, kRays, true);
        device.WaitFor(renderer.Execute());
        for (const FrameTiming& frame : renderer.TakeTimings())
            for (const PassTiming& pass : frame.passes) {
                if (round < kWarmUpRounds) continue;
                if (pass.name == kDriverPass) driverMs.push_back(pass.gpuMs);
                if (pass.name == kSoftwarePass) softwareMs.push_back(pass.gpuMs);
            }
    }
    const double ms = Median(softwareMs);
    return ms > 0.0 ? Median(driverMs) / ms : 0.0;
}

Traversal FasterTraversal(rhi::Device& device) {
    if (device.Info().type == rhi::DeviceType::Cpu) return Traversal::Software;
    std::optional<double> speed = device.Measured(kName);
    if (!speed) {
        const Stopwatch watch;
        speed = MeasureSoftwareSpeed(device);
        device.StoreMeasurement(kName, *speed);
        WriteLog(device.Log(), LogLevel::Info, log_category::kShaders,
                 "software traversal is {:.2f} times as fast as the driver's (measured in {:.2f} s)", *speed,
                 watch.Seconds());
    }
    return *speed >= kMinSpeedup ? Traversal::Software : Traversal::Driver;
}

// --- Scenes for measuring ---

namespace {

using rhi::BufferUsage;

// This is the state of a buffer whose writing has completed.
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
    // The buffer has at least one record, which nothing reads.
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

DriverScene::DriverScene(rhi::Device& device, const BvhScene& scene) {
    ResourceState state;
    rhi::BlasBuilder builder(device);
    for (const BvhMesh& mesh : scene.meshes) {
        const rhi::Buffer& vertices = m_inputs.emplace_back(
            UploadRecords(device, "vertices", BytesOf(mesh.positions), state, BufferUsage::BuildInput));
        const rhi::Buffer& triangles = m_inputs.emplace_back(
            UploadRecords(device, "indices", BytesOf(mesh.indices), state, BufferUsage::BuildInput));
        m_blases.push_back(
            builder.Add({.triangles = {{.vertices = vertices.Address(),
                                        .vertexCount = static_cast<uint32_t>(mesh.positions.size()),
                                        .indices = triangles.Address(),
                                        .triangleCount = static_cast<uint32_t>(mesh.TriangleCount())}}}));
    }
    Run(device, [&](CommandList& commands) { builder.RecordBuilds(commands); });
    while (builder.Poll()) Run(device, [&](CommandList& commands) { builder.RecordCompaction(commands); });

    std::vector<rhi::TlasInstance> placed;
    for (uint32_t i = 0; i < scene.instances.size(); ++i)
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
}

DriverScene::Ids DriverScene::Declare(Renderer& renderer) {
    return {.tlas = renderer.Import("benchTlas", m_tlas, m_tlasState),
            .blases = renderer.ImportBlasSet("benchBlases", m_blasState)};
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

BufferId TraceByDriver(Renderer& renderer, const DriverScene::Ids& scene, BufferId rays, uint32_t count) {
    BufferId hits = renderer.CreateBuffer("benchHits", {.size = count * sizeof(gpu::WideHit)});
    renderer.AddPass(
        kDriverPass, PassKind::RayTracing,
        [&](PassBuilder& pass) {
            pass.RayGen("bench/trace_rays.rgen");
            pass.Miss(RayType::Radiance, "scene/miss.rmiss");
            pass.HitGroup(RayType::Radiance,
                          {.closestHit = "scene/hit.rchit", .anyHit = {}, .intersection = {}});
            pass.Reads("sceneTlas", scene.tlas);
            pass.ReadsByAddress(scene.blases);
            pass.Reads("rays", rays);
            hits = pass.Writes("hits", hits);
            pass.KeepAlive();
        },
        [count](CommandList& commands) {
            commands.TraceRays({count, 1});
        });
    return hits;
}

BufferId TraceBySoftware(Renderer& renderer, const WideDeviceScene::Ids& scene, BufferId rays, uint32_t count,
                         bool hasOneLevel) {
    BufferId hits = renderer.CreateBuffer("benchHits", {.size = count * sizeof(gpu::WideHit)});
    renderer.AddPass(
        kSoftwarePass, PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("bench/trace_rays_own.comp");
            pass.Specialize("kHasOneLevel", hasOneLevel ? 1 : 0);
            pass.Reads("wideNodes", scene.nodes);
            pass.Reads("wideTriangles", scene.triangles);
            pass.Reads("wideInstances", scene.instances);
            pass.Reads("rays", rays);
            hits = pass.Writes("hits", hits);
            pass.Constants(gpu::BenchConstants{.rayCount = count});
            pass.KeepAlive();
        },
        [count](CommandList& commands) {
            commands.DispatchOver({count, 1});
        });
    return hits;
}

}  // namespace raygraph
