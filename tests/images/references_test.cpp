// Compares with pictures of renderers whose models differ a little from ours, by the tolerances in their
// descriptions.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "renderer/scene/gltf/load_gltf.h"
#include "tests/images/reference_image.h"
#include "tests/support/reference_assets.h"

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
