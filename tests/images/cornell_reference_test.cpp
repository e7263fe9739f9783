// Compares the Cornell box with independent renderers. It is skipped if RAYGRAPH_ASSETS is unset.
#include <algorithm>
#include <cmath>

#include "renderer/scene/gltf/load_gltf.h"
#include "tests/images/reference_image.h"

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
