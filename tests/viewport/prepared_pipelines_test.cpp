// Pipelines that are made on other threads: frames that need them can be left out meanwhile.
#include <chrono>
#include <thread>

#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::prepared_pipelines_test {
namespace {

constexpr Extent2D kSize{24, 16};

// With pipelines of its own.
class PreparedPipelines : public VulkanTest {
  protected:
    PreparedPipelines() {
        scene.SetScene(Boxes());
        viewport.SetCamera(InsideBoxes());
        viewport.SetRaster(PlainRaster());
    }
    // Declares a frame; whether it needs no pipeline that is not there. It is open then, else dropped.
    bool Begin() {
        renderer.BeginFrame();
        picture = viewport.Declare();
        renderer.Present(picture);
        if (renderer.PreparePipelines()) return true;
        renderer.DropFrame();
        return false;
    }
    static std::vector<uint8_t> BytesOf(const Readback& readback) {
        readback.Wait();
        std::vector<uint8_t> bytes(readback.Bytes().size());
        std::memcpy(bytes.data(), readback.Bytes().data(), bytes.size());
        return bytes;
    }
    std::vector<uint8_t> Finish() {
        const Readback readback = renderer.ReadBack(picture);
        renderer.Execute();
        return BytesOf(readback);
    }

    Renderer renderer{Device()};
    GpuScene scene{renderer};
    Viewport viewport{renderer, scene, {.size = kSize}};
    TextureId picture;
};

// A viewport that shows previews.
class Previewed : public PreparedPipelines {
  protected:
    Previewed() {
        viewport::PathSettings paths;
        paths.lights.isOn = false;  // takes less time to compile
        viewport.SetPaths(paths);
        viewport.SetBudget({.whilePreparing = viewport::PreparingView::Preview});
    }
    bool IsPreview() const { return viewport.Progress().isPreview; }
    uint32_t Samples() const { return viewport.Progress().pathTracedSamples; }
    // A frame, and what it shows.
    std::vector<uint8_t> Frame() {
        renderer.BeginFrame();
        picture = viewport.Declare();
        return Finish();
    }
    // Frames until one shows samples; how many did not.
    uint32_t FramesUntilSamples() {
        using std::chrono::steady_clock;
        const steady_clock::time_point start = steady_clock::now();
        uint32_t previews = 0;
        while (steady_clock::now() - start < std::chrono::minutes(2)) {
            Frame();
            if (!IsPreview()) return previews;
            EXPECT_EQ(Samples(), 0u) << "counted of a preview";
            ++previews;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        ADD_FAILURE() << "no samples after two minutes";
        return previews;
    }
    // The picture of as many samples, without previews, of a viewport of its own.
    std::vector<uint8_t> Expected(scene::SceneData data) {
        Renderer other(Device());
        GpuScene otherScene(other);
        otherScene.SetScene(std::move(data));
        Viewport usual(other, otherScene, {.size = kSize});
        usual.SetCamera(InsideBoxes());
        usual.SetRaster(PlainRaster());
        usual.SetPaths(viewport.Paths());
        std::vector<uint8_t> bytes;
        for (uint32_t i = 0; i < Samples(); ++i) {
            other.BeginFrame();
            const Readback readback = other.ReadBack(usual.Declare());
            other.Execute();
            bytes = BytesOf(readback);
        }
        return bytes;
    }
    static scene::Material Glass() {
        scene::Material glass;
        glass.metallicFactor = glass.roughnessFactor = 0.0f;
        glass.transmissionFactor = 1.0f;
        return glass;
    }
};

}  // namespace

TEST_F(PreparedPipelines, FramesGoOnWithThePictureThatThereIs) {
    EXPECT_FALSE(Begin()) << "the path tracer's pipeline takes longer";
    renderer.BeginFrame();
    EXPECT_FALSE(viewport.DeclareLastPicture().IsValid()) << "there has been no picture";
    renderer.DropFrame();
    using std::chrono::steady_clock;
    const steady_clock::time_point start = steady_clock::now();
    const auto waitUntilThere = [&] {
        while (!Begin() && steady_clock::now() - start < std::chrono::minutes(2))
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    };
    const uint32_t before = renderer.PipelineCount();
    waitUntilThere();
    const std::vector<uint8_t> traced = Finish();
    EXPECT_GT(renderer.PipelineCount(), before);
    Renderer other(Device());
    GpuScene otherScene(other);
    otherScene.SetScene(Boxes());
    Viewport usual(other, otherScene, {.size = kSize});
    usual.SetCamera(InsideBoxes());
    usual.SetRaster(PlainRaster());
    other.BeginFrame();
    const Readback expected = other.ReadBack(usual.Declare());
    other.Execute();
    EXPECT_EQ(traced, BytesOf(expected));

    // The raster view needs others
    viewport.SetView(View::Raster);
    EXPECT_FALSE(Begin());
    renderer.BeginFrame();
    const TextureId kept = viewport.DeclareLastPicture();
    ASSERT_TRUE(kept.IsValid());
    const Readback shown = renderer.ReadBack(kept);
    renderer.Execute();
    EXPECT_EQ(BytesOf(shown), traced);
    waitUntilThere();
    EXPECT_NE(Finish(), traced);
    EXPECT_TRUE(Begin());
    renderer.DropFrame();
}

// The renderer is destroyed while pipelines are still being compiled.
TEST_F(PreparedPipelines, RendererMayGoMeanwhile) {
    Renderer other(Device());
    GpuScene otherScene(other);
    otherScene.SetScene(Boxes());
    Viewport usual(other, otherScene, {.size = kSize});
    other.BeginFrame();
    other.Present(usual.Declare());
    EXPECT_FALSE(other.PreparePipelines());
    other.DropFrame();
}

TEST_F(Previewed, FramesGoOnUntilThereAreSamples) {
    const std::vector<uint8_t> preview = Frame();
    EXPECT_TRUE(IsPreview()) << "the path tracer's pipeline takes longer";
    EXPECT_NE(std::ranges::count(preview, uint8_t{0}), ptrdiff_t(preview.size() * 3 / 4)) << "black";
    // A camera that moves is followed
    scene::CameraView moved = InsideBoxes();
    moved.eye += glm::vec3(0.0f, 0.2f, 0.0f);
    viewport.SetCamera(moved);
    const std::vector<uint8_t> movedPreview = Frame();
    EXPECT_NE(movedPreview, preview) << "or samples";
    viewport.SetCamera(InsideBoxes());
    FramesUntilSamples();
    EXPECT_EQ(Samples(), 1u);
    const std::vector<uint8_t> shown = Frame();
    EXPECT_EQ(Samples(), 2u);
    EXPECT_NE(shown, preview);
    EXPECT_EQ(shown, Expected(Boxes())) << "something of the preview is in it";
}

TEST_F(Previewed, ExposureDoesNotDarkenIt) {
    const auto exposed = [&](float exposureEv) {
        viewport::ShowSettings show;
        show.tonemap.exposureEv = exposureEv;
        viewport.SetShow(show);
        const std::vector<uint8_t> bytes = Frame();
        EXPECT_TRUE(IsPreview());
        return bytes;
    };
    EXPECT_EQ(exposed(0.0f), exposed(-6.0f));
}

// The only light goes off and on, as in an editor: the program that can sample it goes on.
TEST_F(Previewed, FeaturesThatGo_NeedNoOtherPipeline) {
    scene::SceneData data = Boxes();
    data.materials[0].emissiveFactor = glm::vec3(0.0f);
    const scene::Light light = data.lights[0];
    scene.SetScene(scene::SceneData(data));
    viewport.SetPaths({.scattering = {.brdf = BrdfModel::Lambert}});
    FramesUntilSamples();
    const std::vector<uint8_t> lit = Expected(scene::SceneData(data));
    const uint32_t before = renderer.PipelineCount();
    scene::Light off = light;
    off.intensity = 0.0f;
    for (int i = 0; i < 2; ++i) {
        scene.SetLight(0, off);
        EXPECT_NE(Frame(), lit);
        EXPECT_FALSE(IsPreview());
        EXPECT_EQ(Samples(), 1u);
        scene.SetLight(0, light);
        EXPECT_EQ(Frame(), lit);
        EXPECT_FALSE(IsPreview());
    }
    EXPECT_EQ(renderer.PipelineCount(), before);
    EXPECT_EQ(renderer.PipelineReports().size(), size_t{before}) << "one is being made";
}

// The only glass becomes opaque, and stays so.
TEST_F(Previewed, FeaturesThatAreGoneForLong_AreLeftOut) {
    scene::SceneData data = Boxes();
    const scene::Material chalk = data.materials[1];
    data.materials[1] = Glass();
    scene.SetScene(scene::SceneData(data));
    FramesUntilSamples();
    Frame();
    renderer.ReleasePipelines(0.0);  // those of the preview
    const size_t before = renderer.PipelineReports().size();
    data.materials[1] = chalk;
    scene.SetMaterial(1, chalk);
    for (int i = 0; i < 64; ++i) Frame();
    EXPECT_EQ(Samples(), 64u) << "what there is can show it";
    EXPECT_EQ(renderer.PipelineReports().size(), before) << "too early";
    Frame();
    EXPECT_GT(renderer.PipelineReports().size(), before);  // waits for them; the loop has one
    const uint32_t count = renderer.PipelineCount();
    Frame();
    EXPECT_EQ(Samples(), 66u);
    renderer.ReleasePipelines(0.0);
    EXPECT_EQ(renderer.PipelineReports().size(), before) << "the one with glass is still used";
    scene.SetTransform(1, Translation({0.1f, 0.0f, 0.0f}));
    data.instances[1].objectToWorld = Translation({0.1f, 0.0f, 0.0f});
    const std::vector<uint8_t> shown = Frame();
    EXPECT_FALSE(IsPreview());
    EXPECT_EQ(Samples(), 1u);
    EXPECT_EQ(shown, Expected(std::move(data)));
    EXPECT_EQ(renderer.PipelineCount(), count);
}

// Glass that becomes opaque has a pipeline without glass made, and then all of them go. The restart after
// that must not take any of them for there.
TEST_F(Previewed, PipelinesThatWereLetGo_AreNotWaitedFor) {
    scene::SceneData data = Boxes();
    const scene::Material chalk = data.materials[1];
    data.materials[1] = Glass();
    scene.SetScene(scene::SceneData(data));
    FramesUntilSamples();
    scene.SetMaterial(1, chalk);
    for (int i = 0; i < 65; ++i) Frame();
    std::ignore = renderer.PipelineReports();  // waits for those that are being made
    Frame();
    renderer.BeginFrame();  // without the viewport
    renderer.Execute();
    renderer.ReleasePipelines(0.0);
    scene.SetTransform(1, Translation({0.1f, 0.0f, 0.0f}));
    Frame();
    EXPECT_TRUE(IsPreview()) << "or the frame has waited";
    FramesUntilSamples();
    data.materials[1] = chalk;
    data.instances[1].objectToWorld = Translation({0.1f, 0.0f, 0.0f});
    const std::vector<uint8_t> shown = Frame();
    EXPECT_EQ(shown, Expected(std::move(data)));
}

// The preview's own pipelines are not compiled, but nothing needs them.
TEST_F(Previewed, PipelinesThatAreThere_AreUsedFromTheFirstFrameOn) {
    viewport.SetBudget({});
    Frame();
    ASSERT_EQ(Samples(), 1u);
    const uint32_t before = renderer.PipelineCount();
    viewport.SetBudget({.whilePreparing = viewport::PreparingView::Preview});
    Frame();
    EXPECT_FALSE(IsPreview());
    EXPECT_EQ(Samples(), 2u);
    EXPECT_EQ(renderer.PipelineCount(), before);
}

// A pipeline that can do more goes on when settings change that no pipeline depends on.
TEST_F(Previewed, SettingsOfFramesNeedNoOtherPipeline) {
    scene::SceneData data = Boxes();
    data.materials[1] = Glass();
    scene.SetScene(scene::SceneData(data));
    FramesUntilSamples();
    data.materials[1] = Lambert(glm::vec3(0.8f));
    scene.SetMaterial(1, data.materials[1]);
    Frame();
    const size_t before = renderer.PipelineReports().size();
    viewport::PathSettings paths = viewport.Paths();
    paths.seed = 7;
    paths.biases.maxDepth = 3;
    viewport.SetPaths(paths);
    const std::vector<uint8_t> shown = Frame();
    EXPECT_FALSE(IsPreview());
    EXPECT_EQ(Samples(), 1u);
    EXPECT_EQ(shown, Expected(scene::SceneData(data)));
    EXPECT_EQ(renderer.PipelineReports().size(), before) << "one is being made";
    // A setting on which a pipeline depends has another one compiled.
    paths.sampler = SamplerKind::Pcg;
    viewport.SetPaths(paths);
    Frame();
    EXPECT_TRUE(IsPreview());
    FramesUntilSamples();
    const std::vector<uint8_t> other = Frame();
    EXPECT_EQ(other, Expected(std::move(data)));
}

// The program that samples lights is there, but would do it.
TEST_F(Previewed, LightsThatAreNotSampledAnyMore_AreNotSeen) {
    viewport.SetPaths({.scattering = {.brdf = BrdfModel::Lambert}});
    FramesUntilSamples();
    viewport::PathSettings paths = viewport.Paths();
    paths.lights.isOn = false;
    viewport.SetPaths(paths);
    FramesUntilSamples();
    const std::vector<uint8_t> shown = Frame();
    EXPECT_EQ(shown, Expected(Boxes()));
}

// A comparison needs samples, so its frame waits for their pipeline.
TEST_F(Previewed, ComparisonsHaveNone) {
    viewport.SetView(View::SideBySide);
    Frame();
    EXPECT_FALSE(IsPreview());
    EXPECT_EQ(Samples(), 1u);
}

// The other device is there for drivers that compile when pipelines are executed for the first time.
TEST(PreparedAhead, TheLargePipelineIsExecutedByAnotherDeviceBeforeAFrameUsesIt) {
    MessageLog heard;
    const std::unique_ptr<rhi::Device> device =
        rhi::Device::Create({.validation = true, .log = heard.Listener(LogLevel::Debug)});
    {
        Renderer renderer(*device);
        GpuScene scene(renderer);
        scene.SetScene(Boxes());
        Viewport viewport(renderer, scene, {.size = kSize});
        for (bool isThere = false; !isThere;) {
            renderer.BeginFrame();
            renderer.Present(viewport.Declare());
            isThere = renderer.PreparePipelines();
            renderer.DropFrame();
        }
    }
    const bool isAhead = device->Info().isLavapipe;
    const ::testing::Matcher<std::string> says =
        ::testing::ContainsRegex("pathtrace/[a-z_.]+: compiled ahead in ");
    EXPECT_THAT(heard.Text(), isAhead ? says : ::testing::Not(says));
    EXPECT_THAT(heard.Text(), ::testing::Not(::testing::HasSubstr("onemap.comp: compiled ahead")));
}

// The first glass: what there is cannot show it.
TEST_F(Previewed, FeaturesThatCome_RestartWithThePipelineThatHasThem) {
    FramesUntilSamples();
    Frame();
    scene.SetMaterial(1, Glass());
    Frame();
    EXPECT_TRUE(IsPreview());
    EXPECT_EQ(Samples(), 0u);
    FramesUntilSamples();
    EXPECT_EQ(Samples(), 1u);
    scene::SceneData data = Boxes();
    data.materials[1] = Glass();
    const std::vector<uint8_t> shown = Frame();
    EXPECT_EQ(Samples(), 2u);
    EXPECT_EQ(shown, Expected(std::move(data)));
}

}  // namespace raygraph::testing::prepared_pipelines_test
