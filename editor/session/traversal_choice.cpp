#include "editor/session/traversal_choice.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <map>
#include <mutex>
#include <optional>

#include "base/log.h"
#include "base/os/process.h"
#include "base/text.h"
#include "base/version.h"
#include "editor/session/choice_memory.h"
#include "editor/session/parse.h"
#include "editor/session/pass_times.h"
#include "passes/traversal.h"
#include "shaders/shared/mix_bits.h"

namespace raygraph::session {

namespace {

constexpr uint32_t kRings = 48, kSectors = 96;  // of a body
constexpr uint32_t kBodies = 27;                // in a cube
constexpr uint32_t kRaysOfCpu = 1u << 14, kRaysOfGpu = 1u << 20;
constexpr uint32_t kRounds = 3;

float UnitNumber(uint32_t index, uint32_t dimension) {
    return static_cast<float>(gpu::MixBits(gpu::MixBits(index) + dimension * 0x85ebca6bu) >> 8) / 16777216.0f;
}

glm::vec3 PointInCube(uint32_t index, uint32_t dimension) {
    return 2.0f * glm::vec3(UnitNumber(index, dimension), UnitNumber(index, dimension + 1),
                            UnitNumber(index, dimension + 2)) -
           1.0f;
}

// A sphere with bumps.
BvhMesh Body() {
    BvhMesh mesh;
    for (uint32_t ring = 0; ring <= kRings; ++ring)
        for (uint32_t sector = 0; sector < kSectors; ++sector) {
            const float a = glm::pi<float>() * static_cast<float>(ring) / kRings;
            const float b = glm::two_pi<float>() * static_cast<float>(sector) / kSectors;
            const float radius = 0.28f * (1.0f + 0.15f * std::sin(9.0f * a) * std::sin(7.0f * b));
            mesh.positions.push_back(
                radius * glm::vec3(std::sin(a) * std::cos(b), std::cos(a), std::sin(a) * std::sin(b)));
        }
    for (uint32_t ring = 0; ring < kRings; ++ring)
        for (uint32_t sector = 0; sector < kSectors; ++sector) {
            const uint32_t a = ring * kSectors + sector, b = ring * kSectors + (sector + 1) % kSectors;
            const uint32_t c = a + kSectors, d = b + kSectors;
            mesh.indices.insert(mesh.indices.end(), {a, b, c, b, d, c});
        }
    return mesh;
}

BvhScene Bodies() {
    BvhScene scene;
    scene.meshes.push_back(Body());
    for (uint32_t i = 0; i < kBodies; ++i) {
        BvhInstance& instance = scene.instances.emplace_back();
        instance.objectToWorld[3] =
            0.62f * glm::vec3(float(i % 3) - 1.0f, float(i / 3 % 3) - 1.0f, float(i / 9) - 1.0f);
    }
    return scene;
}

std::vector<gpu::BenchRay> IncoherentRays(uint32_t count) {
    std::vector<gpu::BenchRay> rays(count);
    for (uint32_t i = 0; i < count; ++i) {
        const glm::vec3 origin = PointInCube(i, 0), target = PointInCube(i, 3);
        const glm::vec3 way = target - origin;
        rays[i] = {.origin = origin, .tMax = 1e30f, .direction = way / std::max(glm::length(way), 1e-6f)};
    }
    return rays;
}

// Of all processes: a device of that name, driver and version.
std::string KeyOf(const rhi::DeviceInfo& device) {
    const Version version = LibraryVersion();
    return Text("traversal | {} | {} | {}.{}.{}", device.name, device.driver, version.major, version.minor,
                version.patch);
}

std::optional<double> RatioOf(const std::optional<std::string>& text) {
    if (!text) return std::nullopt;
    try {
        return ParseNumber(*text, 0.0, 1e6);
    } catch (const Error&) {
        return std::nullopt;  // something else is written there
    }
}

}  // namespace

double MeasureTraversal(rhi::Device& device) {
    const bool isCpu = device.Info().type == rhi::DeviceType::Cpu;
    if (!isCpu && device.Info().timestampPeriodNs <= 0.0) return 0.0;
    Renderer renderer(device);
    const BvhScene scene = Bodies();
    DriverScene driver(device, scene, kUsedOrder);
    WideDeviceScene wide(device, BuildWideScene(scene));
    const std::vector<gpu::BenchRay> rays = IncoherentRays(isCpu ? kRaysOfCpu : kRaysOfGpu);
    ResourceState state;
    const rhi::Buffer buffer = UploadRecords(device, "rays", std::as_bytes(std::span(rays)), state);
    const auto count = static_cast<uint32_t>(rays.size());
    const auto run = [&](bool isOwn) {
        const double before = os::ProcessCpuSeconds();
        renderer.BeginFrame();
        const BufferId id = renderer.Import("rays", buffer, state);
        if (isOwn)
            std::ignore = passes::TraverseBuffer(renderer, wide.Declare(renderer), id, count, {});
        else
            std::ignore = passes::TraceBuffer(renderer, driver.Declare(renderer), id, count,
                                              passes::RayQuestion::Nearest);
        renderer.Device().WaitFor(renderer.Execute());
        if (isCpu) return os::ProcessCpuSeconds() - before;
        PassTimes times;
        times.Add(renderer.TakeTimings());
        return 1e-3 * (times.MedianMs("WideNearest") + times.MedianMs("DriverNearest"));
    };
    // The first ones compile. Each in turn, so that other load on the machine affects both alike
    std::vector<double> ofDriver, ofOwn;
    for (uint32_t round = 0; round <= kRounds; ++round)
        for (const bool isOwn : {false, true})
            if (const double seconds = run(isOwn); round > 0) (isOwn ? ofOwn : ofDriver).push_back(seconds);
    const double own = Median(ofOwn);
    return own > 0.0 ? Median(ofDriver) / own : 0.0;
}

passes::Traversal ChooseTraversal(rhi::Device& device, const std::filesystem::path& memory) {
    static std::mutex mutex;
    static std::map<std::string, double> measured;
    const std::lock_guard lock(mutex);
    const std::string key = KeyOf(device.Info());
    const ChoiceMemory file(memory);
    std::optional<double> ratio = RatioOf(file.Find(key));
    const char* how = "remembered";
    if (!ratio) {
        if (const auto known = measured.find(key); known != measured.end()) {
            ratio = known->second;
        } else {
            ratio = MeasureTraversal(device);
            how = "measured";
        }
        file.Remember(key, Text("{:.2f}", *ratio));
    }
    measured[key] = *ratio;
    Say(device.Log(), LogLevel::Info, log_category::kShaders,
        "own traversal is {:.2f} times as fast as that of the driver ({})", *ratio, how);
    return *ratio >= kLeastTraversalRatio ? passes::Traversal::Own : passes::Traversal::Driver;
}

}  // namespace raygraph::session
