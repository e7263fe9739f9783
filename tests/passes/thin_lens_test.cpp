// The thin lens, by the circle of confusion: a point at distance d along the view, through a lens of radius R
// that is sharp at distance f, is a disc of radius R |1/f - 1/d| on the film at distance 1. Its second moment
// along each axis is a quarter of the squared radius.
#include <cmath>

#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::thin_lens_test {

namespace {

constexpr uint32_t kHeight = 48, kWidth = 2 * kHeight;
constexpr float kHalfFilm = 0.25f;                    // film from the middle to the top, at distance 1
constexpr double kPixel = 2.0 * kHalfFilm / kHeight;  // of film
constexpr float kFocus = 4.0f;

class ThinLens : public VulkanTest {
  protected:
    // The sum of a picture's light, and where it lies, in film from the middle of the picture.
    struct Light {
        double sum = 0.0;
        glm::dvec2 mean{0.0};
        glm::dvec2 variance{0.0};
    };
    // Of a shining square that spans 4 x 4 pixels without a lens, at a place as seen from a camera that looks
    // along -z from the origin.
    Light Seen(const glm::vec3& place, float lensRadius, uint32_t samples = 64) {
        const auto halfSize = static_cast<float>(2.0 * kPixel) * -place.z;
        render.scene.SetScene(
            SceneOf({QuadMesh(halfSize)}, {Lambert({}, glm::vec3(1.0f))}, {Translation(place)}));
        passes::TraceSettings settings = Settings();
        settings.camera.lensRadius = lensRadius;
        return Measure(render.Render(settings, samples).mean);
    }
    static passes::TraceSettings Settings() {
        scene::CameraView view = scene::CameraView::LookAt({0, 0, 0}, {0, 0, -1}, {0, 1, 0});
        view.yFov = 2.0f * std::atan(kHalfFilm);
        view.aspect = 2.0f;
        passes::TraceSettings settings;
        settings.extent = {kWidth, kHeight};
        settings.camera = ToRecord(view);
        settings.camera.focusDistance = kFocus;
        settings.scattering.brdf = BrdfModel::Lambert;
        settings.biases.maxDepth = 0;  // emission alone
        return settings;
    }
    static Light Measure(const FloatImage& image) {
        Light light;
        const auto each = [&](auto&& add) {
            for (uint32_t y = 0; y < kHeight; ++y)
                for (uint32_t x = 0; x < kWidth; ++x)
                    add(glm::dvec2(x + 0.5 - 0.5 * kWidth, 0.5 * kHeight - y - 0.5) * kPixel,
                        double{image.At(x, y).y});
        };
        each([&](const glm::dvec2& place, double value) {
            light.sum += value;
            light.mean += value * place;
        });
        light.mean /= light.sum;
        each([&](const glm::dvec2& place, double value) {
            light.variance += value * (place - light.mean) * (place - light.mean) / light.sum;
        });
        return light;
    }

    SceneRender render{Device()};
};

}  // namespace

TEST_F(ThinLens, Trace_BlursPointsBeforeAndBehindTheFocusByTheCircleOfConfusion) {
    const float kRadius = 0.5f;
    // Some 1000 samples meet the square: each of these numbers is good to about 3 %
    for (const float distance : {2.5f, 8.0f}) {
        const glm::vec3 place(0.05f * distance, 0.02f * distance, -distance);
        const Light sharp = Seen(place, 0.0f, 16), blurred = Seen(place, kRadius);
        const double radius = kRadius * std::abs(1.0 / kFocus - 1.0 / distance);
        for (int axis = 0; axis < 2; ++axis) {
            EXPECT_NEAR(blurred.variance[axis] - sharp.variance[axis], 0.25 * radius * radius,
                        0.1 * 0.25 * radius * radius)
                << "axis " << axis << " at " << distance;
            EXPECT_NEAR(blurred.mean[axis], sharp.mean[axis], 0.1 * radius);
        }
        EXPECT_NEAR(blurred.sum, sharp.sum, 0.1 * sharp.sum) << "a lens loses no light";
    }
}

TEST_F(ThinLens, Trace_IsSharpOnAPlaneAcrossTheView) {
    for (const glm::vec2 off : {glm::vec2(0.0f), glm::vec2(0.4f, 0.0f), glm::vec2(-0.35f, 0.15f)}) {
        const glm::vec3 place(kFocus * off, -kFocus);
        const Light sharp = Seen(place, 0.0f, 16), seen = Seen(place, 0.5f, 16);
        for (int axis = 0; axis < 2; ++axis) {
            EXPECT_NEAR(seen.mean[axis], off[axis], 0.1 * kPixel);
            EXPECT_NEAR(seen.variance[axis], sharp.variance[axis], 0.1 * kPixel * kPixel);
        }
    }
}

TEST_F(ThinLens, Trace_OrthographicCamerasHaveNoLens) {
    scene::CameraView view = scene::CameraView::LookAt({0, 0, 3}, {0, 0, 0}, {0, 1, 0});
    view.projection = scene::Projection::Orthographic;
    passes::TraceSettings settings = Settings();
    settings.camera = ToRecord(view);
    render.scene.SetScene(SceneOf({QuadMesh(0.4f)}, {Lambert({}, glm::vec3(1.0f))}));
    const FloatImage without = render.TraceOnce(settings);
    settings.camera.lensRadius = 0.5f;
    EXPECT_EQ(render.TraceOnce(settings).values, without.values);
}

}  // namespace raygraph::testing::thin_lens_test
