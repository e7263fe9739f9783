// Media that scatter, on the device.
#include <cmath>

#include "shaders/shared/trace_options.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::trace_scattering_test {

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

constexpr double kOpticalDepth = 0.8, kHeight = 0.5, kSunCosine = 0.6;

// Of index 1, as deep as kOpticalDepth over kHeight; all that it stops is scattered alike in all directions.
scene::Material Fog() {
    scene::Material fog;
    fog.metallicFactor = 0.0f;
    fog.roughnessFactor = 0.0f;
    fog.ior = 1.0f;
    fog.transmissionFactor = 1.0f;
    fog.thicknessFactor = 1.0f;
    fog.attenuationDistance = float(kHeight);
    fog.attenuationColor = glm::vec3(float(std::exp(-kOpticalDepth)));
    fog.multiscatterColorFactor = {1.0f, 1.0f, 1.0f};
    return fog;
}

// Sun of irradiance 3 that comes down at kSunCosine to z.
scene::Light SlantingSun() {
    const float c = float(kSunCosine), s = float(std::sqrt(1.0 - kSunCosine * kSunCosine));
    scene::Light sun;
    sun.type = scene::LightType::Directional;
    sun.intensity = 3.0f;
    sun.lightToWorld = {{c, 0, -s}, {0, 1, 0}, {s, 0, c}, {0, 0, 0}};
    return sun;
}

// A layer of fog under the sun, over a floor. Of light that is scattered once, straight up,
//     E w p (1 - exp(-depth (1 + 1 / mu))) / (1 + 1 / mu),   p = 1 / (4 pi), w = 1
// with E the irradiance across the sun's direction, of cosine mu.
TEST_F(TraceScattering, Trace_SunShinesIntoFogAndThroughIt) {
    const glm::mat4x3 turned({1, 0, 0}, {0, -1, 0}, {0, 0, -1}, {0, 0, -float(kHeight)});
    for (const float albedo : {0.0f, 0.6f}) {
        scene::Material floor = Lambert(glm::vec3(albedo));
        floor.metallicFactor = 0.0f;
        floor.specularFactor = 0.0f;
        scene::SceneData scene =
            SceneOf({QuadMesh(500.0f, 0), QuadMesh(500.0f, 0), QuadMesh(500.0f, 1)}, {Fog(), floor},
                    {glm::mat4x3(1.0f), turned, Translation({0, 0, -0.7f})});
        scene.lights = {SlantingSun()};
        render.scene.SetScene(std::move(scene));
        TraceSettings settings = LookAt({0, 0, 3.0f}, {0, 0, 0}, 1e-4f, 16);
        settings.scattering.brdf = BrdfModel::Gltf;
        settings.biases.maxDepth = 1;
        const RenderedImage seen = render.Render(settings, 64);
        const double path = 1.0 + 1.0 / kSunCosine;
        const double passed = std::exp(-kOpticalDepth * path);
        const double expected =
            3.0 / (4.0 * M_PI) * (1.0 - passed) / path + passed * 3.0 * kSunCosine * double(albedo) / M_PI;
        const glm::dvec3 error = seen.StandardErrorOfMean();
        EXPECT_LT(error.y, 0.01 * expected) << "too noisy to prove anything";
        EXPECT_NEAR(seen.mean.Mean().y, expected, 4.0 * error.y + 1e-3 * expected) << "floor of " << albedo;
    }
}

// Light sampling goes through boundaries only where a scene has such: other glass keeps its pipelines.
TEST_F(TraceScattering, SetScene_OnlyMediaThatLightPassesStraightIntoAreMatched) {
    const auto isMatched = [&](const scene::Material& first, const scene::Material& second) {
        render.scene.SetScene(SceneOf({BoxMesh(1.0f, 0), BoxMesh(0.5f, 1)}, {first, second}));
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        render.renderer.DropFrame();
        return ids.features.Has(kTraceMatchedMedia);
    };
    scene::Material glass = Fog();
    glass.ior = 1.5f;
    glass.multiscatterColorFactor = glm::vec3(0.0f);
    scene::Material milk = Fog();
    milk.ior = 1.5f;
    scene::Material gas = glass;
    gas.ior = 1.0f;
    EXPECT_TRUE(isMatched(Fog(), glass));
    EXPECT_TRUE(isMatched(gas, glass)) << "absorbs alone";
    EXPECT_TRUE(isMatched(glass, milk)) << "of one index";
    EXPECT_FALSE(isMatched(glass, glass));
    EXPECT_FALSE(isMatched(milk, Lambert(glm::vec3(0.5f))));
    milk.ior = 1.4f;
    EXPECT_FALSE(isMatched(glass, milk)) << "refract";
    gas.transmissionFactor = 0.0f;
    EXPECT_FALSE(isMatched(gas, glass)) << "opaque";
}

}  // namespace
}  // namespace raygraph::testing::trace_scattering_test
