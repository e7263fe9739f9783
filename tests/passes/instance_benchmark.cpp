// Measures what instances that move or are hidden cost, and what a decayed TLAS costs. Prints two tables:
//
//   host    milliseconds of the host in a frame in which some of COUNT instances change: the edits, and all
//           of the frame from BeginFrame to the end of Execute, as medians; of these the processor time of the
//           thread; and the device's time in the passes that upload and refresh.
//   motion  10,000 instances scattered over 100 frames: the device's milliseconds a frame in Trace and
//           RefreshTlas, the host's, and the rebuilds.
//
//   raygraph_instance_benchmark host [COUNT [ROUNDS]]
//   raygraph_instance_benchmark motion [COUNT [FRAMES [PIXELS]]]
//
// Scenes are made in memory; the device is the default one.
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "base/stopwatch.h"
#include "passes/trace.h"
#include "renderer/gpu_scene/camera_record.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/graph/renderer.h"
#include "renderer/scene/model/camera_view.h"
#include "rhi/device.h"

namespace raygraph {
namespace {

// A cube of half a meter, around the origin.
scene::Mesh Cube() {
    scene::Mesh mesh;
    scene::Primitive& primitive = mesh.primitives.emplace_back();
    for (int i = 0; i < 8; ++i) {
        primitive.positions.emplace_back(i & 1 ? 0.25f : -0.25f, i & 2 ? 0.25f : -0.25f,
                                         i & 4 ? 0.25f : -0.25f);
        primitive.bounds.Extend(primitive.positions.back());
    }
    primitive.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                         2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
    return mesh;
}

uint32_t GridSide(uint32_t count) {
    return static_cast<uint32_t>(std::ceil(std::cbrt(static_cast<double>(count)) - 1e-9));
}

glm::vec3 GridPlace(uint32_t i, uint32_t side) {
    return {float(i % side), float(i / side % side), float(i / side / side)};
}

glm::mat4x3 At(const glm::vec3& place) {
    glm::mat4x3 matrix(1.0f);
    matrix[3] = place;
    return matrix;
}

scene::SceneData Grid(uint32_t count) {
    scene::SceneData scene;
    scene.meshes.push_back(Cube());
    scene.materials.emplace_back();
    for (uint32_t i = 0; i < count; ++i)
        scene.instances.push_back({.mesh = 0, .objectToWorld = At(GridPlace(i, GridSide(count)))});
    return scene;
}

passes::TraceSettings ViewOf(uint32_t side, uint32_t pixels) {
    const auto size = float(side);
    scene::CameraView view = scene::CameraView::LookAt(glm::vec3(-0.6f * size, 1.2f * size, -1.0f * size),
                                                       glm::vec3(0.5f * size), glm::vec3(0.0f, 1.0f, 0.0f));
    view.yFov = 0.9f;
    passes::TraceSettings settings;
    settings.extent = {pixels, pixels};
    settings.camera = ToRecord(view);
    settings.biases.maxDepth = 2;
    return settings;
}

double Median(std::vector<double> values) {
    if (values.empty()) return 0.0;
    std::ranges::sort(values);
    return values[values.size() / 2];
}

// Processor time of this thread: that of others on the same machine does not count.
double ProcessorMs() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e3 * double(now.tv_sec) + 1e-6 * double(now.tv_nsec);
}

struct FrameTimes {
    double editMs = 0.0;
    double hostMs = 0.0;                  // edits included, waits excluded
    double processorMs = 0.0;             // the same
    std::map<std::string, double> gpuMs;  // by pass
};

class Bench {
  public:
    Bench(rhi::Device& device, uint32_t count, uint32_t pixels) : m_renderer(device), m_scene(m_renderer) {
        m_scene.SetScene(Grid(count));
        m_settings = ViewOf(GridSide(count), pixels);
        for (int i = 0; i < 8; ++i) Frame([] {});  // pipelines, builds, compaction
    }

    FrameTimes Frame(const std::function<void()>& edit) {
        m_renderer.BeginFrame();
        m_renderer.DropFrame();  // has waited for the frames before
        FrameTimes times;
        const Stopwatch watch;
        const double start = ProcessorMs();
        edit();
        times.editMs = watch.Milliseconds();
        m_renderer.BeginFrame();
        const SceneIds ids = m_scene.Declare(m_renderer);
        m_renderer.Present(passes::Trace(m_renderer, ids, m_settings).radiance);
        m_renderer.Execute();
        times.hostMs = watch.Milliseconds();
        times.processorMs = ProcessorMs() - start;
        m_renderer.Device().WaitIdle();
        m_renderer.BeginFrame();  // takes the times
        m_renderer.DropFrame();
        for (const PassTiming& pass : m_renderer.Timing().passes) times.gpuMs[pass.name] += pass.gpuMs;
        return times;
    }

    GpuScene& Scene() { return m_scene; }

  private:
    Renderer m_renderer;
    GpuScene m_scene;
    passes::TraceSettings m_settings;
};

void MeasureHost(rhi::Device& device, uint32_t count, uint32_t rounds) {
    Bench bench(device, count, 16);
    GpuScene& scene = bench.Scene();
    const uint32_t side = GridSide(count);
    std::printf("%u instances: milliseconds a frame\n", count);
    std::printf("%-22s %8s %8s %9s %9s %9s %9s  %s\n", "changed", "edits", "host", "processor", "records",
                "TLAS rec.", "refresh", "updates, rebuilds");
    // Every step-th instance; shuffled: in an order in which neighbors are far apart in memory
    const auto each = [count](uint32_t round, uint32_t step, bool isShuffled = false) {
        const uint64_t changed = count / step;
        std::vector<uint32_t> instances;
        for (uint64_t i = 0; i < changed; ++i)
            instances.push_back(static_cast<uint32_t>(isShuffled ? i * 7919 % changed : i) * step +
                                round % step);
        return instances;
    };
    const auto moved = [side](std::span<const uint32_t> instances, uint32_t round) {
        std::vector<scene::PlacedTransform> transforms;
        for (const uint32_t i : instances)
            transforms.push_back({At(GridPlace(i, side) + glm::vec3(0.01f * float(round % 16), 0.0f, 0.0f))});
        return transforms;
    };
    const auto move = [&, moved](uint32_t round, std::vector<uint32_t> instances) {
        return [&scene, transforms = moved(instances, round), instances] {
            scene.SetTransforms(instances, transforms);
        };
    };
    const auto moveOneByOne = [&, moved](uint32_t round, std::vector<uint32_t> instances) {
        return [&scene, transforms = moved(instances, round), instances] {
            for (size_t i = 0; i < instances.size(); ++i) scene.SetTransform(instances[i], transforms[i]);
        };
    };
    const auto toggle = [&scene](std::vector<uint32_t> instances) {
        return [&scene, instances] { scene.SetVisible(instances, !scene.IsVisible(instances[0])); };
    };
    uint32_t frame = 0;  // so that no row repeats what one before it has set
    const auto row = [&](const char* name, const std::function<std::function<void()>(uint32_t)>& edit) {
        const GpuSceneStatistics before = scene.Statistics();
        std::vector<double> edits, host, processor, records, tlasRecords, refresh;
        for (uint32_t round = 0; round < rounds + 2; ++round) {
            FrameTimes times = bench.Frame(edit(frame++));
            if (round < 2) continue;  // pipelines
            edits.push_back(times.editMs);
            host.push_back(times.hostMs);
            processor.push_back(times.processorMs);
            records.push_back(times.gpuMs["UploadInstances"]);
            tlasRecords.push_back(times.gpuMs["UploadTlasInstances"]);
            refresh.push_back(times.gpuMs["RefreshTlas"]);
        }
        const GpuSceneStatistics& after = scene.Statistics();
        std::printf("%-22s %8.3f %8.3f %9.3f %9.3f %9.3f %9.3f  %llu, %llu\n", name, Median(edits),
                    Median(host), Median(processor), Median(records), Median(tlasRecords), Median(refresh),
                    static_cast<unsigned long long>(after.tlasUpdates - before.tlasUpdates),
                    static_cast<unsigned long long>(after.tlasRebuilds - before.tlasRebuilds));
        std::fflush(stdout);
    };
    row("nothing", [](uint32_t) { return [] {}; });
    row("one moved", [&](uint32_t round) { return move(round, each(round, count)); });
    row("one hidden or shown", [&](uint32_t round) { return toggle(each(round / 2, count)); });
    row("1 % moved", [&](uint32_t round) { return move(round, each(round, 100)); });
    row("1 % moved, shuffled", [&](uint32_t round) { return move(round, each(round, 100, true)); });
    row("1 % moved, one by one", [&](uint32_t round) { return moveOneByOne(round, each(round, 100)); });
    row("1 % hidden or shown", [&](uint32_t round) { return toggle(each(round / 2, 100)); });
    // Every 1000th goes, and as many come elsewhere: they have the same indices
    row("0.1 % removed, added", [&](uint32_t round) {
        const std::vector<uint32_t> instances = each(round, 1000);
        return [&scene, instances, transforms = moved(instances, round)] {
            for (const uint32_t i : instances) scene.RemoveInstance(i);
            for (const scene::PlacedTransform& transform : transforms) scene.AddInstance(0, transform);
        };
    });
}

// Each instance travels from its place in the grid to another one's: all of them a bit in every frame, or in
// each frame some of them at once.
void MeasureMotion(rhi::Device& device, uint32_t count, uint32_t frames, uint32_t pixels) {
    const uint32_t side = GridSide(count);
    std::vector<uint32_t> targets(count);
    std::iota(targets.begin(), targets.end(), 0u);
    std::shuffle(targets.begin(), targets.end(), std::mt19937(1));
    std::printf("%u instances scattered over %u frames: mean milliseconds a frame\n", count, frames);
    std::printf("%-26s %9s %9s %9s %9s  %s\n", "motion", "trace", "last one", "refresh", "host",
                "updates, rebuilds");
    for (const bool isJump : {false, true}) {
        Bench bench(device, count, pixels);
        GpuScene& scene = bench.Scene();
        const GpuSceneStatistics before = scene.Statistics();
        double trace = 0.0, refresh = 0.0, host = 0.0, last = 0.0;
        for (uint32_t frame = 0; frame < frames; ++frame) {
            FrameTimes times = bench.Frame([&] {
                for (uint32_t i = 0; i < count; ++i) {
                    if (isJump && targets[i] % frames != frame) continue;
                    const float way = isJump ? 1.0f : float(frame + 1) / float(frames);
                    scene.SetTransform(i, At(glm::mix(GridPlace(i, side), GridPlace(targets[i], side), way)));
                }
            });
            trace += last = times.gpuMs["Trace"];
            refresh += times.gpuMs["RefreshTlas"];
            host += times.hostMs;
        }
        const GpuSceneStatistics& after = scene.Statistics();
        std::printf("%-26s %9.2f %9.2f %9.3f %9.3f  %llu, %llu\n",
                    isJump ? "some jump in each frame" : "all travel in each frame", trace / frames, last,
                    refresh / frames, host / frames,
                    static_cast<unsigned long long>(after.tlasUpdates - before.tlasUpdates),
                    static_cast<unsigned long long>(after.tlasRebuilds - before.tlasRebuilds));
        std::fflush(stdout);
    }
}

}  // namespace
}  // namespace raygraph

int main(int argc, char** argv) {
    using namespace raygraph;
    const auto number = [&](int i, uint32_t otherwise) {
        return argc > i ? static_cast<uint32_t>(std::strtoul(argv[i], nullptr, 10)) : otherwise;
    };
    const std::string_view what = argc > 1 ? argv[1] : "";
    if (what != "host" && what != "motion") {
        std::fprintf(stderr, "usage: %s host [COUNT [ROUNDS]] | motion [COUNT [FRAMES [PIXELS]]]\n", argv[0]);
        return 2;
    }
    try {
        const std::unique_ptr<rhi::Device> device = rhi::Device::Create({});
        std::printf("%s, %s\n", device->Info().name.c_str(), device->Info().driver.c_str());
        if (what == "host")
            MeasureHost(*device, number(2, 1'000'000), number(3, 16));
        else
            MeasureMotion(*device, number(2, 10'000), number(3, 100), number(4, 128));
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
    return 0;
}
