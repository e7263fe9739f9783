// Media that refract colors differently, on the device.
#include <cmath>

#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::trace_dispersion_test {

using passes::TraceSettings;

namespace {

class TraceDispersion : public VulkanTest {
  protected:
    SceneRender render{Device()};
};

constexpr double kCosine = 0.45, kIor = 1.6, kDispersion = 5.0;

// The index at a wavelength in nm (KHR_materials_dispersion).
double IorAt(double wavelength) {
    return kIor + (kIor - 1.0) * kDispersion / 20.0 * (523655.0 / (wavelength * wavelength) - 1.5168);
}

// A camera looks through the surface of glass at a floor that is lit from x = `edge` on.
scene::SceneData GlassOverAFloor(float dispersion, float edge) {
    scene::Material glass;
    glass.metallicFactor = 0.0f;
    glass.roughnessFactor = 0.0f;
    glass.ior = float(kIor);
    glass.transmissionFactor = 1.0f;
    glass.thicknessFactor = 1.0f;
    glass.dispersion = dispersion;
    const scene::Material lamp = Lambert(glm::vec3(0.0f), glm::vec3(1.0f));
    return SceneOf({QuadMesh(50.0f, 0), QuadMesh(5.0f, 1)}, {glass, lamp},
                   {glm::mat4x3(1.0f), Translation({edge + 5.0f, 0.0f, -1.0f})});
}

// Red is bent less than blue. The edge of the lamp is where light of 540.7 nm goes, the middle of green: half of
// green sees it, red sees it and blue does not.
TEST_F(TraceDispersion, Trace_BluePassesAtAnotherAngleThanRed) {
    const double sine = std::sqrt(1.0 - kCosine * kCosine);
    const double refracted = sine / IorAt(540.7);
    const auto edge = float(refracted / std::sqrt(1.0 - refracted * refracted));
    TraceSettings settings = LookAt(100.0f * glm::vec3(-sine, 0.0f, kCosine), {0, 0, 0}, 1e-5f, 16);
    settings.scattering.brdf = BrdfModel::Gltf;
    const auto passedAt = [&](double wavelength) {
        const double n = IorAt(wavelength);
        const double f0 = std::pow((n - 1.0) / (n + 1.0), 2.0);
        return (1.0 - f0) * (1.0 - std::pow(1.0 - kCosine, 5.0)) / (n * n);
    };
    render.scene.SetScene(GlassOverAFloor(float(kDispersion), edge));
    const RenderedImage seen = render.Render(settings, 64);
    const glm::dvec3 mean = seen.mean.Mean();
    const glm::dvec3 error = seen.StandardErrorOfMean();
    // By the bands' logistic curves: 1 / (1 + exp(-(609.2 - 540.7) / 14.16)) of red is beyond the edge
    EXPECT_NEAR(mean.x, 0.992 * passedAt(609.2), 4.0 * error.x + 0.002);
    EXPECT_NEAR(mean.y, 0.5 * passedAt(560.0), 4.0 * error.y + 0.002);
    EXPECT_NEAR(mean.z, 0.0005 * passedAt(540.7), 4.0 * error.z + 0.001);
    // Without dispersion the d line decides for all colors: it is beyond the edge
    render.scene.SetScene(GlassOverAFloor(0.0f, edge));
    const glm::vec3 gray = render.Render(settings, 64).mean.Mean();
    EXPECT_EQ(gray.x, gray.z);
    EXPECT_NEAR(gray.x, passedAt(587.6), 0.002);
}

}  // namespace
}  // namespace raygraph::testing::trace_dispersion_test
