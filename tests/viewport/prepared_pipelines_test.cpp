// Pipelines that are made on other threads: frames that need them can be left out meanwhile.
#include <chrono>
#include <thread>

#include "tests/viewport/viewport_test.h"

namespace raygraph::testing {
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

}  // namespace

TEST_F(PreparedPipelines, FramesGoOnWithThePictureThatThereIs) {
    EXPECT_FALSE(Begin()) << "the path tracer's pipeline takes longer";
    renderer.BeginFrame();
    EXPECT_FALSE(viewport.DeclareKept().IsValid()) << "there has been no picture";
    renderer.DropFrame();
    using std::chrono::steady_clock;
    const steady_clock::time_point start = steady_clock::now();
    const auto waitUntilThere = [&] {
        while (!Begin() && steady_clock::now() - start < std::chrono::minutes(2))
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    };
    waitUntilThere();
    const uint32_t before = renderer.PipelineCount();
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
    const TextureId kept = viewport.DeclareKept();
    ASSERT_TRUE(kept.IsValid());
    const Readback shown = renderer.ReadBack(kept);
    renderer.Execute();
    EXPECT_EQ(BytesOf(shown), traced);
    waitUntilThere();
    EXPECT_NE(Finish(), traced);
    EXPECT_TRUE(Begin());
    renderer.DropFrame();
}

// Those that are still being made when nobody wants them any more.
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

}  // namespace raygraph::testing
