// Picks and inspections of a pixel, compared with the whole picture.
#include <cmath>

#include "base/error.h"
#include "tests/viewport/viewport_test.h"

namespace raygraph::testing::pixel_test {

namespace {

class Pixel : public VulkanTest {
  protected:
    static constexpr Extent2D kSize{24, 16};
    static passes::TraceSettings Settings() {
        passes::TraceSettings settings;
        scene::CameraView camera = InsideBoxes();
        camera.aspect = 1.5f;
        settings.extent = kSize;
        settings.camera = ToRecord(camera);
        settings.scattering.brdf = BrdfModel::Lambert;
        return settings;
    }

    ViewedScene viewed{Device(), kSize};
};

}  // namespace

TEST_F(Pixel, Pick_IsWhatPrimaryHitsSays) {
    SceneRender plain(Device());
    plain.scene.SetScene(Boxes());
    const SceneRender::Hits hits = plain.PrimaryHits(Settings());
    for (const View view : {View::PathTraced, View::Raster}) {
        viewed.viewport.SetView(view);
        std::vector<viewport::Pick> picks;
        for (uint32_t i = 0; i < 12; ++i) picks.push_back(viewed.viewport.RequestPick({2 * i + 1, i}));
        EXPECT_FALSE(picks[0].IsReady());
        EXPECT_THROW(std::ignore = picks[0].Result(), Error);
        viewed.RenderFrames(1);
        Device().WaitIdle();
        std::vector<uint32_t> instances;
        for (const viewport::Pick& pick : picks) {
            ASSERT_TRUE(pick.IsReady());
            const viewport::PickResult result = pick.Result();
            const size_t at = size_t{result.pixel.y} * kSize.width + result.pixel.x;
            const glm::uvec4& ids = hits.ids[at];
            const glm::vec4& position = hits.position.values[at];
            ASSERT_TRUE(result.isHit);
            EXPECT_EQ(glm::uvec4(result.instance, result.material, result.primitive, result.geometry), ids);
            EXPECT_EQ(result.position, glm::vec3(position));
            EXPECT_EQ(result.depth, position.w);
            EXPECT_EQ(result.normal, glm::vec3(hits.normal.values[at]));
            instances.push_back(result.instance);
        }
        EXPECT_TRUE(std::count(instances.begin(), instances.end(), 0u) > 0 &&
                    std::count(instances.begin(), instances.end(), 1u) > 0);
    }
}

TEST_F(Pixel, Pick_OfNothingIsNoHit) {
    viewed.scene.SetScene(scene::SceneData{});
    const viewport::Pick pick = viewed.viewport.RequestPick({3, 3});
    viewed.RenderFrames(1);
    Device().WaitIdle();
    EXPECT_FALSE(pick.Result().isHit);
}

TEST_F(Pixel, Requests_OutliveADroppedFrameAndASmallerPicture) {
    const viewport::Pick pick = viewed.viewport.RequestPick({20, 10});
    const viewport::Inspection inspection = viewed.viewport.RequestInspection({20, 10});
    viewed.renderer.BeginFrame();
    viewed.renderer.Present(viewed.viewport.Declare());
    viewed.renderer.DropFrame();
    Device().WaitIdle();
    EXPECT_FALSE(pick.IsReady());
    EXPECT_FALSE(inspection.IsReady());
    viewed.RenderFrames(1);
    Device().WaitIdle();
    EXPECT_TRUE(pick.IsReady() && pick.Result().isHit);
    EXPECT_TRUE(inspection.IsReady() && inspection.Result().pathTraced.has_value());

    const viewport::Pick lost = viewed.viewport.RequestPick({20, 10});
    viewed.viewport.SetSize({8, 8});
    viewed.RenderFrames(1);
    Device().WaitIdle();
    EXPECT_TRUE(lost.IsReady());
    EXPECT_FALSE(lost.Result().isHit);
    EXPECT_THROW(std::ignore = viewed.viewport.RequestPick({8, 0}), Error);
    EXPECT_THROW(std::ignore = viewed.viewport.RequestInspection({0, 8}), Error);
}

TEST_F(Pixel, Inspection_HasMeanSamplesAndStandardError) {
    SceneRender plain(Device());
    plain.scene.SetScene(Boxes());
    const RenderedImage image = plain.Render(Settings(), 4);
    viewed.RenderFrames(3);
    const viewport::Inspection inspection = viewed.viewport.RequestInspection({13, 7});
    viewed.RenderFrames(1);
    Device().WaitIdle();
    const viewport::InspectResult result = inspection.Result();
    ASSERT_TRUE(result.pathTraced.has_value());
    EXPECT_FALSE(result.raster.has_value());
    EXPECT_EQ(result.pathTraced->sampleCount, 4u);
    EXPECT_EQ(result.pathTraced->radiance, glm::vec3(image.mean.At(13, 7)));
    EXPECT_EQ(result.pathTraced->coverage, 1.0f);
    EXPECT_FLOAT_EQ(result.pathTraced->standardError.x, std::sqrt(image.variance.At(13, 7).x / 4.0f));
    EXPECT_GT(result.pathTraced->standardError.x, 0.0f);

    // Looking at the raster view adds no path-traced sample
    viewed.viewport.SetView(View::Raster);
    const viewport::Inspection other = viewed.viewport.RequestInspection({13, 7});
    viewed.RenderFrames(1);
    Device().WaitIdle();
    EXPECT_FALSE(other.Result().pathTraced.has_value());
    ASSERT_TRUE(other.Result().raster.has_value());
    EXPECT_EQ(other.Result().raster->sampleCount, 1u);
    EXPECT_TRUE(std::isinf(other.Result().raster->standardError.x));
    EXPECT_EQ(viewed.Samples(), 4u);
}

TEST_F(Pixel, Error_IsThatOfAllPixels) {
    viewed.RenderFrames(6);
    const viewport::NoiseRequest request = viewed.viewport.RequestNoise();
    EXPECT_FALSE(request.IsReady());
    const viewport::Capture capture = viewed.viewport.RequestCapture();
    viewed.RenderFrames(1);
    Device().WaitIdle();
    ASSERT_TRUE(request.IsReady());
    ASSERT_TRUE(capture.IsReady());
    const viewport::CaptureResult all = capture.Result();
    double mean = 0.0, variance = 0.0;
    for (size_t i = 0; i < all.mean.size(); ++i) {
        if (i % 4 == 3) continue;
        mean += all.mean[i];
        variance += all.variance[i];
    }
    const double count = 3.0 * 24 * 16;
    const double expected = std::sqrt(variance / count / all.sampleCount) / (mean / count);
    const viewport::NoiseEstimate estimate = request.Result();
    EXPECT_EQ(estimate.sampleCount, all.sampleCount);
    ASSERT_TRUE(estimate.relativeError);
    EXPECT_NEAR(*estimate.relativeError, expected, 1e-6) << "of a picture this small, every pixel is probed";
}

TEST_F(Pixel, Capture_IsThePictureOfWholeSamplesWithWhatLiesBehindIt) {
    viewed.RenderFrames(2);
    const viewport::Capture capture = viewed.viewport.RequestCapture();
    EXPECT_FALSE(capture.IsReady());
    EXPECT_THROW(std::ignore = capture.Result(), Error);
    viewed.viewport.SetView(View::Surface);
    viewed.RenderFrames(1);
    Device().WaitIdle();
    EXPECT_FALSE(capture.IsReady()) << "no light is shown";
    viewed.viewport.SetView(View::Wipe);
    viewed.RenderFrames(1);
    Device().WaitIdle();
    ASSERT_TRUE(capture.IsReady());
    const viewport::CaptureResult result = capture.Result();
    EXPECT_FALSE(result.isRaster);
    EXPECT_EQ(result.sampleCount, viewed.Samples());
    const size_t pixels = size_t{24} * 16;
    EXPECT_EQ(result.mean.size(), 4 * pixels);
    EXPECT_EQ(result.variance.size(), 4 * pixels);
    EXPECT_EQ(result.depth.size(), pixels);
    // The same that a pick and an inspection of one pixel say
    const viewport::Pick pick = viewed.viewport.RequestPick({13, 9});
    viewed.RenderFrames(1);
    Device().WaitIdle();
    const size_t at = 9 * 24 + 13;
    EXPECT_EQ(result.instance[at], pick.Result().instance);
    EXPECT_EQ(result.material[at], pick.Result().material);
    EXPECT_EQ(result.depth[at], pick.Result().depth);
    EXPECT_EQ(result.normal[4 * at], pick.Result().normal.x);
    viewed.viewport.SetView(View::Raster);
    const viewport::Capture drawn = viewed.viewport.RequestCapture();
    viewed.RenderFrames(1);
    Device().WaitIdle();
    ASSERT_TRUE(drawn.IsReady());
    EXPECT_TRUE(drawn.Result().isRaster);
}

}  // namespace raygraph::testing::pixel_test
