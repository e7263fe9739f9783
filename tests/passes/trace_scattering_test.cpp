// Media that scatter, on the device.
#include <cmath>

#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing {

using passes::TraceSettings;

namespace {

class TraceScattering : public VulkanTest {
  protected:
    SceneRender render{Device()};
};

// Below a surface that neither reflects nor refracts, a medium without an end. Of light from all sides a medium
// that scatters alike in all directions with an albedo of 0.9 returns 1 - H(1) sqrt(0.1) straight up, with
// H(1) = 1.8501 of Chandrasekhar's function (tests/shading/scattering_test.cpp computes it).
TEST_F(TraceScattering, Trace_MediumReturnsLightByItsAlbedo) {
    scene::Material fog;
    fog.metallicFactor = 0.0f;
    fog.roughnessFactor = 0.0f;
    fog.ior = 1.0f;
    fog.transmissionFactor = 1.0f;
    fog.thicknessFactor = 1.0f;
    fog.attenuationDistance = 0.01f;
    fog.attenuationColor = {0.5f, 0.1f, 0.5f};
    // The color whose single-scattering albedo is 0.9 where light goes on in all directions alike; none of blue
    fog.multiscatterColorFactor = {0.47717f, 0.47717f, 0.0f};
    TraceSettings settings = LookAt({0, 0, 100.0f}, {0, 0, 0}, 1e-5f, 16);
    settings.scattering.brdf = BrdfModel::Gltf;
    render.scene.SetScene(SceneOf({QuadMesh(500.0f, 0)}, {fog}));
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    const RenderedImage seen = render.Render(settings, 64);
    const glm::dvec3 error = seen.StandardErrorOfMean();
    const double expected = 1.0 - 1.8501 * std::sqrt(0.1);
    EXPECT_LT(error.x, 0.005);
    EXPECT_NEAR(seen.mean.Mean().x, expected, 4.0 * error.x + 0.003);
    EXPECT_NEAR(seen.mean.Mean().y, expected, 4.0 * error.y + 0.003) << "the denser color";
    EXPECT_EQ(seen.mean.Mean().z, 0.0f);
}

}  // namespace
}  // namespace raygraph::testing
