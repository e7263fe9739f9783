#include "editor/cli/bench_traversal.h"

#include <deque>
#include <optional>

#include "base/os/process.h"
#include "base/text.h"
#include "editor/cli/traversal_rays.h"
#include "renderer/bvh/exact_trace.h"
#include "renderer/graph/readback_values.h"

namespace raygraph::cli {

using namespace session;  // NOLINT

namespace {

using passes::RayQuestion;

constexpr uint32_t kBounces = 3;
constexpr uint32_t kWarmUpFrames = 2;
constexpr uint32_t kCheckedDifferences = 8;  // of a kind of rays

struct RaySet {
    std::string name;
    RayQuestion question;
    std::vector<gpu::BenchRay> rays;
};

class TraversalBench {
  public:
    // `oneLevel`: null: the scene has too many triangles.
    TraversalBench(rhi::Device& device, const BvhScene& scene, const WideScene& wideScene,
                   const WideScene* oneLevel)
        : m_renderer(device), m_scene(scene), m_wide(device, wideScene) {
        if (oneLevel) m_oneLevel.emplace(device, *oneLevel);
        for (const BuildOrder order : Values<BuildOrder>()) m_drivers.emplace_back(device, scene, order);
    }

    // The rays of all kinds, each from what the driver finds for those before.
    std::vector<RaySet> MakeRays(const scene::CameraView& view, Extent2D size) {
        std::vector<RaySet> sets;
        std::vector<gpu::BenchRay> rays = CameraRays(view, size);
        const auto add = [&](std::string name) {
            for (const RayQuestion question : {RayQuestion::Nearest, RayQuestion::Any})
                sets.push_back({name, question, rays});
        };
        add("camera");
        for (uint32_t bounce = 1; bounce <= kBounces; ++bounce) {
            SetRays(rays);
            const std::vector<gpu::WideHit> hits = DriverHits(RayQuestion::Nearest);
            if (bounce == 1) {
                RaySet shadow{"shadow", RayQuestion::Any, ShadowRays(m_scene, rays, hits, bounce)};
                if (!shadow.rays.empty()) sets.push_back(std::move(shadow));
            }
            rays = BounceRays(m_scene, rays, hits, bounce);
            if (rays.empty()) break;
            if (bounce == 1 || bounce == kBounces) add(Text("bounce{}", bounce));
        }
        return sets;
    }

    TraversalTimes Measure(const RaySet& set, const BenchPlan& plan, bool isCpu) {
        SetRays(set.rays);
        TraversalTimes times{.rays = set.name, .question = set.question, .rayCount = m_rayCount};
        Compare(set, times);
        // Each way in turn, so that other load on the machine affects all alike
        struct Way {
            std::function<void()> declare;
            double* result;
            std::vector<double> samples;
        };
        std::vector<Way> ways;
        for (size_t i = 0; i < m_drivers.size(); ++i)
            ways.push_back({[this, i, &set] { DeclareDriver(i, set.question); }, &times.driverMs[i], {}});
        ways.push_back({[this, &set] { DeclareWide({.question = set.question}); }, &times.wideMs, {}});
        if (m_oneLevel)
            ways.push_back({[this, &set] { DeclareWide({.question = set.question, .hasOneLevel = true}); },
                            &times.oneLevelMs,
                            {}});
        for (const Way& way : ways) RunFrames(way.declare, kWarmUpFrames);
        std::ignore = m_renderer.TakeTimings();
        for (uint32_t round = 0; round < plan.rounds; ++round)
            for (Way& way : ways) {
                const double before = os::ProcessCpuSeconds();
                RunFrames(way.declare, plan.frames);
                const double cpuMs = 1e3 * (os::ProcessCpuSeconds() - before) / plan.frames;
                const std::vector<FrameTiming> frames = m_renderer.TakeTimings();
                if (isCpu)
                    way.samples.push_back(cpuMs);
                else
                    for (const FrameTiming& frame : frames)
                        for (const PassTiming& pass : frame.passes) way.samples.push_back(pass.gpuMs);
            }
        for (const Way& way : ways) {
            if (way.samples.empty())
                throw MakeError(ErrorKind::Vulkan,
                                "bench: the device {} gives no GPU times (it has no timestamps)",
                                m_renderer.Device().Info().name);
            *way.result = Median(way.samples);
        }
        return times;
    }

    void Describe(TraversalResult& result) const {
        for (size_t i = 0; i < m_drivers.size(); ++i) result.orderSeconds[i] = m_drivers[i].OrderSeconds();
        result.wideBytes = m_wide.Bytes();
        result.driverBytes = m_drivers.front().Bytes();
    }

  private:
    void SetRays(const std::vector<gpu::BenchRay>& rays) {
        m_rays = UploadRecords(m_renderer.Device(), "rays", std::as_bytes(std::span(rays)), m_raysState);
        m_rayCount = static_cast<uint32_t>(rays.size());
    }
    BufferId Rays() { return m_renderer.Import("rays", m_rays, m_raysState); }

    BufferId DeclareDriver(size_t driver, RayQuestion question) {
        return passes::TraceBuffer(m_renderer, m_drivers[driver].Declare(m_renderer), Rays(), m_rayCount,
                                   question);
    }
    BufferId DeclareWide(const passes::TraverseSettings& settings) {
        WideDeviceScene& scene = settings.hasOneLevel ? *m_oneLevel : m_wide;
        return passes::TraverseBuffer(m_renderer, scene.Declare(m_renderer), Rays(), m_rayCount, settings);
    }

    // Returns with the device idle.
    void RunFrames(const std::function<void()>& declare, uint32_t count) {
        uint64_t last = 0;
        for (uint32_t i = 0; i < count; ++i) {
            m_renderer.BeginFrame();
            declare();
            last = m_renderer.Execute();
        }
        m_renderer.Device().WaitFor(last);
    }

    std::vector<gpu::WideHit> DriverHits(RayQuestion question) {
        constexpr size_t kDriver = static_cast<size_t>(kUsedOrder);
        m_renderer.BeginFrame();
        const Readback readback = m_renderer.ReadBack(DeclareDriver(kDriver, question));
        m_renderer.Execute();
        std::vector<gpu::WideHit> hits = WaitForValues<gpu::WideHit>(readback);
        if (question == RayQuestion::Nearest) m_drivers[kDriver].NumberTriangles(hits);
        return hits;
    }

    void Compare(const RaySet& set, TraversalTimes& times) {
        const std::vector<gpu::WideHit> driver = DriverHits(set.question);
        m_renderer.BeginFrame();
        BufferId countsId;
        const BufferId hitsId = DeclareWide({.question = set.question, .counts = &countsId});
        const Readback hits = m_renderer.ReadBack(hitsId), counts = m_renderer.ReadBack(countsId);
        m_renderer.Execute();
        const std::vector<gpu::WideHit> wide = WaitForValues<gpu::WideHit>(hits);
        for (const gpu::WideCounts& taken : WaitForValues<gpu::WideCounts>(counts)) {
            times.nodesPerRay += taken.nodes;
            times.trianglesPerRay += taken.triangles;
            times.instancesPerRay += taken.instances;
        }
        for (double* mean : {&times.nodesPerRay, &times.trianglesPerRay, &times.instancesPerRay})
            *mean /= m_rayCount;
        uint32_t hitCount = 0;
        for (uint32_t i = 0; i < m_rayCount; ++i) {
            const bool isHit = driver[i].t >= 0.0f;
            hitCount += isHit ? 1 : 0;
            const bool isNearest = set.question == RayQuestion::Nearest && isHit;
            if (isHit == (wide[i].t >= 0.0f) && (!isNearest || (driver[i].instance == wide[i].instance &&
                                                                driver[i].primitive == wide[i].primitive)))
                continue;
            Judge(set, i, wide[i], times.differences);
        }
        times.hitShare = hitCount / static_cast<double>(m_rayCount);
    }

    // Says who is wrong about a ray on which they differ.
    void Judge(const RaySet& set, uint32_t i, const gpu::WideHit& wide, HitDifferences& differences) const {
        if (differences.all++ >= kCheckedDifferences) {
            ++differences.unchecked;
            return;
        }
        const ExactHit exact = TraceExactly(m_scene, set.rays[i]);
        const bool isHit = exact.t >= 0.0;
        const bool isNearest = set.question == RayQuestion::Nearest && isHit;
        if (exact.isDoubtful)
            ++differences.atEdges;
        else if (isHit == (wide.t >= 0.0f) &&
                 (!isNearest || (exact.instance == wide.instance && exact.primitive == wide.primitive)))
            ++differences.driverIsWrong;
        else
            ++differences.wideIsWrong;
    }

    Renderer m_renderer;
    const BvhScene& m_scene;
    WideDeviceScene m_wide;
    std::optional<WideDeviceScene> m_oneLevel;
    std::deque<DriverScene> m_drivers;  // by order
    rhi::Buffer m_rays;
    ResourceState m_raysState;
    uint32_t m_rayCount = 0;
};

}  // namespace

TraversalResult BenchTraversal(rhi::Device& device, const scene::SceneData& data,
                               const PictureSettings& settings, const BenchPlan& plan, Progress& progress) {
    const float aspect = static_cast<float>(settings.size.width) / static_cast<float>(settings.size.height);
    const scene::CameraView view = scene::ChooseView(data, settings.camera, aspect);
    const BvhScene scene = BvhSceneOf(data);
    if (scene.instances.empty()) throw MakeError(ErrorKind::BadInput, "bench: the scene shows no triangles");
    TraversalResult result;
    for (const BvhMesh& mesh : scene.meshes) result.uniqueTriangles += mesh.TriangleCount();
    for (const BvhInstance& instance : scene.instances)
        result.placedTriangles += scene.meshes[instance.mesh].TriangleCount();
    result.instances = scene.instances.size();
    progress.ShowStep("building trees");
    const WideScene wide = BuildWideScene(scene);
    std::optional<WideScene> oneLevel;
    if (result.placedTriangles <= kMaxLevelTriangles) oneLevel = BuildOneLevel(scene);
    result.sahOfInstances = wide.sahOfInstances;
    result.sahOfMeshes = wide.sahOfMeshes;
    result.wideBuildSeconds = wide.buildSeconds;
    TraversalBench bench(device, scene, wide, oneLevel ? &*oneLevel : nullptr);
    bench.Describe(result);
    const bool isCpu = device.Info().type == rhi::DeviceType::Cpu;
    result.measure = isCpu ? "cpu seconds" : "gpu timestamps";
    for (const RaySet& set : bench.MakeRays(view, settings.size)) {
        progress.ShowStep(Text("{} rays", set.name));
        result.kinds.push_back(bench.Measure(set, plan, isCpu));
    }
    return result;
}

}  // namespace raygraph::cli
