#include "renderer/bvh/traversal.h"

#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include "base/log.h"
#include "base/median.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "renderer/bvh/traversal_scene.h"
#include "shaders/shared/mix_bits.h"

namespace raygraph {
namespace {

constexpr uint32_t kSide = 96;  // squares of the terrain
constexpr uint32_t kRays = 1u << 19;
constexpr uint32_t kWarmUpRounds = 2, kTimedRounds = 9;
constexpr double kMinSpeedup = 1.1;
constexpr std::string_view kName = "speed of own traversal over the driver's, 1";

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
    if (device.Info().type == rhi::DeviceType::Cpu) return Traversal::Own;
    std::optional<double> speed = device.Measured(kName);
    if (!speed) {
        const Stopwatch watch;
        speed = MeasureSoftwareSpeed(device);
        device.StoreMeasurement(kName, *speed);
        Say(device.Log(), LogLevel::Info, log_category::kShaders,
            "own traversal is {:.2f} times as fast as the driver's (measured in {:.2f} s)", *speed,
            watch.Seconds());
    }
    return *speed >= kMinSpeedup ? Traversal::Own : Traversal::Driver;
}

}  // namespace raygraph
