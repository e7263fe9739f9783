// Sizes, several viewports, and the frames of a host.
#include <cmath>

#include "base/error.h"
#include "editor/viewport/vulkan_interop.h"
#include "passes/tiles.h"
#include "tests/viewport/viewport_test.h"

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
            EXPECT_FALSE(viewed.viewport.RenderFrame());
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

    // Two scenes with equal names render in turns.
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

// Picks and inspections of a pixel, compared with the whole picture.
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
    plain.more = {};  // a viewport's program has the features of its scene
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

TEST_F(Pixel, Samples_AreThoseOfThePictureAndPathsTheirs) {
    viewed.RenderFrames(3);
    const viewport::Inspection inspection = viewed.viewport.RequestInspection({13, 7});
    const viewport::SamplesRequest samples = viewed.viewport.RequestSamples({13, 7}, 0, 4);
    const viewport::PathRequest path = viewed.viewport.RequestPath({13, 7}, 2);
    viewed.RenderFrames(1);
    Device().WaitIdle();
    const viewport::PixelSamples answer = samples.Result();
    ASSERT_EQ(answer.values.size(), 4u);
    glm::vec3 mean(0.0f);
    for (const glm::vec3& value : answer.values) mean += 0.25f * value;
    const viewport::InspectResult shown = inspection.Result();
    ASSERT_TRUE(shown.pathTraced && shown.pathTraced->sampleCount == 4u);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean[c], shown.pathTraced->radiance[c], 1e-5f * (1.0f + mean[c]));
    ASSERT_TRUE(path.IsReady());
    EXPECT_EQ(passes::ValueOf(path.Result().vertices), answer.values[2]) << "to the bit";
    EXPECT_GT(path.Result().vertices.size(), 1u);
    EXPECT_EQ(viewed.Samples(), 4u) << "questions add no samples";

    // A drawn length of all paths of a sample
    viewport::PathSettings paths = viewed.viewport.Paths();
    paths.roulette = {.kind = Roulette::Frame, .survival = 0.5f};
    viewed.viewport.SetPaths(paths);
    const viewport::SamplesRequest drawn = viewed.viewport.RequestSamples({13, 7}, 5, 3);
    const viewport::PathRequest ofDrawn = viewed.viewport.RequestPath({13, 7}, 6);
    viewed.RenderFrames(1);
    Device().WaitIdle();
    ASSERT_EQ(drawn.Result().values.size(), 3u);
    EXPECT_EQ(passes::ValueOf(ofDrawn.Result().vertices), drawn.Result().values[1]);

    for (const auto& [first, count] : {std::pair(0u, 0u), {0u, 4097u}, {0xFFFFFFFFu, 2u}})
        EXPECT_THROW(std::ignore = viewed.viewport.RequestSamples({13, 7}, first, count), Error);
    EXPECT_THROW(std::ignore = viewed.viewport.RequestPath({24, 0}, 0), Error);
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
    // A pick and an inspection of one pixel return the values of the whole picture.
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

// A viewport's picture in images of a host.
namespace raygraph::testing::host_image_test {

using viewport::HostImage;

namespace {

class HostImageTest : public VulkanTest {
  protected:
    static constexpr Extent2D kSize{24, 16};

    // Shows frames in an image that a host made, leaves it in the layout of its own reads, and reads it.
    std::vector<uint8_t> ShownIn(ViewedScene& viewed, rhi::Format format, uint32_t frames) {
        const bool isCopied = format == rhi::Format::Rgba8Unorm || format == rhi::Format::Rgba8Srgb;
        const rhi::Texture image = Device().CreateTexture(
            {.name = "host's own",
             .extent = kSize,
             .format = format,
             .usage = rhi::TextureUsage::CopySource |
                      (isCopied ? rhi::TextureUsage::CopyDestination : rhi::TextureUsage::ColorTarget)});
        HostImage target(Device(), {.image = image.Image(),
                                    .extent = kSize,
                                    .format = format,
                                    .layoutAfter = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL});
        const rhi::Buffer buffer = Device().CreateBuffer({.name = "host's copy",
                                                          .size = 4 * kSize.width * kSize.height,
                                                          .usage = rhi::BufferUsage::CopyDestination,
                                                          .memory = rhi::MemoryKind::Readback});
        for (uint32_t i = 0; i < frames; ++i) {
            viewed.renderer.BeginFrame();
            target.Show(viewed.renderer, viewed.viewport.Declare());
            viewed.renderer.Execute();
            rhi::CommandList commands = Device().BeginCommands("host");
            commands.CopyToBuffer(image, buffer);
            commands.Transition(image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_GENERAL);
            Device().WaitFor(Device().Submit(std::move(commands)));
            target.Return(VK_IMAGE_LAYOUT_GENERAL);
        }
        Device().WaitIdle();
        std::vector<uint8_t> bytes(buffer.Size());
        std::memcpy(bytes.data(), buffer.Mapped().data(), bytes.size());
        return bytes;
    }
};

}  // namespace

TEST_F(HostImageTest, EveryFormatOfAScreen_ShowsThePicture) {
    ViewedScene viewed(Device(), kSize);
    viewed.viewport.SetBudget({.maxSamples = 1});
    const std::vector<uint8_t> expected = viewed.Picture();
    EXPECT_EQ(ShownIn(viewed, rhi::Format::Rgba8Unorm, 3), expected);
    EXPECT_EQ(ShownIn(viewed, rhi::Format::Rgba8Srgb, 3), expected);
    for (const rhi::Format format : {rhi::Format::Bgra8Unorm, rhi::Format::Bgra8Srgb}) {
        const std::vector<uint8_t> shown = ShownIn(viewed, format, 3);
        int greatest = 0;
        for (size_t i = 0; i < shown.size(); i += 4)
            for (size_t c = 0; c < 3; ++c)
                greatest = std::max(greatest, std::abs(int(shown[i + 2 - c]) - int(expected[i + c])));
        // Decoded and encoded again, a code may round to its neighbor
        EXPECT_LE(greatest, format == rhi::Format::Bgra8Unorm ? 0 : 1) << rhi::Name(format);
    }
}

TEST_F(HostImageTest, Semaphores_OrderTheHostsWorkAroundTheFrame) {
    VkSemaphoreTypeCreateInfo type{};
    type.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO;
    type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
    const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type, 0};
    VkSemaphore semaphore = VK_NULL_HANDLE;
    ASSERT_EQ(Device().Vk().vkCreateSemaphore(Device().Handle(), &info, nullptr, &semaphore), VK_SUCCESS);
    {
        const rhi::Texture image = Device().CreateTexture({.name = "host's own", .extent = kSize});
        ViewedScene viewed(Device(), kSize);
        HostImage target(Device(), {.image = image.Image(), .extent = kSize});
        viewed.renderer.BeginFrame();
        target.Show(viewed.renderer, viewed.viewport.Declare(),
                    {.wait = {{semaphore, 1}}, .signal = {{semaphore, 2}}});
        const rhi::Submission frame = viewed.renderer.Execute();
        EXPECT_LT(Device().CompletedValue(), frame.value);
        const VkSemaphoreSignalInfo signal{VK_STRUCTURE_TYPE_SEMAPHORE_SIGNAL_INFO, nullptr, semaphore, 1};
        ASSERT_EQ(Device().Vk().vkSignalSemaphore(Device().Handle(), &signal), VK_SUCCESS);
        Device().WaitFor(frame);
        uint64_t value = 0;
        ASSERT_EQ(Device().Vk().vkGetSemaphoreCounterValue(Device().Handle(), semaphore, &value), VK_SUCCESS);
        EXPECT_EQ(value, 2u);
        Device().WaitQueueIdle();
    }
    Device().Vk().vkDestroySemaphore(Device().Handle(), semaphore, nullptr);
}

TEST_F(HostImageTest, WhatCannotBeShown_IsRefused) {
    EXPECT_THROW(HostImage(Device(), {.extent = kSize}), Error);
    const rhi::Texture image = Device().CreateTexture({.name = "host's own", .extent = kSize});
    EXPECT_THROW(HostImage(Device(), {.image = image.Image(), .extent = {0, 4}}), Error);
    EXPECT_THROW(
        HostImage(Device(), {.image = image.Image(), .extent = kSize, .format = rhi::Format::D32Float}),
        Error);
    ViewedScene viewed(Device(), {8, 8});
    HostImage target(Device(), {.image = image.Image(), .extent = kSize});
    viewed.renderer.BeginFrame();
    const TextureId shown = viewed.viewport.Declare();
    EXPECT_THROW(target.Show(viewed.renderer, shown), Error);
}

}  // namespace raygraph::testing::host_image_test

// A picture made in tiles has the bits of one made whole.
namespace raygraph::testing::tiles_test {

using passes::Region;
using passes::TileCursor;

TEST(TileCursorTest, Tiles_CoverEveryPixelOnceWhateverTheirSize) {
    for (const Extent2D picture : {Extent2D{1, 1}, {7, 1}, {1, 40}, {37, 29}, {64, 64}})
        for (const uint64_t step : {1ull, 5ull, 36ull, 37ull, 100ull, 1000000ull}) {
            std::vector<int> seen(size_t{picture.width} * picture.height);
            TileCursor cursor;
            uint64_t pixels = step, done = 0;
            bool isLast = false;
            while (!isLast) {
                const Region tile = cursor.Next(picture, pixels);
                ASSERT_FALSE(tile.IsEmpty());
                ASSERT_LE(tile.x + tile.width, picture.width);
                ASSERT_LE(tile.y + tile.height, picture.height);
                ASSERT_TRUE(cursor.IsNext(picture, tile));
                for (uint32_t y = tile.y; y < tile.y + tile.height; ++y)
                    for (uint32_t x = tile.x; x < tile.x + tile.width; ++x) {
                        EXPECT_FALSE(cursor.Has(x, y));
                        seen[size_t{y} * picture.width + x]++;
                    }
                isLast = cursor.Advance(picture, tile);
                done += tile.PixelCount();
                if (!isLast) {
                    EXPECT_EQ(cursor.PixelCount(picture), done);
                    EXPECT_TRUE(cursor.Has(tile.x, tile.y));
                }
                pixels = pixels * 3 % 97 + step;  // from tile to tile, another size
            }
            EXPECT_TRUE(cursor.IsAtStart());
            EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), std::ssize(seen));
        }
}

TEST(TileCursorTest, Tiles_HoldAboutAsManyPixelsAsAskedFor) {
    const Extent2D picture{1920, 1080};
    TileCursor cursor;
    EXPECT_EQ(cursor.Next(picture, 5000).PixelCount(), 3840u);
    const Region part = cursor.Next(picture, 500);
    EXPECT_EQ(part.PixelCount(), 496u);
    cursor.Advance(picture, part);
    EXPECT_LE(cursor.Next(picture, 1 << 20).PixelCount(), 8u * 1920u);
    EXPECT_FALSE(cursor.IsNext(picture, {0, 0, 1920, 1080}));
}

namespace {

class Tiles : public VulkanTest {
  protected:
    Tiles() { render.scene.SetScene(Boxes()); }

    static passes::TraceSettings Settings() {
        passes::TraceSettings settings = LookAt({-0.8f, 0.1f, 0.3f}, {1.0f, -0.5f, 0.0f}, 1.2f, 1);
        settings.extent = kPicture;
        return settings;
    }
    struct Means {
        FloatImage mean, variance;
    };
    // Two samples, in tiles of about so many pixels.
    Means TwoSamples(uint64_t pixels) {
        passes::Accumulation accumulation("tiles");
        Readback mean;
        while (accumulation.SampleCount() < 2) {
            render.renderer.BeginFrame();
            const SceneIds ids = render.scene.Declare(render.renderer);
            // Two tiles a frame: the second begins where the first ends
            passes::AccumulatedIds taken;
            for (int i = 0; i < 2; ++i) {
                const passes::Accumulation::Progress at = accumulation.Declared();
                if (at.sampleCount == 2) break;
                passes::TraceSettings settings = Settings();
                settings.sampleIndex = at.sampleCount;
                settings.region = at.cursor.Next(kPicture, pixels);
                const TextureId tile = passes::Trace(render.renderer, ids, settings).radiance;
                taken = passes::AccumulateTile(render.renderer, tile, kPicture, settings.region, accumulation,
                                               true);
            }
            mean = render.renderer.ReadBack(taken.mean);
            render.renderer.Execute();
        }
        render.renderer.BeginFrame();
        const Readback variance =
            render.renderer.ReadBack(passes::Resolve(render.renderer, accumulation, kPicture, true).variance);
        render.renderer.Execute();
        return {ToFloatImage(mean), ToFloatImage(variance)};
    }

    static constexpr Extent2D kPicture{29, 19};
    SceneRender render{Device()};
};

}  // namespace

TEST_F(Tiles, SamplesInTiles_HaveTheBitsOfWholeOnes) {
    const Means whole = TwoSamples(1 << 20), rows = TwoSamples(100), parts = TwoSamples(20);
    EXPECT_EQ(rows.mean.values, whole.mean.values);
    EXPECT_EQ(rows.variance.values, whole.variance.values);
    EXPECT_EQ(parts.mean.values, whole.mean.values);
    EXPECT_EQ(parts.variance.values, whole.variance.values);
    EXPECT_GT(whole.variance.Mean().x, 0.0);
}

TEST_F(Tiles, PrimaryHitsOfARegion_AreThoseOfThePicture) {
    const SceneRender::Hits whole = render.PrimaryHits(Settings());
    passes::TraceSettings settings = Settings();
    settings.region = {11, 7, 3, 2};
    const SceneRender::Hits part = render.PrimaryHits(settings);
    ASSERT_EQ(part.ids.size(), 6u);
    for (uint32_t y = 0; y < 2; ++y)
        for (uint32_t x = 0; x < 3; ++x) {
            EXPECT_EQ(part.ids[y * 3 + x], whole.ids[(y + 7) * kPicture.width + x + 11]);
            EXPECT_EQ(part.position.At(x, y), whole.position.At(x + 11, y + 7));
        }
}

TEST_F(Tiles, WhatDoesNotFit_IsRefused) {
    passes::TraceSettings settings = Settings();
    settings.region = {20, 0, 10, 1};
    EXPECT_THROW(render.TraceOnce(settings), Error);

    passes::Accumulation accumulation("tiles");
    render.renderer.BeginFrame();
    const TextureId tile = render.renderer.CreateTexture("tile", {{29, 4}, Format::Rgba32Float});
    // Not what comes first, and not of the region's size
    EXPECT_THROW(
        std::ignore = passes::AccumulateTile(render.renderer, tile, kPicture, {0, 4, 29, 4}, accumulation),
        Error);
    EXPECT_THROW(
        std::ignore = passes::AccumulateTile(render.renderer, tile, kPicture, {0, 0, 29, 3}, accumulation),
        Error);
}

}  // namespace raygraph::testing::tiles_test
