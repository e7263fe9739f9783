#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "renderer/image/exr.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/direct_light_reference.h"
#include "tests/support/image_compare.h"
#include "tests/support/reference_assets.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

// Reads and compares reference images of other renderers.
namespace raygraph::testing {

struct ReferenceImage {
    uint32_t width = 0, height = 0;
    std::vector<float> channels[3];

    double At(uint32_t x, uint32_t y, int channel) const {
        return double{channels[channel][size_t{y} * width + x]};
    }
    glm::dvec3 Mean() const;
};

// Skips its tests if there are no references.
class ReferenceTest : public VulkanTest {
  protected:
    void SetUp() override;
    ReferenceImage Read(const std::string& name) const;  // a file of references/, e.g. "cornell_metal.exr"

    std::filesystem::path assets;
    SceneRender render{Device()};
};

// Averages the picture over blocks of `size` x `size` pixels, row by row; incomplete blocks at the edges are
// omitted.
template <typename Value>
std::vector<double> Blocks(uint32_t width, uint32_t height, uint32_t size, Value&& value) {
    const uint32_t columns = width / size, rows = height / size;
    std::vector<double> blocks(size_t{columns} * rows, 0.0);
    for (uint32_t y = 0; y < rows * size; ++y)
        for (uint32_t x = 0; x < columns * size; ++x)
            blocks[size_t{y / size} * columns + x / size] += value(x, y) / (double(size) * size);
    return blocks;
}

glm::dvec3 ReferenceImage::Mean() const {
    glm::dvec3 mean(0.0);
    for (int c = 0; c < 3; ++c)
        for (const float value : channels[c]) mean[c] += double{value};
    return mean / double(channels[0].size());
}

void ReferenceTest::SetUp() {
    render.more = {};  // many samples take longer than the compilation
    VulkanTest::SetUp();
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    assets = *test::ReferenceAssets();
}

ReferenceImage ReferenceTest::Read(const std::string& name) const {
    const image::ExrImage exr = image::ReadExr(assets / "references" / name);
    ReferenceImage reference{exr.width, exr.height, {}};
    for (int c = 0; c < 3; ++c) {
        const std::vector<float>* channel = exr.FloatChannel(std::string(1, "RGB"[c]));
        EXPECT_NE(channel, nullptr);
        if (channel != nullptr) reference.channels[c] = *channel;
    }
    return reference;
}

}  // namespace raygraph::testing

// Compares with pictures of renderers whose models differ a little from ours, by the tolerances in their
// descriptions.
namespace raygraph::testing::references_test {

namespace {

struct BlockTest {
    uint32_t size = 4;         // of a block, in pixels of our picture
    double relative = 0.02;    // tolerance of a block, beyond three standard errors of ours
    double minShare = 0.95;    // minimal fraction of blocks and channels within the tolerance
    double meanError = 0.01;   // relative tolerance of the mean over all compared blocks
    double minCoverage = 0.0;  // blocks that surfaces cover less are skipped
    // Selects further blocks to skip, by column and row.
    std::function<bool(size_t, size_t)> isLeftOut = [](size_t, size_t) { return false; };
};

// `image` shows the reference's view with fewer pixels.
void ExpectSameBlocks(const RenderedImage& image, const ReferenceImage& reference, const BlockTest& test) {
    const uint32_t width = image.mean.extent.width, height = image.mean.extent.height;
    const uint32_t scale = reference.width / width;
    ASSERT_EQ(reference.width, scale * width);
    ASSERT_EQ(reference.height, scale * height);
    const auto of = [&](const FloatImage& values, int channel) {
        return Blocks(width, height, test.size,
                      [&](uint32_t x, uint32_t y) { return double{values.At(x, y)[channel]}; });
    };
    const auto coverage = of(image.mean, 3);
    const size_t columns = width / test.size;
    const double samplesInBlock = double(test.size) * test.size * image.sampleCount;
    size_t count = 0, passed = 0;
    std::string worst;
    double farthest = 0.0;
    for (int channel = 0; channel < 3; ++channel) {
        const auto ours = of(image.mean, channel), variance = of(image.variance, channel);
        const auto theirs = Blocks(reference.width, reference.height, test.size * scale,
                                   [&](uint32_t x, uint32_t y) { return reference.At(x, y, channel); });
        double sum = 0.0, expectedSum = 0.0, meanError = 0.0;
        for (size_t i = 0; i < ours.size(); ++i) {
            if (coverage[i] < test.minCoverage || test.isLeftOut(i % columns, i / columns)) continue;
            const double sigma = std::sqrt(variance[i] / samplesInBlock);
            const double off = std::abs(ours[i] - theirs[i]) - 3.0 * sigma - 1e-3;
            ++count;
            if (off <= test.relative * theirs[i]) ++passed;
            if (off / theirs[i] > farthest) {
                farthest = off / theirs[i];
                worst = std::to_string(i % columns) + ", " + std::to_string(i / columns) + ", channel " +
                        std::to_string(channel) + ": " + std::to_string(ours[i]) + " for " +
                        std::to_string(theirs[i]);
            }
            sum += ours[i], expectedSum += theirs[i], meanError = std::hypot(meanError, sigma);
        }
        EXPECT_NEAR(sum, expectedSum, test.meanError * expectedSum + 3.0 * meanError)
            << "channel " << channel;
    }
    EXPECT_GT(count, 100u);
    EXPECT_GE(double(passed), test.minShare * double(count)) << "of " << count << ", the worst " << worst;
}

class References : public ReferenceTest {
  protected:
    static passes::TraceSettings ViewOf(const scene::SceneData& data, uint32_t width, uint32_t height) {
        passes::TraceSettings settings;
        settings.extent = {width, height};
        settings.camera = ToRecord(scene::ChooseView(data, "", float(width) / float(height)));
        // Cycles 3.4 does so
        settings.scattering.masking = MaskingModel::Separable;
        settings.scattering.multiscatter = MultiscatterKind::Off;
        return settings;
    }
};

}  // namespace

// The OPAQUE panel on the left is skipped: where its texture has no alpha, Cycles renders it black.
TEST_F(References, Trace_AlphaModesCoverAndShadowAsInCycles) {
    const ReferenceImage reference = Read("alphablend_lambert.exr");
    scene::SceneData data = scene::LoadGltf(assets / "references/scenes/AlphaBlendModeTest_cam.glb");
    passes::TraceSettings settings = ViewOf(data, 120, 60);
    settings.scattering.brdf = BrdfModel::Lambert;
    for (scene::Material& material : data.materials) material.isDoubleSided = true;  // Cycles culls nothing
    render.scene.SetScene(std::move(data));
    render.scene.SetEnvironment({.radiance = {0.3f, 0.4f, 0.5f}});
    const auto isOpaquePanel = [](size_t column, size_t row) {
        return column >= 4 && column <= 6 && row >= 4 && row <= 11;
    };
    ExpectSameBlocks(render.Render(settings, 32), reference,
                     {.minShare = 0.995, .meanError = 0.003, .isLeftOut = isOpaquePanel});
}

TEST_F(References, Trace_MetalInTheCornellBoxIsAsInCycles) {
    const ReferenceImage reference = Read("cornell_metal.exr");
    scene::SceneData data = scene::LoadGltf(assets / "references/scenes/cornell_metal.gltf");
    for (scene::Material& material : data.materials)
        if (material.metallicFactor == 0.0f) material.specularFactor = 0.0f;  // Lambert's in the reference
    const passes::TraceSettings settings = ViewOf(data, 80, 80);
    render.scene.SetScene(std::move(data));
    ExpectSameBlocks(render.Render(settings, 64), reference, {.size = 10});
}

// Few samples see the sun in a mirror: it is in the mean, and in few blocks.
TEST_F(References, Trace_MetalSpheresUnderAnEnvironmentMapAreAsInCycles) {
    RAYGRAPH_SKIP_WITHOUT_ASSET_SCENES();
    const ReferenceImage reference = Read("spheres_metal_esplanade.exr");
    scene::SceneData data = scene::LoadGltf(assets / "references/scenes/spheres_metal.gltf");
    const passes::TraceSettings settings = ViewOf(data, 160, 32);
    render.scene.SetScene(std::move(data));
    render.scene.SetEnvironmentMap(
        image::ReadEnvironment(assets / "scenes/env/royal_esplanade_1k.hdr").image);
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    ExpectSameBlocks(render.Render(settings, 32), reference,
                     {.relative = 0.03, .meanError = 0.2, .minCoverage = 1.0});
}

}  // namespace raygraph::testing::references_test

// Compares the Cornell box with independent renderers. It is skipped if RAYGRAPH_ASSETS is unset.
namespace raygraph::testing::cornell_reference_test {

namespace {

class CornellReference : public ReferenceTest {
  protected:
    RenderedImage Render(uint32_t size, uint32_t samples) {
        scene::SceneData data = scene::LoadGltf(assets / "references/scenes/cornell_lambert.gltf");
        passes::TraceSettings settings;
        settings.extent = {size, size};
        settings.scattering.brdf = BrdfModel::Lambert;
        settings.camera = ToRecord(scene::ChooseView(data, "", 1.0f));
        render.scene.SetScene(std::move(data));
        return render.Render(settings, samples);
    }
};

// Returns for each block the mean over it and its neighbors.
std::vector<double> Pooled(const std::vector<double>& values, int columns) {
    const int rows = static_cast<int>(values.size()) / columns;
    std::vector<double> pooled(values.size(), 0.0);
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            int count = 0;
            for (int v = std::max(0, y - 2); v < std::min(rows, y + 3); ++v)
                for (int u = std::max(0, x - 2); u < std::min(columns, x + 3); ++u, ++count)
                    pooled[size_t(y * columns + x)] += values[size_t(v * columns + u)];
            pooled[size_t(y * columns + x)] /= count;
        }
    return pooled;
}

}  // namespace

// The reference (2048 samples) has noise of its own, of which only the mean square is known; it is assumed to
// be distributed like ours. On the upper walls it is 1 % darker than ours and pbrt's, which this test cannot
// detect.
TEST_F(CornellReference, Trace_AgreesWithCyclesBlockByBlock) {
    const ReferenceImage reference = Read("cornell_lambert.exr");
    ASSERT_EQ(reference.width, 320u);
    constexpr uint32_t kSamples = 64;
    constexpr double kReferenceSamples = 2048;
    const RenderedImage image = Render(320, kSamples);

    const glm::dvec3 mean = image.mean.Mean(), expected = reference.Mean();
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean[c], expected[c], 0.005 * expected[c]) << "channel " << c;

    // A z-test on averages of blocks: a single pixel at these sample counts has seen the lamp a few times or
    // not at all, and its sample variance is no measure of its error.
    constexpr uint32_t kBlock = 8;
    size_t passed = 0, count = 0;
    for (int c = 0; c < 3; ++c) {
        const auto ours =
            Blocks(320, 320, kBlock, [&](uint32_t x, uint32_t y) { return image.mean.At(x, y)[c]; });
        const auto variance =
            Blocks(320, 320, kBlock, [&](uint32_t x, uint32_t y) { return image.variance.At(x, y)[c]; });
        const auto theirs = Blocks(
            320, 320, kBlock, [&](uint32_t x, uint32_t y) { return reference.channels[c][y * 320 + x]; });
        const std::vector<double> pooled = Pooled(variance, 320 / kBlock);
        for (size_t i = 0; i < ours.size(); ++i) {
            const double perSample = std::max(variance[i], pooled[i]) / (kBlock * kBlock);
            const double sigma = std::sqrt(perSample / kSamples + perSample / kReferenceSamples);
            ++count;
            if (std::abs(ours[i] - theirs[i]) <= 4.0 * sigma + 1e-6) ++passed;
        }
    }
    EXPECT_GE(double(passed) / double(count), 0.9975);
}

TEST_F(CornellReference, Trace_AgreesWithPbrtInTheMean) {
    const ReferenceImage reference = Read("pbrt_cornell_lambert.exr");
    const glm::dvec3 mean = Render(128, 256).mean.Mean(), expected = reference.Mean();
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(mean[c], expected[c], 0.015 * expected[c]) << "channel " << c;
}

}  // namespace raygraph::testing::cornell_reference_test

// Compares a textured scene with the picture that support/direct_light_reference computes independently.
namespace raygraph::testing::textured_reference_test {

namespace {

using scene::AlphaMode;
using scene::ColorSpace;
using scene::FilterMode;
using scene::WrapMode;

constexpr std::array kModes{WrapMode::Repeat, WrapMode::MirroredRepeat, WrapMode::ClampToEdge};

// Makes texels with values of all kinds; they are the same in every run.
scene::ImageData Texels(uint32_t width, uint32_t height, uint32_t step) {
    scene::ImageData image{.name = "texels", .width = width, .height = height, .rgba = {}};
    for (uint32_t i = 0; i < 4 * width * height; ++i)
        image.rgba.push_back(static_cast<uint8_t>((17 + step * (i + i / 4)) % 256));
    return image;
}

int32_t AddTexture(scene::SceneData& scene, uint32_t image, WrapMode wrapU, WrapMode wrapV,
                   FilterMode filter) {
    scene.textures.push_back(
        {.name = "texture",
         .image = image,
         .sampler = {.wrapU = wrapU, .wrapV = wrapV, .magFilter = filter, .minFilter = filter},
         .colorSpace = ColorSpace::Srgb});
    return static_cast<int32_t>(scene.textures.size() - 1);
}

std::vector<glm::vec2> Coordinates(const glm::vec2& upperLeft, const glm::vec2& lowerRight) {
    return {{upperLeft.x, lowerRight.y}, lowerRight, {lowerRight.x, upperLeft.y}, upperLeft};
}

// Makes nine tiles, one for each pair of wrap modes: base color by one set of coordinates, emission by the
// other.
void AddWall(scene::SceneData& scene) {
    for (uint32_t tile = 0; tile < 9; ++tile) {
        const WrapMode wrapU = kModes[tile % 3], wrapV = kModes[tile / 3];
        const int32_t set = static_cast<int32_t>(tile % 2);
        scene::Material material = Lambert({0.9f, 0.8f, 0.95f}, {0.3f, 0.2f, 0.4f});
        material.isDoubleSided = false;
        material.baseColorTexture = {.texture = AddTexture(scene, 0, wrapU, wrapV, FilterMode::Linear),
                                     .texCoord = set};
        material.emissiveTexture = {.texture = AddTexture(scene, 1, wrapV, wrapU, FilterMode::Nearest),
                                    .texCoord = 1 - set};
        material.emissiveStrength = 1.5f;
        scene::Mesh mesh = QuadMesh(0.5f, static_cast<uint32_t>(scene.materials.size()));
        const auto forColor = Coordinates({-0.7f, -1.2f}, {1.9f, 1.6f});
        const auto forEmission = Coordinates({1.45f, -0.35f}, {-0.55f, 1.35f});
        mesh.primitives[0].uv0 = set == 0 ? forColor : forEmission;
        mesh.primitives[0].uv1 = set == 1 ? forColor : forEmission;
        scene.instances.push_back(
            {.mesh = static_cast<uint32_t>(scene.meshes.size()),
             .objectToWorld = Translation({float(tile % 3) - 1.0f, 1.0f - float(tile / 3), 0})});
        scene.meshes.push_back(mesh);
        scene.materials.push_back(material);
    }
}

// Makes four strips of one mesh before the wall: two of MASK, one of BLEND, and one whose alpha is ignored.
void AddStrips(scene::SceneData& scene) {
    scene::Mesh mesh;
    for (const AlphaMode mode : {AlphaMode::Mask, AlphaMode::Blend, AlphaMode::Mask, AlphaMode::Opaque}) {
        const uint32_t strip = static_cast<uint32_t>(mesh.primitives.size());
        scene::Material material = Lambert({0.7f, 0.9f, 0.8f});
        material.baseColorFactor.a = 0.8f;
        material.alphaMode = mode;
        material.alphaCutoff = 0.35f;
        material.baseColorTexture = {
            .texture = AddTexture(scene, 2, kModes[strip % 3], kModes[(strip + 1) % 3],
                                  strip == 1 ? FilterMode::Nearest : FilterMode::Linear),
            .texCoord = static_cast<int32_t>(strip % 2)};
        scene::Primitive primitive =
            QuadMesh(0.5f, static_cast<uint32_t>(scene.materials.size())).primitives[0];
        for (glm::vec3& position : primitive.positions)
            position = glm::vec3(0.5f * position.x + 0.75f * float(strip) - 1.1f, 2.2f * position.y, 0.5f);
        primitive.bounds = {};
        for (const glm::vec3& position : primitive.positions) primitive.bounds.Extend(position);
        primitive.uv0 = Coordinates({-0.3f + 0.3f * float(strip), -0.6f}, {0.8f, 2.1f});
        primitive.uv1 = Coordinates({0.9f, 1.7f - 0.3f * float(strip)}, {-0.4f, -0.8f});
        if (mode == AlphaMode::Blend)
            primitive.colors = {{1.0f, 0.5f, 0.5f, 0.9f},
                                {0.5f, 1.0f, 0.5f, 0.5f},
                                glm::vec4(1.0f),
                                {0.2f, 0.4f, 1.0f, 0.7f}};
        mesh.primitives.push_back(primitive);
        scene.materials.push_back(material);
    }
    // Mirrored and rotated a little about +y
    glm::mat4x3 placement(1.0f);
    placement[0] = {-0.98f, 0.0f, 0.2f};
    placement[2] = {0.2f, 0.0f, 0.98f};
    scene.instances.push_back(
        {.mesh = static_cast<uint32_t>(scene.meshes.size()), .objectToWorld = placement});
    scene.meshes.push_back(mesh);
}

scene::SceneData TexturedScene() {
    scene::SceneData scene;
    scene.images = {Texels(4, 3, 83), Texels(3, 5, 131), Texels(5, 4, 59)};
    AddWall(scene);
    AddStrips(scene);
    scene::Light sun;
    sun.type = scene::LightType::Directional;
    sun.color = {1.0f, 0.9f, 0.8f};
    sun.intensity = 3.0f;
    // Light goes along the node's -z
    sun.lightToWorld[2] = glm::normalize(glm::vec3(0.35f, 0.5f, 0.8f));
    sun.lightToWorld[0] = glm::normalize(glm::cross(glm::vec3(0, 1, 0), sun.lightToWorld[2]));
    sun.lightToWorld[1] = glm::cross(sun.lightToWorld[2], sun.lightToWorld[0]);
    scene.lights.push_back(sun);
    return scene;
}

class TexturedReference : public VulkanTest {
  protected:
    TexturedReference() { render.more = {}; }

    SceneRender render{Device()};
};

test::PlaneView Channel(const std::vector<glm::vec4>& values, uint32_t size, int channel) {
    return {size, size, std::span(&values[0].x, 4 * values.size()).subspan(static_cast<size_t>(channel)), 4};
}

// Returns the variance of each pixel's mean. Few samples or none see what lies at the edge of a pixel, so it
// is the largest of the pixel and its neighbors.
std::vector<glm::vec4> VarianceOfMean(const RenderedImage& image) {
    const int width = static_cast<int>(image.mean.extent.width);
    const int height = static_cast<int>(image.mean.extent.height);
    std::vector<glm::vec4> result;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            glm::vec4 largest(0.0f);
            for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v)
                for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u)
                    largest = glm::max(largest,
                                       image.variance.At(static_cast<uint32_t>(u), static_cast<uint32_t>(v)));
            result.push_back(largest / float(image.sampleCount));
        }
    return result;
}

}  // namespace

TEST_F(TexturedReference, Trace_LambertUnderASunIsWhatTheReferenceProgramSays) {
    constexpr uint32_t kSize = 48, kSamples = 64;
    scene::SceneData scene = TexturedScene();
    scene::CameraView camera =
        scene::CameraView::LookAt({0.4f, -0.3f, 4.0f}, {0.05f, 0.02f, 0.0f}, {0, 1, 0});
    camera.yFov = 0.75f;
    const std::vector<glm::dvec4> exact = test::DirectLightReference(scene).Picture(camera, kSize, kSize, 16);
    const std::vector<glm::vec4> reference(exact.begin(), exact.end());

    passes::TraceSettings settings;
    settings.extent = {kSize, kSize};
    settings.camera = ToRecord(camera);
    settings.scattering.brdf = BrdfModel::Lambert;
    settings.biases.maxDepth = 1;  // light that was scattered once
    render.scene.SetScene(std::move(scene));
    const RenderedImage image = render.Render(settings, kSamples);

    const std::vector<glm::vec4> varianceOfMean = VarianceOfMean(image);
    for (int channel = 0; channel < 3; ++channel) {
        const test::PlaneView mean = Channel(image.mean.values, kSize, channel);
        const test::PlaneView expected = Channel(reference, kSize, channel);
        // The device's sRGB curve and weights of filters are good to about 0.5 / 255
        const test::ZTestResult result =
            test::ZTest({mean, Channel(varianceOfMean, kSize, channel)}, {expected, {}},
                        {.relativeFloor = 1e-3, .absoluteFloor = 5e-4});
        EXPECT_FALSE(result.HasFailures())
            << "channel " << channel << ": " << result.failedCount << " pixels, the worst at "
            << result.greatestPixel % kSize << ", " << result.greatestPixel / kSize << ": "
            << mean.At(result.greatestPixel) << " for " << expected.At(result.greatestPixel);
        EXPECT_NEAR(test::Mean(mean), test::Mean(expected), 0.003 * test::Mean(expected));
    }
    // Coverage
    const test::PlaneView alpha = Channel(image.mean.values, kSize, 3),
                          covered = Channel(reference, kSize, 3);
    EXPECT_LT(test::MaxAbsDifference(alpha, covered), 0.25);
    EXPECT_NEAR(test::Mean(alpha), test::Mean(covered), 0.003);
}

}  // namespace raygraph::testing::textured_reference_test
