// Trace against closed forms, on the device.
#include <cmath>

#include "tests/support/same_image.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::trace_physics_test {

using passes::TraceSettings;

namespace {

constexpr float kHalfPi = 1.57079633f;

class TracePhysics : public VulkanTest {
  protected:
    SceneRender render{Device()};
};

// The mean over the picture is the closed form, within `tolerance` and with noise that could have shown a
// failure.
void ExpectMean(const RenderedImage& image, double expected, double tolerance) {
    const glm::dvec3 mean = image.mean.Mean();
    const glm::dvec3 error = image.StandardErrorOfMean();
    for (int channel = 0; channel < 3; ++channel) {
        EXPECT_NEAR(mean[channel], expected, tolerance * expected) << "channel " << channel;
        EXPECT_LT(3.0 * error[channel], tolerance * expected) << "too noisy to prove anything";
    }
}

}  // namespace

TEST_F(TracePhysics, Trace_ClosedBoxHasRadianceOneOverOneMinusAlbedo) {
    for (const float albedo : {0.5f, 0.8f}) {
        render.scene.SetScene(SceneOf({BoxMesh(1.0f)}, {Lambert(glm::vec3(albedo), glm::vec3(1.0f))}));
        const TraceSettings settings = LookAt({0.2f, 0.1f, 0.3f}, {1.0f, 0.0f, 0.0f}, 1.5f, 128);
        ExpectMean(render.Render(settings, albedo > 0.6f ? 32 : 12), 1.0 / (1.0 - albedo), 0.005);
    }
}

TEST_F(TracePhysics, Trace_PathsEndWithoutRoulette) {
    render.scene.SetScene(SceneOf({BoxMesh(1.0f)}, {Lambert(glm::vec3(0.8f), glm::vec3(1.0f))}));
    TraceSettings settings = LookAt({0, 0, 0}, {0, 0, -1}, 0.8f, 4);
    settings.roulette.kind = Roulette::Off;
    settings.lights.isOn = false;
    EXPECT_NEAR(render.Render(settings, 1).mean.Mean().y, 5.0, 1e-3);
}

TEST_F(TracePhysics, Trace_LambertSphereInUnitEnvironmentShowsItsAlbedo) {
    render.scene.SetScene(SceneOf({SphereMesh(1.0f, 96)}, {Lambert(glm::vec3(0.8f))}));
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    // The middle of the sphere fills the picture
    const TraceSettings settings = LookAt({0, 0, 4}, {0, 0, 0}, 0.25f, 64);
    ExpectMean(render.Render(settings, 64), 0.8, 0.002);
}

TEST_F(TracePhysics, Trace_WhiteSphereVanishesInUnitEnvironment) {
    render.scene.SetScene(SceneOf({SphereMesh(1.0f, 96)}, {Lambert(glm::vec3(1.0f))}));
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    const RenderedImage image = render.Render(LookAt({0, 0, 4}, {0, 0, 0}, 0.7f, 64), 64);
    ExpectMean(image, 1.0, 0.002);
}

TEST_F(TracePhysics, Trace_TwoPlatesExchangeLightAsTheirViewFactorSays) {
    // A small patch faces a large emitting disc stand-in: a square of half side 1 at distance 1. Irradiance
    // at the foot of the axis from a square of half side a at distance h (Howell, configuration factor of a
    // plane element to a parallel rectangle, corner form times four).
    const double x = 1.0, y = 1.0;
    const double cornerFactor = (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
                                 y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y))) /
                                (2.0 * M_PI);
    const double viewFactor = 4.0 * cornerFactor;
    render.scene.SetScene(SceneOf({QuadMesh(0.001f, 0), QuadMesh(1.0f, 1)},
                                  {Lambert(glm::vec3(0.6f)), Lambert(glm::vec3(0.0f), glm::vec3(5.0f))},
                                  {glm::mat4x3(1.0f), Translation({0, 0, 1})}));
    // Look at the patch from the side, at a slant
    const TraceSettings settings = LookAt({0.5f, 0.0f, 0.5f}, {0, 0, 0}, 0.0005f, 64);
    ExpectMean(render.Render(settings, 16), 0.6 * 5.0 * viewFactor, 0.005);
}

TEST_F(TracePhysics, Trace_EnvironmentMapPointsAlongItsAxes) {
    // A map of 64 x 32 texels whose color is the direction itself, and six cameras along the axes
    image::ImageF map{.width = 64, .height = 32, .rgba = {}};
    for (uint32_t row = 0; row < map.height; ++row)
        for (uint32_t column = 0; column < map.width; ++column) {
            const double phi = 2.0 * M_PI * ((column + 0.5) / map.width - 0.5);
            const double theta = M_PI * (row + 0.5) / map.height;
            const glm::dvec3 d(std::sin(theta) * std::cos(phi), std::cos(theta),
                               std::sin(theta) * std::sin(phi));
            for (int channel = 0; channel < 3; ++channel) map.rgba.push_back(float(d[channel] + 1.0));
            map.rgba.push_back(1.0f);
        }
    render.scene.SetEnvironmentMap(map);
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    for (const glm::vec3 axis : {glm::vec3(1, 0, 0), glm::vec3(-1, 0, 0), glm::vec3(0, 1, 0),
                                 glm::vec3(0, -1, 0), glm::vec3(0, 0, 1), glm::vec3(0, 0, -1)}) {
        const FloatImage seen = render.TraceOnce(LookAt({0, 0, 0}, axis, 0.01f, 4));
        const glm::dvec3 color = seen.Mean() - 1.0;
        EXPECT_LT(glm::length(color - glm::dvec3(axis)), 0.06)
            << axis.x << ' ' << axis.y << ' ' << axis.z << " shows " << color.x << ' ' << color.y << ' '
            << color.z;
        EXPECT_EQ(seen.At(0, 0).w, 0.0f) << "the environment has no alpha";
    }
    // A quarter turn about +y carries what was at +x to -z
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f), .rotation = kHalfPi});
    const glm::dvec3 turned = render.TraceOnce(LookAt({0, 0, 0}, {0, 0, -1}, 0.01f, 4)).Mean() - 1.0;
    EXPECT_LT(glm::length(turned - glm::dvec3(1, 0, 0)), 0.06);
}

TEST_F(TracePhysics, Trace_EnvironmentKeepsRadianceAboveTheHalfFloatRange) {
    image::ImageF map{.width = 1, .height = 1, .rgba = {110000.0f, 70000.0f, 1.0f, 1.0f}};
    render.scene.SetEnvironmentMap(map);
    render.scene.SetEnvironment({.radiance = glm::vec3(2.0f)});
    const FloatImage seen = render.TraceOnce(LookAt({0, 0, 0}, {1, 0, 0}, 1.0f, 2));
    EXPECT_EQ(glm::vec3(seen.At(1, 1)), glm::vec3(220000.0f, 140000.0f, 2.0f));
}

TEST_F(TracePhysics, Trace_EmptySceneShowsTheEnvironmentOnly) {
    render.scene.SetEnvironment({.radiance = glm::vec3(0.25f, 0.5f, 1.0f)});
    const FloatImage seen = render.TraceOnce(LookAt({0, 0, 3}, {0, 0, 0}, 1.0f, 8));
    for (const glm::vec4& texel : seen.values) EXPECT_EQ(texel, glm::vec4(0.25f, 0.5f, 1.0f, 0.0f));
}

TEST_F(TracePhysics, Trace_DepthZeroSeesEmissionOnly) {
    render.scene.SetScene(SceneOf({BoxMesh(1.0f)}, {Lambert(glm::vec3(0.8f), glm::vec3(1.0f, 2.0f, 3.0f))}));
    TraceSettings settings = LookAt({0, 0, 0}, {1, 0, 0}, 1.5f, 16);
    settings.biases.maxDepth = 0;
    for (const glm::vec4& texel : render.TraceOnce(settings).values) EXPECT_EQ(texel, glm::vec4(1, 2, 3, 1));
}

// The rest of the samplers and roulettes: tests/long.
TEST_F(TracePhysics, Trace_SamplerAndRouletteLeaveTheImage) {
    render.scene.SetScene(EmissiveRoom());
    TraceSettings settings = ViewOfEmissiveRoom(32);
    settings.roulette.start = 8;
    const RenderedImage reference = render.Render(settings, 48);
    settings.seed = 1;
    for (const uint32_t start : {1u, 30u}) {
        settings.roulette.start = start;
        ExpectSameImage(render.Render(settings, 32), reference, "roulette from " + std::to_string(start));
    }
    settings.sampler = SamplerKind::Pcg;
    settings.roulette = {.kind = Roulette::Constant, .start = 2, .survival = 0.7f};
    ExpectSameImage(render.Render(settings, 64), reference, "pcg, constant roulette");
}

// The random number of this sample's roulette is the smallest of 2^32: it survives 31 bounces, and the room sends
// out as much again at each of them.
TEST_F(TracePhysics, Trace_RouletteHasNoNumberWithoutALogarithm) {
    render.scene.SetScene(SceneOf({BoxMesh(1.0f)}, {Lambert(glm::vec3(0.5f), glm::vec3(1.0f))}));
    TraceSettings settings = LookAt({0, 0, 0}, {1, 0, 0}, 1.5f, 8);
    settings.sampleIndex = 0u - 0x9e3779b9u;
    settings.roulette = {.kind = Roulette::Frame, .start = 1, .survival = 0.5f};
    settings.lights.isOn = false;
    for (const glm::vec4& texel : render.TraceOnce(settings).values) EXPECT_NEAR(texel.x, 33.0f, 1e-2f);
}

TEST_F(TracePhysics, Trace_VertexColorsScaleTheBaseColor) {
    scene::SceneData scene = SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.5f, 1.0f, 1.0f))});
    scene.materials[0].isUnlit = true;
    scene.meshes[0].primitives[0].colors.assign(4, {0.5f, 0.25f, 0.75f, 1.0f});
    render.scene.SetScene(std::move(scene));
    const FloatImage seen = render.TraceOnce(LookAt({0, 0, 2}, {0, 0, 0}, 0.8f, 4));
    for (const glm::vec4& texel : seen.values)
        EXPECT_LT(glm::distance(glm::vec3(texel), glm::vec3(0.25f, 0.25f, 0.75f)), 1e-6f);
}

TEST_F(TracePhysics, Trace_EmissiveTextureShowsThrough) {
    scene::SceneData scene = SceneOf({QuadMesh(1.0f)}, {Lambert(glm::vec3(0.0f), glm::vec3(1.0f))});
    // Upper left texel red, upper right green, lower left blue, lower right white; sRGB 0 and 255 are exact
    scene.images.push_back({.name = "four texels",
                            .width = 2,
                            .height = 2,
                            .rgba = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255}});
    scene.textures.push_back(
        {.name = "four texels",
         .image = 0,
         .sampler = {.magFilter = scene::FilterMode::Nearest, .minFilter = scene::FilterMode::Nearest},
         .colorSpace = scene::ColorSpace::Srgb});
    scene.materials[0].emissiveTexture = {.texture = 0};
    // glTF: (0, 0) is the upper left corner of the image; the quad's corners go -x-y, +x-y, +x+y, -x+y
    scene.meshes[0].primitives[0].uv0 = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    render.scene.SetScene(std::move(scene));
    const FloatImage seen = render.TraceOnce(LookAt({0, 0, 2}, {0, 0, 0}, 0.8f, 4));
    EXPECT_EQ(glm::vec3(seen.At(1, 1)), glm::vec3(1, 0, 0));
    EXPECT_EQ(glm::vec3(seen.At(2, 1)), glm::vec3(0, 1, 0));
    EXPECT_EQ(glm::vec3(seen.At(1, 2)), glm::vec3(0, 0, 1));
    EXPECT_EQ(glm::vec3(seen.At(2, 2)), glm::vec3(1, 1, 1));
}

}  // namespace raygraph::testing::trace_physics_test
