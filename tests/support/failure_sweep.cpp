#include "tests/support/failure_sweep.h"

#include <set>

#include "base/error.h"
#include "passes/trace.h"
#include "renderer/gpu_scene/camera_record.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/source_file.h"

namespace raygraph::testing {

namespace {

constexpr Extent2D kSize{16, 16};

using Picture = SweepFixture::Picture;

scene::SceneData Load() {
    return scene::LoadGltf(test::SourceFile("scenes/texture_orientation.gltf"));
}

passes::TraceSettings SettingsOf(const SweepFixture& world, uint32_t sampleIndex) {
    passes::TraceSettings settings;
    settings.extent = kSize;
    settings.camera = ToRecord(world.camera);
    settings.scattering.brdf = BrdfModel::Lambert;
    settings.sampleIndex = sampleIndex;
    return settings;
}

void Read(SweepFixture& world) {
    world.readback.Wait();
    const std::span<const std::byte> bytes = world.readback.Bytes();
    world.pictures.emplace_back(bytes.begin(), bytes.end());
}

// A picture of the scene as it is now; not one of the frames of the scenario.
Picture Look(SweepFixture& world) {
    world.renderer->BeginFrame();
    const SceneIds ids = world.scene->Declare(*world.renderer);
    const Readback readback =
        world.renderer->ReadBack(passes::Trace(*world.renderer, ids, SettingsOf(world, 99)).radiance);
    world.renderer->Execute();
    readback.Wait();
    return {readback.Bytes().begin(), readback.Bytes().end()};
}

// The passes by themselves: a sample more, and the mean of all.
void TraceFrame(SweepFixture& world) {
    Renderer& renderer = *world.renderer;
    renderer.BeginFrame();
    const SceneIds ids = world.scene->Declare(renderer);
    const TextureId sample =
        passes::Trace(renderer, ids, SettingsOf(world, world.accumulation.SampleCount())).radiance;
    const Readback readback =
        renderer.ReadBack(passes::Accumulate(renderer, sample, world.accumulation).mean);
    renderer.Execute();
    world.readback = readback;
}

void ViewFrame(SweepFixture& world, viewport::View view) {
    Renderer& renderer = *world.renderer;
    viewport::ShowSettings show;
    show.view = view;
    world.viewport->SetShow(show);
    renderer.BeginFrame();
    const Readback readback = renderer.ReadBack(world.viewport->Declare());
    renderer.Execute();
    world.readback = readback;
}

void Start(SweepScenario& steps) {
    steps.push_back({"renderer", [](SweepFixture& world) { world.renderer.emplace(*world.device); }});
    steps.push_back({"scene", [](SweepFixture& world) {
                         world.scene.emplace(*world.renderer, GpuSceneDesc{.textureLevels = true,
                                                                           // A scene that has once had no
                                                                           // memory for own trees has none,
                                                                           // and other last bits
                                                                           .traversal = Traversal::Driver});
                     }});
    steps.push_back({"open",
                     [](SweepFixture& world) {
                         scene::SceneData data = Load();
                         // The camera changes only if the scene does
                         const scene::CameraView view = scene::ChooseView(data, "", 1.0f);
                         world.scene->SetScene(std::move(data));
                         world.camera = view;
                     },
                     true});
}

void OpenAnother(SweepScenario& steps) {
    steps.push_back({"open another",
                     [](SweepFixture& world) {
                         scene::SceneData data = Load();
                         for (scene::Material& material : data.materials) material.baseColorFactor.g = 0.25f;
                         world.scene->SetScene(std::move(data));
                     },
                     true});
}

void EditMaterials(SweepScenario& steps) {
    steps.push_back({"material", [](SweepFixture& world) {
                         // The sides of surfaces change, and with them the draws
                         const scene::SceneData data = Load();
                         for (uint32_t i = 0; i < data.materials.size(); ++i) {
                             scene::Material material = data.materials[i];
                             material.isDoubleSided = !material.isDoubleSided;
                             material.baseColorFactor.r = 0.25f;
                             world.scene->SetMaterial(i, material);
                         }
                     }});
}

// The scene once more, beside itself: meshes, textures, lights that emit.
void AddAndRemove(SweepScenario& steps) {
    steps.push_back({"part",
                     [](SweepFixture& world) {
                         scene::SceneData data = Load();
                         for (scene::Instance& instance : data.instances)
                             instance.objectToWorld[3] += 0.3f * world.camera.right;
                         world.part = world.scene->Add(std::move(data));
                     },
                     true});
    steps.push_back({"frame with the part", TraceFrame});
    steps.push_back({"read", Read});
    steps.push_back({"part gone", [](SweepFixture& world) { world.scene->Remove(world.part); }});
    steps.push_back({"frame without the part", TraceFrame});
    steps.push_back({"read", Read});
}

rhi::Device& MakeDevice(SweepFixture& world) {
    const static std::shared_ptr<rhi::VulkanLoader> system = rhi::VulkanLoader::Open();
    UseDedicatedAllocations(true);
    world.device = rhi::Device::Create({.name = "swept",
                                        .validation = true,
                                        .log = world.log.Listener(),
                                        .savePipelineCache = false,
                                        .getInstanceProcAddr = FailingLoader(system->GetInstanceProcAddr())});
    return *world.device;
}

// Holds the results of a run without failure: its pictures, and what was visible before each step.
struct UnfailedRun {
    std::vector<Picture> pictures;
    std::vector<Picture> before;  // by step; empty where nothing has been seen
};

std::string MessagesOf(const SweepFixture& world) {
    std::string text;
    for (const MessageLog::Message& message : world.log.All())
        if (message.IsValidation() || message.level == LogLevel::Error) text += message.text + "\n";
    return text;
}

void Destroy(SweepFixture& world) {
    world.readback = {};
    world.viewport.reset();
    world.scene.reset();
    world.renderer.reset();
    world.device.reset();
}

UnfailedRun RunWithoutFailures(const SweepScenario& scenario) {
    InjectFailure(std::nullopt);
    SweepFixture world;
    MakeDevice(world);
    UnfailedRun result;
    for (const SweepStep& step : scenario) {
        result.before.push_back(step.keepsScene ? Look(world) : Picture{});
        step.run(world);
    }
    result.pictures = world.pictures;
    Destroy(world);
    EXPECT_EQ(MessagesOf(world), "");
    return result;
}

// A lost device stays lost: every call that needs it says so.
void ExpectLost(SweepFixture& world) {
    const auto expectLost = [](const char* what, const std::function<void()>& call) {
        try {
            call();
            ADD_FAILURE() << what << " takes no notice of the lost device";
        } catch (const Error& error) {
            EXPECT_EQ(error.Kind(), ErrorKind::DeviceLost) << what << ": " << error.what();
        }
    };
    expectLost("WaitIdle", [&] { world.device->WaitIdle(); });
    if (world.renderer) expectLost("a new scene", [&] { GpuScene(*world.renderer); });
    if (world.scene) expectLost("a frame", [&] { Look(world); });
    if (world.scene) expectLost("another scene", [&] { world.scene->SetScene(Load()); });
}

std::string Signature(const std::vector<const char*>& calls) {
    std::string text;
    for (const char* call : calls) text += std::string(call) + " ";
    return text;
}

// Takes a step with failures until it is done. Returns how often it failed; `first` becomes the number of the
// first call that it could do without, plus the stride, and 0 if there was none.
uint32_t RunSweepStep(SweepFixture& world, const SweepStep& step, const Picture& before,
                      InjectedFailure failure, uint64_t stride, uint64_t& first) {
    failure.number = std::max<uint64_t>(1, first);
    first = 0;
    std::set<std::string> seen;
    for (uint32_t failures = 0;; ++failures) {
        InjectFailure(failure);
        std::string problem;
        try {
            step.run(world);
        } catch (const Error& error) {
            problem = error.what();
            EXPECT_EQ(error.Kind(), ErrorKind::OutOfMemory) << problem;
            EXPECT_EQ(problem.find('\n'), std::string::npos) << problem;
            EXPECT_TRUE(HasFailed()) << problem;
        }
        ClearInjectedFailure();
        const std::vector<const char*> calls = RecordedCalls();
        const std::string where = "step \"" + step.name + "\", " + failure.Text() +
                                  (calls.empty() ? "" : std::string(" ") + calls.back());
        SCOPED_TRACE(where);
        if (problem.empty()) {
            if (HasFailed()) first = failure.number + stride;
            return failures;
        }
        EXPECT_TRUE(!step.keepsScene || Look(world) == before) << "what was open is not, after: " << problem;
        if (::testing::Test::HasFailure()) throw std::runtime_error(where + ": " + problem);
        // Objects from before the failure may be reused, so that other calls come up to the same number
        if (!seen.insert(Signature(calls)).second) failure.number += stride;
    }
}

void ExpectPictures(const SweepFixture& world, const UnfailedRun& expected) {
    ASSERT_EQ(world.pictures.size(), expected.pictures.size());
    for (size_t i = 0; i < world.pictures.size(); ++i)
        EXPECT_TRUE(world.pictures[i] == expected.pictures[i]) << "picture " << i;
}

}  // namespace

SweepScenario RendererScenario() {
    SweepScenario steps;
    Start(steps);
    for (int frame = 0; frame < 3; ++frame) {
        steps.push_back({"frame", TraceFrame});
        steps.push_back({"read", Read});
    }
    steps.push_back({"environment map",
                     [](SweepFixture& world) {
                         image::ImageF map{.width = 4, .height = 2, .rgba = std::vector<float>(32, 0.5f)};
                         world.scene->SetEnvironmentMap(map);
                     },
                     true});
    EditMaterials(steps);
    steps.push_back({"transform", [](SweepFixture& world) {
                         scene::PlacedTransform transform = world.scene->Transform(0);
                         transform.matrix[3].x += 0.1f;
                         world.scene->SetTransform(0, transform);
                     }});
    steps.push_back({"frame of edits", TraceFrame});
    steps.push_back({"read", Read});
    AddAndRemove(steps);
    OpenAnother(steps);
    steps.push_back({"frame of another scene", TraceFrame});
    steps.push_back({"read", Read});
    return steps;
}

SweepScenario ViewportScenario() {
    using viewport::View;
    SweepScenario steps;
    Start(steps);
    steps.push_back({"viewport", [](SweepFixture& world) {
                         world.viewport.emplace(*world.renderer, *world.scene,
                                                viewport::ViewportDesc{.name = "swept", .size = kSize});
                         world.viewport->SetCamera(world.camera);
                         viewport::PathSettings paths;
                         paths.scattering.brdf = BrdfModel::Lambert;
                         world.viewport->SetPaths(paths);
                         // Skips features that take long to compile
                         world.viewport->SetRaster({.shadows = passes::RasterShadows::Off,
                                                    .hasOcclusion = false,
                                                    .hasTransmission = false});
                     }});
    for (const View view : {View::Raster, View::PathTraced, View::Wipe}) {
        steps.push_back({"frame", [view](SweepFixture& world) { ViewFrame(world, view); }});
        steps.push_back({"read", Read});
    }
    EditMaterials(steps);
    steps.push_back({"frame of edits", [](SweepFixture& world) { ViewFrame(world, View::Raster); }});
    steps.push_back({"read", Read});
    OpenAnother(steps);
    steps.push_back({"frame of another scene", [](SweepFixture& world) { ViewFrame(world, View::Wipe); }});
    steps.push_back({"read", Read});
    return steps;
}

uint32_t SweepOutOfMemory(const SweepScenario& scenario, std::optional<FailingCall> call, bool lasts,
                          uint64_t stride) {
    const UnfailedRun expected = RunWithoutFailures(scenario);
    const InjectedFailure failure{.call = call, .lasts = lasts};
    uint32_t failures = 0;
    // Numbers by step; if a step succeeds without a call, the calls after it are tested in another run
    std::vector<uint64_t> first(scenario.size(), 1);
    for (bool isDone = false; !isDone && !::testing::Test::HasFailure();) {
        SweepFixture world;
        MakeDevice(world);
        isDone = true;
        for (size_t i = 0; i < scenario.size(); ++i) {
            if (first[i] == 0) {
                scenario[i].run(world);
                continue;
            }
            failures += RunSweepStep(world, scenario[i], expected.before[i], failure, stride, first[i]);
            if (first[i] != 0) isDone = false;
        }
        ExpectPictures(world, expected);
        Destroy(world);
        EXPECT_EQ(MessagesOf(world), "");
    }
    return failures;
}

uint32_t SweepDeviceLoss(const SweepScenario& scenario, std::optional<FailingCall> call, uint64_t stride) {
    InjectedFailure failure{.call = call, .result = VK_ERROR_DEVICE_LOST};
    for (uint32_t losses = 0;; ++losses, failure.number += stride) {
        SweepFixture world;
        MakeDevice(world);
        InjectFailure(failure);
        const SweepStep* step = scenario.data();
        try {
            for (; step != scenario.data() + scenario.size(); ++step) step->run(world);
        } catch (const Error& error) {
            EXPECT_EQ(error.Kind(), ErrorKind::DeviceLost) << error.what();
        }
        const bool hasFailed = HasFailed();
        const std::string where = failure.Text() + " " + RecordedCalls().back();
        SCOPED_TRACE(where);
        if (hasFailed) ExpectLost(world);
        Destroy(world);
        EXPECT_EQ(MessagesOf(world), "");
        InjectFailure(std::nullopt);
        if (!hasFailed || ::testing::Test::HasFailure()) return losses;
    }
}

}  // namespace raygraph::testing
