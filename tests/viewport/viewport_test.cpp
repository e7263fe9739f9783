// Sizes, several viewports, and the frames of a host.
#include "tests/viewport/viewport_test.h"

#include "base/error.h"

namespace raygraph::testing::viewport_test {

namespace {

class ViewportTest : public VulkanTest {};

}  // namespace

TEST_F(ViewportTest, AnySize_IsLegal) {
    ViewedScene viewed(Device());
    viewed.viewport.SetView(View::Wipe);
    for (const Extent2D size : {Extent2D{1, 1}, {0, 0}, {3, 5}, {64, 1}, {0, 7}, {1, 33}, {31, 17}, {1, 1}}) {
        viewed.viewport.SetSize(size);
        if (size.IsEmpty()) {
            EXPECT_EQ(viewed.viewport.RenderFrame(), 0u);
            viewed.renderer.BeginFrame();
            EXPECT_FALSE(viewed.viewport.Declare().IsValid());
            viewed.renderer.Execute();
            continue;
        }
        EXPECT_EQ(viewed.Picture().size(), size_t{4} * size.width * size.height);
        EXPECT_EQ(viewed.Samples(), 1u);
    }
}

TEST_F(ViewportTest, NoArea_KeepsWhatThereIs) {
    ViewedScene viewed(Device());
    viewed.RenderFrames(2);
    viewed.viewport.SetSize({0, 0});
    viewed.RenderFrames(2);
    viewed.viewport.SetSize({24, 16});
    viewed.RenderFrames(1);
    EXPECT_EQ(viewed.Samples(), 3u);
    EXPECT_EQ(viewed.AllResets(), 0u);
}

TEST_F(ViewportTest, ADroppedFrame_ChangesNothing) {
    ViewedScene viewed(Device()), straight(Device());
    viewed.RenderFrames(1);
    viewed.renderer.BeginFrame();
    viewed.renderer.Present(viewed.viewport.Declare());
    viewed.renderer.DropFrame();
    EXPECT_EQ(viewed.Samples(), 1u);
    straight.RenderFrames(1);
    EXPECT_EQ(viewed.Picture(), straight.Picture());
}

TEST_F(ViewportTest, ThePicture_IsOpaqueAlsoWhereNothingIs) {
    ViewedScene viewed(Device(), {8, 8}, scene::SceneData{});
    viewed.scene.SetEnvironment({glm::vec3(1.0f), 0.0f});
    for (const View view : {View::PathTraced, View::Wipe, View::Difference}) {
        viewed.viewport.SetView(view);
        const std::vector<uint8_t> picture = viewed.Picture();
        for (size_t i = 3; i < picture.size(); i += 4) ASSERT_EQ(picture[i], 255) << viewport::Name(view);
    }
}

TEST_F(ViewportTest, DeclaredTwiceInAFrame_IsRefused) {
    ViewedScene viewed(Device());
    viewed.renderer.BeginFrame();
    const SceneIds ids = viewed.scene.Declare(viewed.renderer);
    std::ignore = viewed.viewport.Declare(ids);
    EXPECT_THROW(std::ignore = viewed.viewport.Declare(ids), Error);
}

TEST_F(ViewportTest, TwoViewportsOfTwoScenes_ShareNothing) {
    scene::SceneData other =
        SceneOf({BoxMesh(1.0f)}, {Lambert(glm::vec3(0.9f, 0.3f, 0.1f), glm::vec3(0.5f))});
    other.lights.push_back(Boxes().lights[0]);
    const auto makeOther = [&] { return ViewedScene(Device(), {16, 16}, scene::SceneData(other)); };
    std::vector<uint8_t> pictureA, pictureB;
    {
        ViewedScene alone(Device());
        alone.RenderFrames(2);
        pictureA = alone.Picture();
        alone.viewport.SetSize({16, 16});
        alone.scene.SetScene(scene::SceneData(other));
        alone.RenderFrames(2);
        pictureB = alone.Picture();
    }

    // The same names, interleaved
    ViewedScene a(Device()), b = makeOther();
    for (int i = 0; i < 2; ++i) {
        a.RenderFrames(1);
        b.RenderFrames(1);
    }
    EXPECT_EQ(a.Picture(), pictureA);
    EXPECT_EQ(b.Picture(), pictureB);
    EXPECT_NE(std::vector<uint8_t>(pictureA.begin(), pictureA.begin() + 512),
              std::vector<uint8_t>(pictureB.begin(), pictureB.begin() + 512));
}

TEST_F(ViewportTest, TwoViewportsOfOneScene_ShareAFrame) {
    ViewedScene viewed(Device());
    Viewport beside(viewed.renderer, viewed.scene, {.name = "beside", .size = {24, 16}});
    beside.SetCamera(InsideBoxes());
    beside.SetPaths(viewed.viewport.Paths());
    beside.SetRaster(PlainRaster());
    beside.SetView(View::Raster);
    for (int i = 0; i < 3; ++i) {
        viewed.renderer.BeginFrame();
        const SceneIds ids = viewed.scene.Declare(viewed.renderer);
        const TextureId first = viewed.viewport.Declare(ids), second = beside.Declare(ids);
        const Readback pictures[2] = {viewed.renderer.ReadBack(first), viewed.renderer.ReadBack(second)};
        viewed.renderer.Execute();
        pictures[1].Wait();
        const auto bytes = [&](int k) { return pictures[k].Bytes(); };
        EXPECT_FALSE(std::equal(bytes(0).begin(), bytes(0).end(), bytes(1).begin()));
    }
    EXPECT_EQ(viewed.Samples(), 3u);
    EXPECT_EQ(beside.Progress().pathTracedSamples, 0u);
    EXPECT_EQ(beside.Progress().rasterSamples, 3u);
    // One is toggled away, the other is not
    viewed.viewport.SetView(View::Raster);
    beside.SetView(View::PathTraced);
    viewed.renderer.BeginFrame();
    const SceneIds ids = viewed.scene.Declare(viewed.renderer);
    viewed.renderer.Present(viewed.viewport.Declare(ids));
    viewed.renderer.Present(beside.Declare(ids));
    viewed.renderer.Execute();
    EXPECT_EQ(viewed.Samples(), 3u);
    EXPECT_EQ(beside.Progress().pathTracedSamples, 1u);
}

TEST_F(ViewportTest, HostsPass_JoinsTheFrame) {
    ViewedScene viewed(Device());
    viewed.renderer.BeginFrame();
    const TextureId shown = viewed.viewport.Declare();
    TextureId copy = viewed.renderer.CreateTexture("host's copy", viewed.renderer.Desc(shown));
    viewed.renderer.AddPass(
        "HostsPass", PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.CopiesFrom(shown);
            copy = pass.CopiesTo(copy);
        },
        [shown, copy](CommandList& commands, const PassResources& resources) {
            commands.CopyTexture(resources.Texture(shown), resources.Texture(copy));
        });
    const Readback readback = viewed.renderer.ReadBack(copy);
    viewed.renderer.Execute();
    readback.Wait();
    ViewedScene straight(Device());
    const std::vector<uint8_t> picture = straight.Picture();
    EXPECT_EQ(std::memcmp(readback.Bytes().data(), picture.data(), picture.size()), 0);
}

TEST_F(ViewportTest, MaxSamples_StopTheView) {
    ViewedScene viewed(Device());
    viewed.viewport.SetBudget({.samplesPerFrame = 3, .maxSamples = 4, .maxRasterSamples = 2});
    viewed.RenderFrames(1);
    EXPECT_EQ(viewed.Samples(), 3u);
    const std::vector<uint8_t> done = viewed.Picture();
    EXPECT_EQ(viewed.Samples(), 4u);
    EXPECT_EQ(viewed.Picture(), done);
    EXPECT_EQ(viewed.Samples(), 4u);
    viewed.viewport.SetView(View::Raster);
    viewed.RenderFrames(4);
    EXPECT_EQ(viewed.viewport.Progress().rasterSamples, 2u);
    // One sample a frame gives the same picture
    ViewedScene straight(Device());
    straight.RenderFrames(3);
    EXPECT_EQ(straight.Picture(), done);
}

}  // namespace raygraph::testing::viewport_test
