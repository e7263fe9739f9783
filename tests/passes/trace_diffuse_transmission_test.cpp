// Diffuse transmission on the device: light from behind a sheet, and through bodies that it bounds.
#include <cmath>

#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::trace_diffuse_transmission_test {

using passes::TraceSettings;

namespace {

class TraceDiffuseTransmission : public VulkanTest {
  protected:
    static TraceSettings Gltf(const glm::vec3& eye, const glm::vec3& target, float yFov, uint32_t size) {
        TraceSettings settings = LookAt(eye, target, yFov, size);
        settings.scattering.brdf = BrdfModel::Gltf;
        return settings;
    }

    SceneRender render{Device()};
};

// Without a layer, so that both of its sides are Lambert's. Single-sided.
scene::Material Paper(float transmission) {
    scene::Material paper;
    paper.baseColorFactor = {0.9f, 0.6f, 0.3f, 1.0f};
    paper.metallicFactor = 0.0f;
    paper.specularFactor = 0.0f;
    paper.diffuseTransmissionFactor = transmission;
    paper.diffuseTransmissionColorFactor = {0.2f, 0.5f, 0.8f};
    return paper;
}

scene::Light PointLight(const glm::vec3& position, float intensity) {
    scene::Light light;
    light.intensity = intensity;
    light.lightToWorld = Translation(position);
    return light;
}

}  // namespace

// A lamp behind the sheet: t c I / (pi d^2), on either side of the sheet, whose back is not culled. One before
// it: (1 - t) of what it had.
TEST_F(TraceDiffuseTransmission, Trace_LampBehindASheetLightsItsFront) {
    for (const float transmission : {0.0f, 0.4f, 1.0f})
        for (const bool isFromFront : {true, false}) {
            if (transmission == 0.0f && !isFromFront) continue;  // culled
            const scene::Material paper = Paper(transmission);
            const glm::vec3 eye(0.3f, 0.0f, isFromFront ? 4.0f : -4.0f);
            TraceSettings settings = Gltf(eye, {0, 0, 0}, 1e-4f, 2);
            settings.biases.maxDepth = 1;
            for (const bool isBehind : {true, false}) {
                scene::SceneData scene = SceneOf({QuadMesh(1.0f)}, {paper});
                scene.lights = {PointLight({0, 0, isBehind == isFromFront ? -2.0f : 2.0f}, 12.0f)};
                render.scene.SetScene(std::move(scene));
                const glm::vec3 color = isBehind ? transmission * paper.diffuseTransmissionColorFactor
                                                 : (1.0f - transmission) * glm::vec3(paper.baseColorFactor);
                const glm::dvec3 expected = glm::dvec3(color) * (12.0 / (M_PI * 4.0));
                const glm::dvec3 seen = render.TraceOnce(settings).Mean();
                EXPECT_LT(glm::distance(seen, expected), 1e-3 * glm::length(expected) + 1e-6)
                    << transmission << (isFromFront ? ", from the front" : ", from the back")
                    << (isBehind ? ", light behind: " : ", light before: ") << seen.y << " for "
                    << expected.y;
            }
        }
}

// Sampling the lamp behind the sheet and finding it agree, under the layer too.
TEST_F(TraceDiffuseTransmission, Trace_LampBehindASheetIsFoundAsItIsSampled) {
    scene::Material leaf = Paper(0.6f);
    leaf.specularFactor = 1.0f;
    leaf.roughnessFactor = 0.6f;
    render.scene.SetScene(SceneOf({QuadMesh(1.0f, 0), QuadMesh(0.7f, 1)},
                                  {leaf, Lambert(glm::vec3(0.0f), glm::vec3(5.0f))},
                                  {glm::mat4x3(1.0f), Translation({0.2f, 0.0f, -0.8f})}));
    render.scene.SetEnvironment({.radiance = glm::vec3(0.1f)});
    TraceSettings settings = Gltf({1.0f, 0.5f, 3.0f}, {0, 0, 0}, 0.2f, 16);
    settings.biases.maxDepth = 1;
    const RenderedImage sampled = render.Render(settings, 128);
    settings.lights.isOn = false;
    const RenderedImage found = render.Render(settings, 512);
    for (int channel = 0; channel < 3; ++channel) {
        const double error =
            std::hypot(sampled.StandardErrorOfMean()[channel], found.StandardErrorOfMean()[channel]);
        EXPECT_NEAR(sampled.mean.Mean()[channel], found.mean.Mean()[channel], 4.0 * error);
        EXPECT_LT(error, 0.01 * found.mean.Mean()[channel]) << "too noisy to prove anything";
    }
    EXPECT_GT(found.mean.Mean().z, 0.3) << "what the lamp adds";
}

// A closed body whose boundary passes light diffusely into its medium and out of it: white and clear, it is not
// seen; the medium dims what has passed it.
TEST_F(TraceDiffuseTransmission, Trace_WhiteBodyVanishesInUnitEnvironment) {
    scene::Material wax;
    wax.metallicFactor = 0.0f;
    wax.roughnessFactor = 0.5f;
    wax.diffuseTransmissionFactor = 0.7f;
    wax.thicknessFactor = 1.0f;
    ASSERT_TRUE(wax.BoundsMedium());
    const TraceSettings settings = Gltf({0, 0, 6}, {0, 0, 0}, 0.1f, 16);
    const auto seen = [&] {
        render.scene.SetScene(SceneOf({BoxMesh(1.0f)}, {wax}));
        render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
        const RenderedImage image = render.Render(settings, 128);
        EXPECT_LT(4.0 * image.StandardErrorOfMean().y, 0.02) << "too noisy to prove anything";
        return image.mean.Mean();
    };
    EXPECT_NEAR(seen().y, 1.0, 0.015);
    wax.attenuationColor = {1.0f, 0.5f, 1e-6f};
    wax.attenuationDistance = 1.0f;
    const glm::dvec3 tinted = seen();
    EXPECT_NEAR(tinted.x, 1.0, 0.015);
    EXPECT_LT(tinted.y, 0.8);
    // Only what the layer and the base return: nothing comes through the body
    wax.diffuseTransmissionColorFactor = glm::vec3(0.0f);
    EXPECT_NEAR(seen().z, tinted.z, 0.02);
    EXPECT_LT(tinted.z, 0.5);
}

}  // namespace raygraph::testing::trace_diffuse_transmission_test
