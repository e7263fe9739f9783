// The real-time view of a viewport: what it traces and when, and how it becomes the path-traced picture.
#include <cmath>
#include <cstdlib>
#include <functional>

#include "editor/viewport/real_time_view.h"
#include "renderer/graph/readback_values.h"
#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::real_time_view_test {

using passes::ResetCause;
using viewport::RealTimeView;

namespace {

using Picture = std::vector<uint8_t>;

class ViewportRealTime : public VulkanTest {
  protected:
    ViewportRealTime() { viewed.viewport.SetView(View::RealTime); }

    void Settle() { viewed.RenderFrames(RealTimeView::kSettledFrames + 1); }

    ViewedScene viewed{Device()};
};

}  // namespace

TEST_F(ViewportRealTime, WhileSomethingChanges_NoSampleIsAccumulated) {
    for (int i = 0; i < 3; ++i) {
        scene::CameraView camera = InsideBoxes();
        camera.eye.x += 0.01 * i;
        viewed.viewport.SetCamera(camera);
        viewed.RenderFrames(1);
    }
    EXPECT_EQ(viewed.Samples(), 0u);
    EXPECT_NE(viewed.renderer.DescribePlan().find("TraceSurfaces"), std::string::npos);
}

TEST_F(ViewportRealTime, Settled_AccumulatesAndFiltersNoMore) {
    Settle();
    viewed.RenderFrames(3);
    EXPECT_EQ(viewed.Samples(), 3u);
    EXPECT_EQ(viewed.renderer.DescribePlan().find("TraceSurfaces"), std::string::npos);
    const auto isBlended = [&] {
        const std::string plan = viewed.renderer.DescribePlan();
        return plan.find("HandOver") < plan.find("\nculled\n");
    };
    EXPECT_TRUE(isBlended());
    viewed.viewport.SetBudget({.maxSamples = viewed.Samples()});
    viewed.RenderFrames(1);
    EXPECT_FALSE(isBlended()) << "there is no new sample";
}

TEST_F(ViewportRealTime, Settled_BecomesThePathTracedPictureWithoutAJump) {
    Settle();
    Picture last = viewed.Picture();
    const double noise = [&] {  // of a path-traced picture of as few samples
        ViewedScene raw(Device());
        const Picture one = raw.Picture();
        return MeanDifference(one, raw.Picture());
    }();
    for (int i = 0; i < 8; ++i) {
        const Picture next = viewed.Picture();
        EXPECT_LT(MeanDifference(last, next), noise / 4.0) << i;
        last = next;
    }
    viewed.viewport.SetBudget({.samplesPerFrame = 64});
    viewed.RenderFrames(8);
    const Picture converged = viewed.Picture();
    viewed.viewport.SetView(View::PathTraced);
    viewed.viewport.SetBudget({.maxSamples = viewed.Samples()});
    EXPECT_LT(MeanDifference(converged, viewed.Picture()), 1.0);
}

TEST_F(ViewportRealTime, EveryCause_StartsFramesOfSamplesAgain) {
    const std::pair<ResetCause, std::function<void()>> rows[] = {
        {ResetCause::Camera,
         [&] {
             scene::CameraView camera = InsideBoxes();
             camera.eye.x += 0.02;
             viewed.viewport.SetCamera(camera);
         }},
        {ResetCause::Transform,
         [&] {
             viewed.scene.SetTransform(1, Translation({0.3f, -0.5f, 0.1f}));
         }},
        {ResetCause::Material, [&] { viewed.scene.SetMaterial(1, Lambert(glm::vec3(0.2f))); }},
        {ResetCause::Light,
         [&] {
             scene::Light light = viewed.scene.Light(0);
             light.intensity *= 2.0f;
             viewed.scene.SetLight(0, light);
         }},
        {ResetCause::Environment,
         [&] {
             viewed.scene.SetEnvironment({glm::vec3(0.3f), 0.0f});
         }},
        {ResetCause::Geometry, [&] { viewed.scene.SetVisible(1, false); }},
        {ResetCause::Resize,
         [&] {
             viewed.viewport.SetSize({21, 13});
         }},
        {ResetCause::Settings,
         [&] {
             viewport::PathSettings paths = viewed.viewport.Paths();
             paths.seed += 1;
             viewed.viewport.SetPaths(paths);
         }},
    };
    for (const auto& [cause, change] : rows) {
        SCOPED_TRACE(passes::Name(cause));
        Settle();
        viewed.RenderFrames(1);
        ASSERT_GT(viewed.Samples(), 0u);
        change();
        viewed.RenderFrames(1);
        EXPECT_EQ(viewed.viewport.ResetCount(cause), 1u);
        EXPECT_EQ(viewed.Samples(), 0u);
        EXPECT_NE(viewed.renderer.DescribePlan().find("TraceSurfaces"), std::string::npos);
    }
}

TEST_F(ViewportRealTime, AnotherView_KeepsWhatThereIs) {
    Settle();
    viewed.RenderFrames(2);
    viewed.viewport.SetView(View::PathTraced);
    viewed.RenderFrames(2);
    EXPECT_EQ(viewed.renderer.DescribePlan().find("TraceSurfaces"), std::string::npos);
    viewed.viewport.SetView(View::RealTime);
    viewed.RenderFrames(1);
    EXPECT_EQ(viewed.Samples(), 5u);
    EXPECT_EQ(viewed.AllResets(), 0u);
}

TEST_F(ViewportRealTime, TwoOfOneScene_AreEachAsIfAlone) {
    const auto show = [](Viewport& viewport) {
        viewport.SetCamera(InsideBoxes());
        viewport.SetView(View::RealTime);
    };
    ViewedScene alone(Device(), {17, 9});
    show(alone.viewport);
    alone.RenderFrames(5);
    Viewport other(viewed.renderer, viewed.scene, {.name = "other", .size = {17, 9}});
    other.SetPaths(viewed.viewport.Paths());
    show(other);
    for (int i = 0; i < 5; ++i) {
        viewed.RenderFrames(1);
        other.RenderFrame();
    }
    viewed.renderer.BeginFrame();
    const Readback readback = viewed.renderer.ReadBack(other.Declare());
    viewed.renderer.Execute();
    readback.Wait();
    EXPECT_EQ(ValuesOf<uint8_t>(readback), alone.Picture());
}

TEST_F(ViewportRealTime, AnySize_IsLegal) {
    for (const Extent2D size : {Extent2D{1, 1}, {3, 5}, {64, 1}, {1, 33}, {31, 17}}) {
        viewed.viewport.SetSize(size);
        EXPECT_EQ(viewed.Picture().size(), size_t{4} * size.width * size.height);
        Settle();
        EXPECT_EQ(viewed.Picture().size(), size_t{4} * size.width * size.height);
    }
}

class ViewportRealTimeErrors : public VulkanTest {
  protected:
    ViewportRealTimeErrors() { Show(View::Wipe, 0.5f); }
    void Show(View view, float wipePosition) {
        viewport::ShowSettings show;
        show.view = view;
        show.compared = viewport::Compared::RealTime;
        show.wipePosition = wipePosition;
        viewed.viewport.SetShow(show);
    }
    viewport::RealTimeErrors Measure() {
        const viewport::RealTimeErrorsRequest request = viewed.viewport.RequestRealTimeErrors();
        for (int i = 0; i < 100 && !request.IsTaken(); ++i) viewed.RenderFrames(1);
        Device().WaitIdle();
        return request.Result();
    }
    bool HasPass(const char* name) { return viewed.renderer.DescribePlan().find(name) != std::string::npos; }

    ViewedScene viewed{Device()};
};

TEST_F(ViewportRealTimeErrors, Comparison_FiltersOnAndShowsBothPicturesAsTheyAre) {
    for (const View view :
         {View::Wipe, View::SideBySide, View::Difference, View::RelativeError, View::Flip}) {
        SCOPED_TRACE(viewport::Name(view));
        Show(view, 0.5f);
        const uint32_t before = viewed.Samples();
        viewed.RenderFrames(RealTimeView::kSettledFrames / 4);
        EXPECT_EQ(viewed.Samples(), before + RealTimeView::kSettledFrames / 4);
        EXPECT_TRUE(HasPass("TraceSurfaces"));
        EXPECT_FALSE(HasPass("HandOver"));
        EXPECT_EQ(viewed.viewport.Progress().rasterSamples, 0u);
    }
    viewed.viewport.SetBudget({.maxSamples = viewed.Samples()});
    Show(View::Wipe, 1.0f);
    const Picture reference = viewed.Picture();
    EXPECT_TRUE(HasPass("TraceSurfaces")) << "the picture is filtered however long nothing changes";
    viewed.viewport.SetView(View::PathTraced);
    EXPECT_EQ(viewed.Picture(), reference);
    Show(View::Wipe, 0.0f);
    const Picture filtered = viewed.Picture();
    EXPECT_NE(filtered, reference);
    EXPECT_LT(MeanDifference(filtered, reference), 16.0);
}

TEST_F(ViewportRealTimeErrors, Numbers_AreOfThePicturesThatAreCompared) {
    Show(View::Flip, 0.5f);
    viewed.RenderFrames(2);
    Device().WaitIdle();
    const std::optional<viewport::CompareNumbers> numbers = viewed.viewport.Numbers();
    ASSERT_TRUE(numbers.has_value());
    EXPECT_EQ(numbers->compared, viewport::Compared::RealTime);
    EXPECT_EQ(numbers->pathTracedSamples, 2u);
    EXPECT_GT(numbers->numbers.mean, 0.0);
}

TEST_F(ViewportRealTimeErrors, NothingIsMeasuredUnlessAskedFor) {
    viewed.RenderFrames(2);
    EXPECT_FALSE(HasPass("RelativeSquaredError") || HasPass("FlipColumns") || HasPass("Flicker"));
    const viewport::RealTimeErrorsRequest request = viewed.viewport.RequestRealTimeErrors();
    viewed.RenderFrames(1);
    EXPECT_TRUE(HasPass("RelativeSquaredError") && HasPass("FlipColumns") && HasPass("Flicker"));
    EXPECT_TRUE(request.IsTaken());
    viewed.RenderFrames(1);
    EXPECT_FALSE(HasPass("RelativeSquaredError"));
    // Another comparison has no such errors
    viewed.viewport.SetShow({.view = View::Wipe});
    const viewport::RealTimeErrorsRequest other = viewed.viewport.RequestRealTimeErrors();
    viewed.RenderFrames(2);
    EXPECT_FALSE(other.IsTaken());
}

TEST_F(ViewportRealTimeErrors, ErrorFallsWithTheSamplesOfTheReferenceToThatOfTheFilter) {
    const viewport::RealTimeErrors first = Measure();
    EXPECT_EQ(first.referenceSamples, 1u);
    EXPECT_FALSE(first.referenceNoise.has_value());
    const viewport::RealTimeErrors second = Measure();
    ASSERT_TRUE(second.referenceNoise.has_value());
    viewed.viewport.SetBudget({.samplesPerFrame = 64});
    viewed.RenderFrames(32);
    const viewport::RealTimeErrors last = Measure();
    EXPECT_EQ(last.referenceSamples, viewed.Samples());
    ASSERT_TRUE(last.referenceNoise.has_value());
    EXPECT_LT(*last.referenceNoise, *second.referenceNoise / 16.0);
    EXPECT_LT(*last.referenceNoise, last.relativeSquaredError);
    EXPECT_LT(last.relativeSquaredError, first.relativeSquaredError / 4.0);
    EXPECT_GT(last.flip, 0.0);
    EXPECT_LT(last.flip, first.flip);
}

TEST_F(ViewportRealTimeErrors, FlickerIsOfFramesWithoutAChange) {
    EXPECT_FALSE(Measure().flicker.has_value());
    const std::optional<double> still = Measure().flicker;
    ASSERT_TRUE(still.has_value());
    EXPECT_GT(*still, 0.0);
    scene::CameraView camera = InsideBoxes();
    camera.eye.x += 0.1;
    viewed.viewport.SetCamera(camera);
    EXPECT_FALSE(Measure().flicker.has_value());
    EXPECT_TRUE(Measure().flicker.has_value());
}

TEST_F(ViewportRealTime, ScalesWithTheTimeOfItsFrames) {
    RealTimeView view("scaled");
    const auto declare = [&](double limitMs) {
        viewed.renderer.BeginFrame();
        const SceneIds ids = viewed.scene.Declare(viewed.renderer);
        const uint64_t pixels =
            view.Declare(viewed.renderer, ids,
                         passes::FrameSettings({64, 32}, InsideBoxes(), {}, viewed.viewport.Paths()), limitMs)
                .pixels;
        viewed.renderer.DropFrame();
        return pixels;
    };
    EXPECT_EQ(declare(0.0), 64u * 32);
    EXPECT_FALSE(view.ExpectedMs({64, 32}).has_value());
    view.AddTiming(64 * 32, 100.0);
    EXPECT_DOUBLE_EQ(view.ExpectedMs({128, 32}).value(), 200.0);
    EXPECT_EQ(declare(10.0), 16u * 8);  // 1 / 16 of the time
    EXPECT_EQ(declare(25.0), 16u * 8);  // A finer one would take all of it
    EXPECT_EQ(declare(40.0), 32u * 16);
    EXPECT_EQ(declare(23.0), 32u * 16);  // It takes a little longer, but history would be lost
    EXPECT_EQ(declare(0.0), 64u * 32);
    view.Release(viewed.renderer);
}

}  // namespace raygraph::testing::real_time_view_test
