// What restarts accumulation, with which cause, and what does not.
#include <gmock/gmock.h>

#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::reset_test {

using passes::ResetCause;
using ::testing::HasSubstr;
using ::testing::Not;

namespace {

class ViewportReset : public VulkanTest {
  protected:
    // Two samples, then a frame after the edit: it alone is in the mean, for this cause and no other.
    void ExpectReset(ResetCause cause, const std::function<void()>& edit) {
        viewed.RenderFrames(2);
        ASSERT_GE(viewed.Samples(), 2u);
        const uint32_t before = viewed.viewport.ResetCount(cause), allBefore = viewed.AllResets();
        edit();
        viewed.RenderFrames(1);
        EXPECT_EQ(viewed.Samples(), 1u) << passes::Name(cause);
        EXPECT_EQ(viewed.viewport.ResetCount(cause), before + 1) << passes::Name(cause);
        EXPECT_EQ(viewed.AllResets(), allBefore + 1) << passes::Name(cause);
    }
    void ExpectNoReset(const std::function<void()>& edit) {
        viewed.RenderFrames(1);
        const uint32_t samples = viewed.Samples(), resets = viewed.AllResets();
        edit();
        viewed.RenderFrames(1);
        EXPECT_EQ(viewed.Samples(), samples + 1);
        EXPECT_EQ(viewed.AllResets(), resets);
    }

    ViewedScene viewed{Device()};
};

std::string CulledPasses(const std::string& plan) {
    const size_t begin = plan.find("\nculled\n");
    if (begin == std::string::npos) return "";
    return plan.substr(begin, plan.find("\n\n", begin + 1) - begin);
}

}  // namespace

TEST_F(ViewportReset, EveryEdit_StartsAnewAndIsCountedByItsCause) {
    ExpectReset(ResetCause::Camera, [&] {
        scene::CameraView camera = InsideBoxes();
        camera.eye.x += 0.01f;
        viewed.viewport.SetCamera(camera);
    });
    ExpectReset(ResetCause::Transform, [&] {
        viewed.scene.SetTransform(1, Translation({0.3f, -0.5f, 0.1f}));
    });
    ExpectReset(ResetCause::Material,
                [&] { viewed.scene.SetMaterial(1, Lambert(glm::vec3(0.8f, 0.2f, 0.2f))); });
    ExpectReset(ResetCause::Light, [&] {
        scene::Light light = viewed.scene.Light(0);
        light.intensity *= 2.0f;
        viewed.scene.SetLight(0, light);
    });
    ExpectReset(ResetCause::Geometry, [&] { viewed.scene.SetVisible(1, false); });
    ExpectReset(ResetCause::Environment, [&] { viewed.scene.SetEnvironment({glm::vec3(0.5f), 0.0f}); });
    ExpectReset(ResetCause::Resize, [&] { viewed.viewport.SetSize({17, 9}); });
    ExpectReset(ResetCause::Settings, [&] {
        viewport::PathSettings paths = viewed.viewport.Paths();
        paths.biases.maxDepth = 2;
        viewed.viewport.SetPaths(paths);
    });
    ExpectReset(ResetCause::Geometry, [&] { viewed.scene.SetScene(Boxes()); });
}

TEST_F(ViewportReset, EditsThatChangeNothing_DoNotReset) {
    viewed.scene.SetVisible(1, true);
    ExpectNoReset([&] {
        viewed.viewport.SetCamera(InsideBoxes());
        viewed.viewport.SetSize(viewed.viewport.Size());
        viewed.viewport.SetPaths(viewed.viewport.Paths());
        viewed.viewport.SetScene(viewed.scene);
        viewed.scene.SetTransform(1, viewed.scene.Transform(1));
        viewed.scene.SetVisible(1, true);
        viewed.scene.SetMaterial(1, Lambert(glm::vec3(0.8f)));
        viewed.scene.SetLight(0, viewed.scene.Light(0));
        viewed.scene.SetEnvironment(viewed.scene.Environment());
        viewed.scene.RemoveEnvironmentMap();
    });
}

TEST_F(ViewportReset, RasterSettings_ResetTheRasterViewAlone) {
    viewed.viewport.SetView(View::Wipe);
    viewed.RenderFrames(2);
    viewed.viewport.SetRaster({.shadows = passes::RasterShadows::Off, .hasOcclusion = true});
    viewed.RenderFrames(1);
    EXPECT_EQ(viewed.Samples(), 3u);
    EXPECT_EQ(viewed.viewport.Progress().rasterSamples, 1u);
    EXPECT_EQ(viewed.AllResets(), 0u);
}

TEST_F(ViewportReset, WhatComesAfterAccumulation_NeverResets) {
    ExpectNoReset([&] {
        viewport::ShowSettings show;
        show.tonemap = {.exposureEv = 3.0f, .tonemapOperator = TonemapOperator::Aces};
        show.maxError = 0.1f;
        viewed.viewport.SetShow(show);
    });
    ExpectNoReset([&] {
        viewport::ShowSettings show = viewed.viewport.Show();
        show.view = View::Wipe;
        show.wipePosition = 0.2f;
        viewed.viewport.SetShow(show);
    });
    ExpectNoReset([&] { viewed.viewport.SetBudget({.frameMs = 1000.0, .samplesPerFrame = 1}); });
}

TEST_F(ViewportReset, ToggledAway_TheViewIsCulledAndGoesOnWhenItIsBack) {
    ViewedScene straight(Device());
    straight.RenderFrames(3);
    viewed.RenderFrames(2);
    viewed.viewport.SetView(View::Raster);
    viewed.RenderFrames(3);
    const std::string culled = CulledPasses(viewed.renderer.DescribePlan());
    const bool isLoop = passes::DefaultForm(Device()) == passes::IntegratorForm::Loop;
    const std::string tracing = isLoop ? "    Trace (" : "    WaveFirst (";
    EXPECT_THAT(culled, HasSubstr(tracing));
    EXPECT_THAT(culled, Not(HasSubstr("    RasterShade (")));
    EXPECT_EQ(viewed.Samples(), 2u);
    EXPECT_EQ(viewed.viewport.Progress().rasterSamples, 3u);

    viewed.viewport.SetView(View::PathTraced);
    viewed.RenderFrames(1);
    const std::string culledNow = CulledPasses(viewed.renderer.DescribePlan());
    EXPECT_THAT(culledNow, HasSubstr("    RasterShade ("));
    EXPECT_THAT(culledNow, HasSubstr("    CullInstances ("));
    EXPECT_THAT(culledNow, Not(HasSubstr(tracing)));
    EXPECT_EQ(viewed.Samples(), 3u);
    EXPECT_EQ(viewed.viewport.Progress().rasterSamples, 3u);
    EXPECT_EQ(viewed.AllResets(), 0u);
    EXPECT_EQ(viewed.Picture(), straight.Picture());
}

TEST_F(ViewportReset, AfterAViewThatShowsNoDisplay_ThePictureIsTheAccumulations) {
    ViewedScene straight(Device());
    straight.RenderFrames(4);
    viewed.RenderFrames(1);
    viewed.viewport.SetView(View::Difference);  // goes on accumulating, and shows neither picture
    viewed.RenderFrames(2);
    viewed.viewport.SetView(View::PathTraced);
    viewed.viewport.SetBudget({.maxSamples = 3});
    const std::vector<uint8_t> picture = viewed.Picture();
    EXPECT_EQ(viewed.Samples(), 3u);
    ViewedScene three(Device());
    three.RenderFrames(2);
    EXPECT_EQ(picture, three.Picture());
    EXPECT_NE(picture, straight.Picture());
}

TEST_F(ViewportReset, WhileTheCameraMoves_TheRasterViewStandsInIfAskedFor) {
    viewed.viewport.SetBudget({.whileMoving = viewport::MotionView::Raster, .settleMs = 1e9});
    viewed.RenderFrames(2);
    EXPECT_EQ(viewed.Samples(), 2u);
    scene::CameraView camera = InsideBoxes();
    camera.eye.x += 0.01f;
    viewed.viewport.SetCamera(camera);
    viewed.RenderFrames(2);
    EXPECT_EQ(viewed.Samples(), 0u);
    EXPECT_EQ(viewed.viewport.Progress().rasterSamples, 2u);
    viewed.viewport.SetBudget({.whileMoving = viewport::MotionView::Raster, .settleMs = 0.0});
    viewed.RenderFrames(2);
    EXPECT_EQ(viewed.Samples(), 2u);
    EXPECT_EQ(viewed.viewport.Progress().rasterSamples, 2u);
}

TEST_F(ViewportReset, SceneRevisions_CountEditsByKind) {
    const SceneRevisions before = viewed.scene.Revisions();
    viewed.scene.SetTransform(1, Translation({0.1f, 0.0f, 0.0f}));
    viewed.scene.SetTransform(1, Translation({0.2f, 0.0f, 0.0f}));
    viewed.scene.SetVisible(0, false);
    EXPECT_FALSE(viewed.scene.IsVisible(0));
    SceneRevisions expected = before;
    expected.transforms += 2;
    ++expected.geometry;
    EXPECT_EQ(viewed.scene.Revisions(), expected);
}

TEST_F(ViewportReset, SetLight_IsSeenAndRebuildsTheLightTablesAlone) {
    viewed.RenderFrames(2);
    const std::vector<uint8_t> dim = viewed.Picture();
    // Compaction, which ends when the device has told the sizes, rebuilds the instances' structure
    for (int frame = 0; frame < 16 && !viewed.scene.IsSettled(); ++frame) {
        Device().WaitIdle();
        viewed.RenderFrames(1);
    }
    ASSERT_TRUE(viewed.scene.IsSettled());
    const GpuSceneStatistics before = viewed.scene.Statistics();
    scene::Light light = viewed.scene.Light(0);
    light.intensity *= 20.0f;
    viewed.scene.SetLight(0, light);
    const std::vector<uint8_t> bright = viewed.Picture();
    uint64_t dimSum = 0, brightSum = 0;
    for (size_t i = 0; i < dim.size(); ++i) {
        dimSum += dim[i];
        brightSum += bright[i];
    }
    EXPECT_GT(brightSum, dimSum + dimSum / 20);
    EXPECT_EQ(viewed.scene.Statistics().lightRebuilds, before.lightRebuilds + 1);
    EXPECT_EQ(viewed.scene.Statistics().tlasRebuilds, before.tlasRebuilds);
    EXPECT_EQ(viewed.scene.Statistics().tlasUpdates, before.tlasUpdates);

    light.intensity = -1.0f;
    EXPECT_THROW(viewed.scene.SetLight(0, light), Error);
    EXPECT_THROW(viewed.scene.SetLight(1, viewed.scene.Light(0)), Error);
}

}  // namespace raygraph::testing::reset_test
