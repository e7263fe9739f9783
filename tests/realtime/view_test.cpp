// Tests RealTime with a scene: what it keeps from frame to frame, and its noise and energy.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "passes/accumulate.h"
#include "passes/real_time.h"
#include "renderer/graph/pass_harness.h"
#include "renderer/graph/readback_values.h"
#include "tests/realtime/room.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::real_time_view_test {

namespace {

class RealTimeView : public VulkanTest {
  protected:
    RealTimeView() { render.scene.SetScene(Room()); }
    // A frame, its picture, and the mean of all samples since the accumulation was reset.
    FloatImage Frame(const passes::TraceSettings& settings, FloatImage* mean = nullptr) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.Declare();
        const TextureId sample = passes::Trace(render.renderer, ids, settings).radiance;
        const Readback picture =
            render.renderer.ReadBack(passes::RealTime(render.renderer, ids, settings, sample, history));
        const Readback reference =
            render.renderer.ReadBack(passes::Accumulate(render.renderer, sample, accumulation).mean);
        render.renderer.Execute();
        picture.Wait();
        reference.Wait();
        if (mean != nullptr) *mean = ToFloatImage(reference);
        FloatImage shown = ToFloatImage(reference);
        const std::vector<float> values =
            DecodeTexels(picture.Bytes(), picture.Extent(), picture.Format()).values;
        std::memcpy(shown.values.data(), values.data(), values.size() * sizeof(float));
        return shown;
    }
    // Returns the number of samples of each pixel's surface in the mean of the last frame.
    std::vector<float> Samples(Extent2D extent) {
        render.renderer.BeginFrame();
        const Readback mean = render.renderer.ReadBack(
            render.renderer.Persist(history.NameOf("mean", false), {extent, Format::Rgba16Float}));
        render.renderer.Execute();
        mean.Wait();
        return ChannelOf(DecodeTexels(mean.Bytes(), mean.Extent(), mean.Format()).values, 3);
    }
    static double Median(std::vector<float> values) {
        std::ranges::nth_element(values, values.begin() + static_cast<ptrdiff_t>(values.size() / 2));
        return values[values.size() / 2];
    }

    SceneRender render{Device()};
    passes::RealTimeHistory history{"realTimeTest"};
    passes::Accumulation accumulation{"realTimeReference"};
};

}  // namespace

TEST_F(RealTimeView, Still_KeepsTheEnergy) {
    passes::TraceSettings settings = RoomSettings({48, 32});
    FloatImage picture, mean;
    for (settings.sampleIndex = 0; settings.sampleIndex < 64; ++settings.sampleIndex)
        picture = Frame(settings, &mean);
    const glm::dvec3 energy = picture.Mean() / mean.Mean();
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(energy[c], 1.0, 0.005);
    EXPECT_EQ(history.StillFrames(), 63u);
}

TEST_F(RealTimeView, AnySize_IsFiniteAndLit) {
    for (const Extent2D extent : {Extent2D{1, 1}, Extent2D{3, 1}, Extent2D{1, 5}, Extent2D{9, 7}}) {
        passes::TraceSettings settings = RoomSettings(extent);
        FloatImage picture;
        for (; settings.sampleIndex < 3; ++settings.sampleIndex) picture = Frame(settings);
        for (const glm::vec4& texel : picture.values)
            EXPECT_TRUE(std::isfinite(texel.x + texel.y + texel.z)) << extent.width << "x" << extent.height;
        EXPECT_GT(picture.Mean().x, 0.01);
        accumulation.Reset(passes::ResetCause::Resize);
    }
}

TEST_F(RealTimeView, OneFrame_HasLessNoiseThanItsSample) {
    passes::TraceSettings settings = RoomSettings({48, 32});
    FloatImage mean, sample, unused;
    for (settings.sampleIndex = 100; settings.sampleIndex < 228; ++settings.sampleIndex)
        Frame(settings, &mean);
    accumulation.Reset(passes::ResetCause::Settings);
    history.Forget();
    settings.sampleIndex = 0;
    const FloatImage picture = Frame(settings, &sample);
    const auto error = [&](const FloatImage& image) {
        double sum = 0.0;
        for (size_t i = 0; i < image.values.size(); ++i) {
            const double difference = image.values[i].y - mean.values[i].y;
            sum += difference * difference / (mean.values[i].y * mean.values[i].y + 0.01);
        }
        return sum;
    };
    EXPECT_LT(error(picture), error(sample) / 4.0);
}

TEST_F(RealTimeView, EveryCause_LimitsTheHistoryAsFarAsItConcernsIt) {
    const Extent2D extent{24, 16};
    passes::TraceSettings settings = RoomSettings(extent);
    const auto settle = [&] {
        for (int i = 0; i < 6; ++i, ++settings.sampleIndex) Frame(settings);
        EXPECT_EQ(history.StillFrames(), 5u);
        EXPECT_EQ(Median(Samples(extent)), 6.0);
    };
    settle();
    settings = RoomSettings(extent, {-0.78f, 0.1f, 0.3f});  // The camera moves: surfaces keep their samples
    Frame(settings);
    EXPECT_GT(Median(Samples(extent)), 6.0);
    EXPECT_EQ(history.StillFrames(), 0u);
    settings = RoomSettings(extent);
    history.Forget();
    settle();
    history.NoteChange();  // It shows nowhere
    EXPECT_EQ(history.StillFrames(), 0u);
    Frame(settings);
    EXPECT_EQ(Median(Samples(extent)), 7.0);
    EXPECT_EQ(history.StillFrames(), 0u);
    history.Forget();
    Frame(settings);
    EXPECT_EQ(Median(Samples(extent)), 1.0);
    const uint32_t frames = history.FrameCount();
    settings.extent = {25, 17};  // another size
    Frame(settings);
    EXPECT_EQ(Median(Samples({25, 17})), 1.0);
    EXPECT_EQ(history.StillFrames(), 0u);
    EXPECT_EQ(history.FrameCount(), frames + 1);
}

// A lens moves no surface, but earlier pictures are as sharp as the one before was.
TEST_F(RealTimeView, AnotherLens_LeavesNoOldBlur) {
    passes::TraceSettings settings = RoomSettings({24, 16});
    const auto run = [&](int frames) {
        FloatImage picture;
        for (int i = 0; i < frames; ++i, ++settings.sampleIndex) picture = Frame(settings);
        return picture;
    };
    const auto distance = [](const FloatImage& a, const FloatImage& b) {
        double sum = 0.0;
        for (size_t i = 0; i < a.values.size(); ++i) sum += std::abs(a.values[i].y - b.values[i].y);
        return sum;
    };
    const FloatImage sharp = run(24);
    settings.camera.lensRadius = 0.2f;
    settings.camera.focusDistance = 0.3f;
    const uint32_t first = settings.sampleIndex;
    const FloatImage changed = run(12);
    history.Forget();
    settings.sampleIndex = first;
    const FloatImage truth = run(12);
    EXPECT_LT(distance(changed, truth), 0.25 * distance(sharp, truth));
}

// The body moves further than it is wide: pixels that show it have the samples of its points, and the wall that
// it uncovers has none.
TEST_F(RealTimeView, MovedBody_TakesItsHistoryAlong) {
    const Extent2D extent{48, 32};
    passes::TraceSettings settings = RoomSettings(extent);
    for (int i = 0; i < 4; ++i, ++settings.sampleIndex) Frame(settings);
    render.scene.SetTransform(1, Translation({0.3f, -0.5f, -0.55f}));
    history.NoteChange();
    Frame(settings);
    const std::vector<float> samples = Samples(extent);
    const auto count = [&](float least, float most) {
        return std::ranges::count_if(samples, [&](float n) { return n >= least && n <= most; });
    };
    EXPECT_GT(count(4.0f, 5.0f), 48 * 32 * 3 / 4);
    EXPECT_GT(count(1.0f, 1.0f), 30);  // the wall behind where the body was
}

}  // namespace raygraph::testing::real_time_view_test
