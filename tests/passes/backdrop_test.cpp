// Tests the backdrop of a picture: the blur of its map, where it is seen, and how Tonemap mixes it.
#include "passes/backdrop.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "passes/tonemap.h"
#include "renderer/gpu_scene/camera_record.h"
#include "renderer/graph/pass_harness.h"
#include "renderer/scene/model/camera_view.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::backdrop_test {

namespace {

using passes::Backdrop;
using std::numbers::pi;

// Returns the direction of a texel's center.
glm::dvec3 DirectionOf(uint32_t x, uint32_t y, Extent2D extent) {
    const double azimuth = 2.0 * pi * ((x + 0.5) / extent.width - 0.5),
                 polar = pi * (y + 0.5) / extent.height;
    return {std::sin(polar) * std::cos(azimuth), std::cos(polar), std::sin(polar) * std::sin(azimuth)};
}

class BackdropTest : public VulkanTest {
  protected:
    // Returns a scene that has only an environment, of radiance 2 + direction.
    static SceneIds SkyOf(PassHarness& h, uint32_t width) {
        const Extent2D extent{width, width / 2};
        std::vector<float> values;
        for (uint32_t y = 0; y < extent.height; ++y)
            for (uint32_t x = 0; x < extent.width; ++x) {
                const glm::dvec3 radiance = 2.0 + DirectionOf(x, y, extent);
                for (int c = 0; c < 3; ++c) values.push_back(static_cast<float>(radiance[c]));
                values.push_back(1.0f);
            }
        SceneIds scene;
        scene.environmentMap = h.Texture("sky", extent, Format::Rgba32Float, values);
        scene.environment = {.radiance = glm::vec3(1.0f), .rotation = 0.0f, .hasMap = 1};
        scene.environmentVersion = 1;
        return scene;
    }
    // Returns the linear radiance that is seen there without a scene before it.
    glm::vec3 Seen(const glm::dvec3& direction, float rotation = 0.0f, float factor = 1.0f) {
        const Texels shown = harness.Run([&](PassHarness& h) {
            SceneIds scene = SkyOf(h, 64);
            scene.environment.rotation = rotation;
            scene.environment.radiance = glm::vec3(factor);
            const Backdrop backdrop = passes::DeclareBackdrop(
                h.Graph(), scene, {}, blurred, ToRecord(scene::CameraView::LookAt({}, direction, {0, 1, 0})),
                {1, 1}, {0, 0, 1, 1});
            const TextureId nothing = h.Texture("nothing", {1, 1}, Format::Rgba32Float, {0, 0, 0, 0});
            return passes::Tonemap(h.Graph(), nothing,
                                   {.exposureEv = -2.0f, .tonemapOperator = TonemapOperator::Linear},
                                   backdrop);
        });
        EXPECT_EQ(shown.At(0, 0)[3], 1.0f);
        return 4.0f * glm::vec3(shown.At(0, 0)[0], shown.At(0, 0)[1], shown.At(0, 0)[2]);
    }
    // Shows a picture over a backdrop of one color.
    Texels Over(const std::vector<float>& radiance, const glm::vec3& color) {
        return harness.Run([&](PassHarness& h) {
            const Extent2D extent{static_cast<uint32_t>(radiance.size() / 4), 1};
            const Backdrop backdrop = passes::DeclareBackdrop(h.Graph(), SkyOf(h, 16), {.color = color},
                                                              blurred, {}, extent, passes::WholeOf(extent));
            return passes::Tonemap(h.Graph(), h.Texture("radiance", extent, Format::Rgba32Float, radiance),
                                   {.exposureEv = 1.0f, .tonemapOperator = TonemapOperator::Srgb}, backdrop);
        });
    }

    PassHarness harness{Device()};
    passes::BlurredEnvironment blurred{"blurred"};
};

}  // namespace

TEST_F(BackdropTest, BlurOfAMapIsTheSameInAllDirections) {
    for (const float degrees : {4.0f, 15.0f, 60.0f}) {
        const Texels map =
            harness.Run([&](PassHarness& h) { return blurred.Declare(h.Graph(), SkyOf(h, 128), degrees); });
        // A map that is linear in the direction gets a slope of one factor, whatever the direction
        const double s = glm::radians(double{degrees});
        double sum = 0.0, weights = 0.0;
        for (double a = 0.0005; a < std::min(3.0 * s, pi); a += 0.001) {
            const double weight = std::sin(a) * std::exp(-0.5 * a * a / (s * s));
            weights += weight;
            sum += weight * std::cos(a);
        }
        for (uint32_t y = 0; y < map.extent.height; ++y)
            for (uint32_t x = 0; x < map.extent.width; ++x) {
                const glm::dvec3 expected = 2.0 + sum / weights * DirectionOf(x, y, map.extent);
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(map.At(x, y)[static_cast<size_t>(c)], expected[c], 0.03)
                        << degrees << " degrees, texel " << x << ", " << y;
            }
    }
}

TEST_F(BackdropTest, MapIsSeenWhereTheEnvironmentIs) {
    for (const glm::dvec3& d : {glm::dvec3(1, 0, 0), glm::dvec3(0, 0, 1), glm::dvec3(-1, 0.2, -0.3)})
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(Seen(d)[c], 2.0 + glm::normalize(d)[c], 0.03);
    // A quarter turn moves what was at +x to -z
    EXPECT_NEAR(Seen({0, 0, -1}, static_cast<float>(pi / 2)).x, 3.0, 0.03);
    EXPECT_NEAR(Seen({1, 0, 0}, 0.0f, 0.5f).x, 1.5, 0.03);
}

TEST_F(BackdropTest, PartOfAPictureHasItsPartOfTheBackdrop) {
    const auto seen = [&](const passes::Region& part) {
        return harness.Run([&](PassHarness& h) {
            const Backdrop backdrop = passes::DeclareBackdrop(h.Graph(), SkyOf(h, 64), {}, blurred,
                                                              ToRecord(scene::CameraView{}), {8, 4}, part);
            const TextureId nothing = h.Texture("nothing", part.Extent(), Format::Rgba32Float,
                                                std::vector<float>(4 * part.PixelCount(), 0.0f));
            return passes::Tonemap(h.Graph(), nothing, {.exposureEv = -2.0f}, backdrop);
        });
    };
    const Texels whole = seen({0, 0, 8, 4}), part = seen({5, 1, 3, 2});
    EXPECT_FALSE(std::ranges::equal(whole.At(0, 0), whole.At(7, 3)));
    for (uint32_t y = 0; y < 2; ++y)
        for (uint32_t x = 0; x < 3; ++x)
            EXPECT_TRUE(std::ranges::equal(part.At(x, y), whole.At(x + 5, y + 1))) << x << y;
}

TEST_F(BackdropTest, IsMixedInLinearLightAfterExposureAndCurve) {
    // Black with alpha 0, half of white, and white; exposed by one stop
    const Texels over = Over({0, 0, 0, 0, 0.25f, 0.25f, 0.25f, 0.5f, 0.5f, 0.5f, 0.5f, 1}, {0, 1, 0.21586f});
    const auto code = [&](uint32_t x, size_t c) { return std::lround(255.0f * over.At(x, 0)[c]); };
    EXPECT_EQ(code(0, 0), 0);
    EXPECT_EQ(code(0, 1), 255);
    EXPECT_EQ(code(0, 2), 128);
    EXPECT_EQ(code(1, 0), 188) << "half the light of white";
    EXPECT_EQ(code(1, 1), 255);
    EXPECT_EQ(code(2, 0), 255);
    for (uint32_t x = 0; x < 3; ++x) EXPECT_EQ(code(x, 3), 255);
}

}  // namespace raygraph::testing::backdrop_test
