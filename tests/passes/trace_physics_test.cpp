#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/error.h"
#include "passes/limit.h"
#include "renderer/scene/model/ground.h"
#include "tests/support/same_image.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

// Trace against closed forms, on the device.
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
        const TraceSettings settings = LookAt({0.2f, 0.1f, 0.3f}, {1.0f, 0.0f, 0.0f}, 1.5f, 64);
        ExpectMean(render.Render(settings, albedo > 0.6f ? 32 : 12), 1.0 / (1.0 - albedo), 0.01);
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

// --- The shadow catcher: alpha is the share of the light that other surfaces take away ---

namespace {

constexpr float Square(float x) {
    return x * x;
}

constexpr float kBallRadius = 1.0f;

// A black ball on the ground, seen from above along (0, -1, -1) in a picture of 2 * kHalf meters.
constexpr float kHalf = 4.0f;
constexpr uint32_t kPixels = 16;
TraceSettings ViewOfGround() {
    const glm::vec3 eye(0.0f, 10.0f, 10.0f);
    TraceSettings settings = LookAt(eye, {0.0f, 0.0f, 0.0f}, 0.5f, kPixels);
    settings.isEnvironmentHidden = true;
    const glm::vec3 forward = glm::normalize(-eye), right(1.0f, 0.0f, 0.0f);
    settings.camera.orthographic = 1;
    settings.camera.forward = forward;
    settings.camera.right = kHalf * right;
    settings.camera.up = kHalf * glm::cross(right, forward);
    return settings;
}

// Calls visit(alpha, place) for each pixel that shows the ground alone, `place` on the ground below its center.
template <typename Visit>
uint32_t ForEachGroundPixel(const FloatImage& picture, const TraceSettings& settings, Visit&& visit) {
    uint32_t count = 0;
    const glm::vec3 ball(0.0f, kBallRadius, 0.0f), forward = settings.camera.forward;
    for (uint32_t y = 0; y < kPixels; ++y)
        for (uint32_t x = 0; x < kPixels; ++x) {
            const float filmX = 2.0f * (float(x) + 0.5f) / kPixels - 1.0f,
                        filmY = 1.0f - 2.0f * (float(y) + 0.5f) / kPixels;
            const glm::vec3 from =
                settings.camera.origin + filmX * settings.camera.right + filmY * settings.camera.up;
            const float halfPixel = std::sqrt(2.0f) * kHalf / kPixels;
            if (glm::length(glm::cross(ball - from, forward)) < kBallRadius + halfPixel) continue;
            const glm::vec4& seen = picture.At(x, y);
            EXPECT_EQ(glm::vec3(seen), glm::vec3(0.0f)) << x << ", " << y;
            visit(seen.w, from - from.y / forward.y * forward);
            ++count;
        }
    return count;
}

class ShadowCatcher : public TracePhysics {
  protected:
    ShadowCatcher() {
        render.scene.SetScene(SceneOf({SphereMesh(kBallRadius, 96)}, {Lambert(glm::vec3(0.0f))},
                                      {Translation({0.0f, kBallRadius, 0.0f})}));
        const scene::Bounds ball{.min = glm::vec3(-1.0f, 0.0f, -1.0f), .max = glm::vec3(1.0f, 2.0f, 1.0f)};
        render.scene.Add(scene::GroundUnder(ball));
    }
};

}  // namespace

// A sphere of radius r, whose center is at height h and at distance d, takes (r / d)^2 h / d of the light of an
// even sky away (J. R. Howell, "A Catalog of Radiation Heat Transfer Configuration Factors", B-39).
TEST_F(ShadowCatcher, BallUnderAnEvenSky) {
    render.scene.SetEnvironment({.radiance = glm::vec3(0.5f, 3.0f, 1.0f)});
    TraceSettings settings = ViewOfGround();
    struct Case {
        passes::IntegratorForm form = passes::IntegratorForm::Loop;
        bool samplesLights = true;
        // Without light sampling, alpha is 0 or 1 in each of the 60,000 samples, of which 7 * 256 are 1: three
        // standard deviations are 7 %.
        double tolerance = 0.015;
    };
    const Case cases[] = {
        {}, {.form = passes::IntegratorForm::Wavefront}, {.samplesLights = false, .tolerance = 0.07}};
    for (const Case& sampled : cases) {
        SCOPED_TRACE(&sampled - cases);
        settings.form = sampled.form;
        settings.lights.isOn = sampled.samplesLights;
        const FloatImage picture = render.Render(settings, 256).mean;
        double sum = 0.0, expected = 0.0;
        const uint32_t count =
            ForEachGroundPixel(picture, settings, [&](float alpha, const glm::vec3& place) {
                const float distance = glm::length(place - glm::vec3(0.0f, kBallRadius, 0.0f));
                const float share = Square(kBallRadius / distance) * kBallRadius / distance;
                EXPECT_NEAR(alpha, share, 0.1f) << place.x << ", " << place.z;
                sum += alpha;
                expected += share;
            });
        EXPECT_GT(count, 200u);
        EXPECT_NEAR(sum, expected, sampled.tolerance * expected);
    }
}

// A point light has a hard shadow: all of it, or nothing, without noise.
TEST_F(ShadowCatcher, BallUnderAPointLight) {
    const glm::vec3 lamp(-5.0f, 3.0f, 3.0f), ball(0.0f, kBallRadius, 0.0f);
    render.scene.SetEnvironment({});
    render.scene.AddLight({.type = scene::LightType::Point,
                           .color = glm::vec3(1.0f, 0.5f, 0.0f),
                           .intensity = 1e4f,
                           .lightToWorld = Translation(lamp)});
    const TraceSettings settings = ViewOfGround();
    uint32_t dark = 0, lit = 0;
    ForEachGroundPixel(render.TraceOnce(settings), settings, [&](float alpha, const glm::vec3& place) {
        const glm::vec3 toLamp = glm::normalize(lamp - place);
        const float fromEdge = glm::length(glm::cross(ball - place, toLamp)) - kBallRadius;
        if (std::abs(fromEdge) < 2.0f * kHalf / kPixels) return;
        EXPECT_NEAR(alpha, fromEdge < 0.0f ? 1.0f : 0.0f, 1e-5f) << place.x << ", " << place.z;
        ++(fromEdge < 0.0f ? dark : lit);
    });
    EXPECT_GT(dark, 5u);
    EXPECT_GT(lit, 100u);
}

// Samples of the light and those of the surface cancel, wherever a map is bright.
TEST_F(ShadowCatcher, NothingIsTakenFromAMapWithoutSurfaces) {
    render.scene.SetScene({});
    render.scene.Add(scene::GroundUnder({.min = glm::vec3(-1.0f, 0.0f, -1.0f), .max = glm::vec3(1.0f)}));
    image::ImageF map{.width = 32, .height = 15, .rgba = std::vector<float>(size_t{4} * 32 * 15, 0.25f)};
    for (const size_t row : {3, 9}) map.rgba[4 * (32 * row + 5) + 1] = 700.0f;
    render.scene.SetEnvironmentMap(map);
    render.scene.SetEnvironment({.radiance = glm::vec3(2.0f), .rotation = 0.7f});
    const TraceSettings settings = ViewOfGround();
    for (const glm::vec4& texel : render.TraceOnce(settings).values) {
        EXPECT_EQ(glm::vec3(texel), glm::vec3(0.0f));
        EXPECT_NEAR(texel.w, 0.0f, 1e-4f);
    }
}

}  // namespace raygraph::testing::trace_physics_test

// Every kind of light against its closed form, on the device, by light sampling.
namespace raygraph::testing::trace_lights_test {

using passes::TraceSettings;

namespace {

constexpr double kTolerance = 0.005;
constexpr float kWhite = 0.8f;  // albedo of what is lit

// A Lambert wall in the plane z = 0, so small that all of it is lit as its middle is, seen from the side.
class TraceLights : public VulkanTest {
  protected:
    void SetWallAnd(std::vector<scene::Mesh> meshes, std::vector<scene::Light> lights,
                    const glm::vec3& emission = glm::vec3(0.0f),
                    const glm::mat4x3& placed = glm::mat4x3(1.0f)) {
        meshes.insert(meshes.begin(), QuadMesh(0.001f, 0));
        std::vector<glm::mat4x3> transforms(meshes.size(), placed);
        transforms[0] = glm::mat4x3(1.0f);
        scene::SceneData scene = SceneOf(
            std::move(meshes), {Lambert(glm::vec3(kWhite)), Lambert(glm::vec3(0.0f), emission)}, transforms);
        scene.lights = std::move(lights);
        render.scene.SetScene(std::move(scene));
    }
    TraceSettings Settings() const {
        TraceSettings settings = LookAt({0.5f, 0.0f, 0.5f}, {0, 0, 0}, 0.0005f, 64);
        settings.biases.maxDepth = 1;  // direct light: what the forms are of
        return settings;
    }
    // The wall's irradiance is `expected`.
    void ExpectIrradiance(double expected, uint32_t samples = 64) {
        const RenderedImage image = render.Render(Settings(), samples);
        const double radiance = expected * kWhite / M_PI;
        EXPECT_NEAR(image.mean.Mean().y, radiance, kTolerance * radiance);
        EXPECT_LT(3.0 * image.StandardErrorOfMean().y, kTolerance * radiance)
            << "too noisy to prove anything";
    }

    SceneRender render{Device()};
};

// Shines along -z, from `position`.
scene::Light Punctual(scene::LightType type, float intensity, const glm::vec3& position) {
    scene::Light light;
    light.type = type;
    light.intensity = intensity;
    light.lightToWorld = Translation(position);
    return light;
}

}  // namespace

TEST_F(TraceLights, Trace_PointLightGivesIntensityOverSquaredDistance) {
    SetWallAnd({}, {Punctual(scene::LightType::Point, 7.0f, {0, 0, 2})});
    ExpectIrradiance(7.0 / 4.0, 1);
    // At a slant: I cos / d^2
    SetWallAnd({}, {Punctual(scene::LightType::Point, 7.0f, {0, 3, 4})});
    ExpectIrradiance(7.0 * 0.8 / 25.0, 1);
}

TEST_F(TraceLights, Trace_DirectionalLightGivesItsIlluminance) {
    SetWallAnd({}, {Punctual(scene::LightType::Directional, 3.0f, {0, 0, 2})});
    ExpectIrradiance(3.0, 1);
}

TEST_F(TraceLights, Trace_SpotLightFallsOffAsTheExtensionSays) {
    scene::Light spot = Punctual(scene::LightType::Spot, 5.0f, {0, 0, 2});
    spot.innerConeAngle = 0.2f;
    spot.outerConeAngle = 0.6f;
    SetWallAnd({}, {spot});
    ExpectIrradiance(5.0 / 4.0, 1);
    // Turned by 0.4 about x: between the cones
    const float angle = 0.4f;
    spot.lightToWorld[1] = {0, std::cos(angle), std::sin(angle)};
    spot.lightToWorld[2] = {0, -std::sin(angle), std::cos(angle)};
    SetWallAnd({}, {spot});
    const double t = (std::cos(0.4) - std::cos(0.6)) / (std::cos(0.2) - std::cos(0.6));
    ExpectIrradiance(5.0 / 4.0 * t * t, 1);
}

TEST_F(TraceLights, Trace_QuadLightGivesItsFormFactor) {
    // Howell, plane element to a parallel rectangle, the corner form times four: half side 0.5 at distance 1
    const double x = 0.5, y = 0.5;
    const double corner = (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
                           y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y))) /
                          (2.0 * M_PI);
    SetWallAnd({QuadMesh(0.5f, 1)}, {}, glm::vec3(2.0f), Translation({0, 0, 1}));
    ExpectIrradiance(2.0 * M_PI * 4.0 * corner);
}

// Lit by a lamp whose texture is red: by light sampling alone, as by what paths find.
TEST_F(TraceLights, Trace_TexturedLampLightsInTheColorOfItsTexels) {
    scene::Mesh lamp = QuadMesh(0.5f, 1);
    lamp.primitives[0].uv0 = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    scene::SceneData scene = SceneOf({QuadMesh(0.001f, 0), std::move(lamp)},
                                     {Lambert(glm::vec3(kWhite)), Lambert(glm::vec3(0.0f), glm::vec3(2.0f))},
                                     {glm::mat4x3(1.0f), Translation({0, 0, 1})});
    scene.images.push_back({.name = "red", .width = 1, .height = 1, .rgba = {255, 0, 0, 255}});
    scene.textures.push_back({.name = "red", .image = 0, .colorSpace = scene::ColorSpace::Srgb});
    scene.materials[1].emissiveTexture = {.texture = 0};
    render.scene.SetScene(std::move(scene));
    TraceSettings settings = Settings();
    for (const bool isSampled : {true, false}) {
        settings.lights.isOn = isSampled;
        settings.lights.mis = isSampled ? MisHeuristic::Off : MisHeuristic::Power;
        const glm::dvec3 seen = render.Render(settings, 64).mean.Mean();
        // Radiance 2 times the form factor of Trace_QuadLightGivesItsFormFactor
        EXPECT_NEAR(seen.x, 2.0 * 0.239456 * kWhite, isSampled ? 0.002 : 0.02) << isSampled;
        EXPECT_EQ(seen.y, 0.0) << isSampled;
        EXPECT_EQ(seen.z, 0.0) << isSampled;
    }
}

TEST_F(TraceLights, Trace_LightNearWhatItLightsDoesNotShadowItself) {
    // It is the same near the world's origin and 100 m off, where float steps are 1000 times as large
    const float halfSide = 0.05f, height = 0.1f;
    const double a = double{halfSide} / height, b = std::sqrt(1.0 + a * a);
    const double irradiance = 2.0 * M_PI * 4.0 * (2.0 * a / b * std::atan(a / b)) / (2.0 * M_PI);
    for (const glm::vec3& origin : {glm::vec3(0.0f), glm::vec3(100.0f, -120.0f, 100.0f)}) {
        render.scene.SetScene(
            SceneOf({QuadMesh(0.01f, 0), QuadMesh(halfSide, 1)},
                    {Lambert(glm::vec3(kWhite)), Lambert(glm::vec3(0.0f), glm::vec3(2.0f))},
                    {Translation(origin), Translation(origin + glm::vec3(0.0f, 0.0f, height))}));
        TraceSettings settings = LookAt(origin + glm::vec3(0.5f, 0.0f, 0.4f), origin, 0.002f, 64);
        settings.biases.maxDepth = 1;
        settings.lights.mis = MisHeuristic::Off;  // or chance makes up for a part
        const double radiance = irradiance * kWhite / M_PI;
        EXPECT_NEAR(render.Render(settings, 64).mean.Mean().y, radiance, kTolerance * radiance) << origin.x;
    }
}

TEST_F(TraceLights, Trace_SphereLightGivesItsSolidAngle) {
    // E = pi L (R / d)^2 for a sphere that is all above the wall, seen face on
    SetWallAnd({SphereMesh(0.5f, 64, 1)}, {}, glm::vec3(3.0f), Translation({0, 0, 2}));
    ExpectIrradiance(M_PI * 3.0 / 16.0, 256);
}

TEST_F(TraceLights, Trace_SunDiscInTheEnvironmentGivesItsSolidAngle) {
    // A row of the map holds one bright texel near the direction (0, 0, 1), u = 0.75, v = 0.5. Looked up
    // between texels, its radiance spreads as a tent, which keeps its integral but for the curve of sin theta
    const uint32_t width = 512, height = 256;
    image::ImageF map{.width = width, .height = height, .rgba = {}};
    map.rgba.assign(size_t{4} * width * height, 0.0f);
    const uint32_t column = 3 * width / 4, row = height / 2 - 30;
    const float radiance = 90000.0f;  // above the half-float range
    for (int channel = 0; channel < 3; ++channel)
        map.rgba[4 * (size_t{row} * width + column) + size_t(channel)] = radiance;
    const double theta = M_PI * (row + 0.5) / height;
    const double phi = 2.0 * M_PI * ((column + 0.5) / width - 0.75);  // from +z towards -x
    const double solidAngle = std::sin(theta) * (M_PI / height) * (2.0 * M_PI / width);
    const double cosine = std::sin(theta) * std::cos(phi);
    SetWallAnd({}, {});
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    render.scene.SetEnvironmentMap(map);
    ExpectIrradiance(radiance * solidAngle * cosine, 256);
    // Turned to the back of the wall, it gives nothing
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f), .rotation = float(M_PI)});
    EXPECT_EQ(render.Render(Settings(), 16).mean.Mean().y, 0.0);
}

TEST_F(TraceLights, Trace_LightSamplingIsBlockedByWhatIsInBetween) {
    // A card over the wall, between it and a point light
    scene::SceneData scene = SceneOf({QuadMesh(0.001f, 0), QuadMesh(0.1f, 0)}, {Lambert(glm::vec3(kWhite))},
                                     {glm::mat4x3(1.0f), Translation({0, 0, 1})});
    scene.lights = {Punctual(scene::LightType::Point, 7.0f, {0, 0, 2})};
    render.scene.SetScene(std::move(scene));
    EXPECT_EQ(render.Render(Settings(), 4).mean.Mean().y, 0.0);
    render.scene.SetVisible(1, false);
    ExpectIrradiance(7.0 / 4.0, 1);
}

TEST_F(TraceLights, Trace_MovedLightIsSampledWhereItIs) {
    SetWallAnd({QuadMesh(0.1f, 1)}, {}, glm::vec3(10.0f), Translation({0, 0, 1}));
    const double near = render.Render(Settings(), 16).mean.Mean().y;
    render.scene.SetTransform(1, Translation({0, 0, 2}));
    const double far = render.Render(Settings(), 16).mean.Mean().y;
    EXPECT_NEAR(near / far, 4.0, 0.06) << "the light's square is small beside its distance";
}

TEST_F(TraceLights, Trace_HiddenOrDarkenedLightGivesNothing) {
    SetWallAnd({QuadMesh(0.5f, 1)}, {}, glm::vec3(2.0f), Translation({0, 0, 1}));
    EXPECT_GT(render.Render(Settings(), 4).mean.Mean().y, 0.1);
    render.scene.SetVisible(1, false);
    EXPECT_EQ(render.Render(Settings(), 4).mean.Mean().y, 0.0);
    render.scene.SetVisible(1, true);
    EXPECT_GT(render.Render(Settings(), 4).mean.Mean().y, 0.1);
    render.scene.SetMaterial(1, Lambert(glm::vec3(0.0f)));
    EXPECT_EQ(render.Render(Settings(), 4).mean.Mean().y, 0.0);
}

// The rest of the strategies: tests/long.
TEST_F(TraceLights, Trace_HowLightIsFoundLeavesTheImage) {
    render.scene.SetScene(RoomWithLamp());
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    render.scene.SetEnvironmentMap(EveningSky());
    TraceSettings settings = ViewOfRoom(48);
    const RenderedImage reference = render.Render(settings, 128);
    settings.seed = 1;
    settings.lights.mis = MisHeuristic::Off;
    ExpectSameImage(render.Render(settings, 64), reference, "light sampling alone");
    settings.lights.isOn = false;
    ExpectSameImage(render.Render(settings, 192), reference, "BSDF sampling alone");
}

TEST_F(TraceLights, Trace_ChanceAndLightSamplingAgreeOnWhatBothCanFind) {
    SetWallAnd({QuadMesh(0.5f, 1)}, {}, glm::vec3(2.0f), Translation({0, 0, 1}));
    TraceSettings settings = Settings();
    const RenderedImage sampled = render.Render(settings, 32);
    settings.lights.isOn = false;
    const RenderedImage found = render.Render(settings, 64);
    const double error = std::hypot(sampled.StandardErrorOfMean().y, found.StandardErrorOfMean().y);
    EXPECT_NEAR(sampled.mean.Mean().y, found.mean.Mean().y, 4.0 * error);
    EXPECT_LT(error, 0.01 * sampled.mean.Mean().y);
    EXPECT_GT(found.variance.Mean().y, 2.0 * sampled.variance.Mean().y) << "what light sampling is for";
}

}  // namespace raygraph::testing::trace_lights_test

// Deliberate changes of a sample in Trace: named biases, and samples that are not finite.
namespace raygraph::testing::trace_bias_test {

using passes::TraceSettings;

namespace {

class TraceBias : public VulkanTest {
  protected:
    struct Counted {
        FloatImage radiance;
        std::array<FloatImage, passes::kPathPartCount> parts;
        passes::TraceCounts counts;
    };
    Counted TraceCounted(const TraceSettings& settings) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.Declare();
        const passes::TraceIds traced = passes::Trace(render.renderer, ids, settings, {.parts = true});
        const Readback radiance = render.renderer.ReadBack(traced.radiance);
        const Readback counts = render.renderer.ReadBack(traced.counts);
        std::array<Readback, passes::kPathPartCount> parts;
        for (size_t i = 0; i < parts.size(); ++i) parts[i] = render.renderer.ReadBack(traced.parts[i]);
        render.renderer.Execute();
        Counted result{.radiance = ToFloatImage(radiance), .parts = {}, .counts = {}};
        for (size_t i = 0; i < parts.size(); ++i) result.parts[i] = ToFloatImage(parts[i]);
        counts.Wait();
        std::memcpy(&result.counts, counts.Bytes().data(), sizeof result.counts);
        return result;
    }

    SceneRender render{Device()};
};

}  // namespace

// A white surface that shines as bright as the sky around it, near the end of the range of float: its samples
// are infinite, and those that see the sky are not.
TEST_F(TraceBias, Trace_InfiniteSampleIsBlackAndCounted) {
    render.scene.SetScene(SceneOf({QuadMesh(0.5f)}, {Lambert(glm::vec3(1.0f), glm::vec3(2e38f))}));
    render.scene.SetEnvironment({.radiance = glm::vec3(2e38f)});
    TraceSettings settings = LookAt({0, 0, 4}, {0, 0, 0}, 0.4f, 16);
    settings.lights.isOn = false;
    const Counted traced = TraceCounted(settings);
    uint32_t black = 0;
    for (size_t i = 0; i < traced.radiance.values.size(); ++i) {
        const glm::vec4& texel = traced.radiance.values[i];
        const bool isOnSurface = texel.w == 1.0f;
        black += isOnSurface ? 1 : 0;
        ASSERT_EQ(glm::vec3(texel), glm::vec3(isOnSurface ? 0.0f : 2e38f)) << i;
        for (const FloatImage& part : traced.parts)
            for (int c = 0; c < 3; ++c) ASSERT_TRUE(std::isfinite(part.values[i][c])) << i;
    }
    EXPECT_GT(black, 20u);
    EXPECT_LT(black, 16u * 16u);
    EXPECT_EQ(traced.counts.nonFiniteSamples, black);
    // It counts as a sample: the mean is of all of them
    EXPECT_EQ(render.Render(settings, 3).sampleCount, 3u);
}

TEST_F(TraceBias, Trace_CountsNoSampleWhereAllAreFinite) {
    render.scene.SetScene(SceneOf({QuadMesh(0.5f)}, {Lambert(glm::vec3(0.5f))}));
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    EXPECT_EQ(TraceCounted(LookAt({0, 0, 4}, {0, 0, 0}, 0.4f, 16)).counts.nonFiniteSamples, 0u);
}

// Every path of a closed box brings E, a E, a^2 E, ...; all but the first two are cut, in their own color.
TEST_F(TraceBias, Trace_ClampIndirectCutsWhatWasScatteredTwiceOrMore) {
    const glm::vec3 emitted(1.0f, 0.5f, 0.25f);
    render.scene.SetScene(SceneOf({BoxMesh(1.0f)}, {Lambert(glm::vec3(0.5f), emitted)}));
    TraceSettings settings = LookAt({0.2f, 0.1f, 0.3f}, {1.0f, 0.0f, 0.0f}, 1.0f, 8);
    settings.lights.isOn = false;
    settings.roulette.kind = Roulette::Off;
    settings.biases.maxDepth = 3;
    const auto part = [](const Counted& traced, passes::PathPart which) {
        return traced.parts[static_cast<size_t>(which)].values;
    };
    const Counted free = TraceCounted(settings);
    // 0.25 is cut and 0.125 is not, though 0.5 and 1, scattered once and never, are larger than both
    settings.biases.clampIndirect = 0.2f;
    const Counted clamped = TraceCounted(settings);
    EXPECT_EQ(part(clamped, passes::PathPart::Emission), part(free, passes::PathPart::Emission));
    EXPECT_EQ(part(clamped, passes::PathPart::Direct), part(free, passes::PathPart::Direct));
    for (size_t i = 0; i < clamped.radiance.values.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            ASSERT_NEAR(part(free, passes::PathPart::Indirect)[i][c], 0.375f * emitted[c], 1e-4f);
            ASSERT_NEAR(part(clamped, passes::PathPart::Indirect)[i][c], 0.325f * emitted[c], 1e-4f);
            ASSERT_NEAR(clamped.radiance.values[i][c], 1.825f * emitted[c], 1e-4f);
        }
    settings.biases.clampIndirect = 0.3f;  // above all
    EXPECT_EQ(TraceCounted(settings).radiance.values, free.radiance.values);
}

// The camera sees a mirror, and in it a metal behind the camera, and in that a lamp: what is regularized is
// the metal, exactly as if it had that roughness, and the mirror is not.
TEST_F(TraceBias, Trace_RegularizeRoughensWhatIsSeenAfterTheFirstBounce) {
    const auto picture = [&](float mirror, float metal, float regularize) {
        std::vector<scene::Material> materials(2);
        materials[0].roughnessFactor = mirror;
        materials[1].roughnessFactor = metal;
        for (scene::Material& material : materials) material.isDoubleSided = true;
        materials.push_back(Lambert(glm::vec3(0.0f), glm::vec3(1.0f, 2.0f, 4.0f)));
        render.scene.SetScene(SceneOf({QuadMesh(1.0f, 0), QuadMesh(3.0f, 1), QuadMesh(0.4f, 2)},
                                      std::move(materials),
                                      {glm::mat4x3(1.0f), Translation({0, 0, 3}), Translation({2, 0, 0})}));
        TraceSettings settings = LookAt({0.1f, 0.2f, 2}, {0, 0, 0}, 0.6f, 16);
        settings.scattering.brdf = BrdfModel::Gltf;
        settings.biases.maxDepth = 2;
        settings.biases.regularize = regularize;
        return render.Render(settings, 4).mean.values;
    };
    const auto sharp = picture(0.0f, 0.2f, 0.0f);
    const auto regularized = picture(0.0f, 0.2f, 0.25f);
    EXPECT_NE(regularized, sharp);
    EXPECT_EQ(regularized, picture(0.0f, 0.5f, 0.0f)) << "an alpha of 0.25";
    EXPECT_EQ(picture(0.0f, 0.8f, 0.25f), picture(0.0f, 0.8f, 0.0f)) << "rougher than that already";
    EXPECT_NE(picture(0.5f, 0.2f, 0.25f), regularized) << "the mirror that the camera sees stays one";
}

// Light from the right of the picture grazes the middle of a sphere, where a triangle has just turned away
// from it that its normals still half face.
TEST_F(TraceBias, Trace_ShadowTerminatorBrightensWhereLightGrazesASphereOfFewTriangles) {
    const float turn = 8.0f * 3.14159265f / 180.0f;
    const auto picture = [&](uint32_t rings, bool isOn) {
        scene::SceneData scene = SceneOf({SphereMesh(1.0f, rings)}, {Lambert(glm::vec3(0.8f))});
        scene::Light light;
        light.type = scene::LightType::Directional;  // along -z of its own
        light.lightToWorld[0] = {std::cos(turn), 0.0f, -std::sin(turn)};
        light.lightToWorld[2] = {std::sin(turn), 0.0f, std::cos(turn)};
        scene.lights.push_back(light);
        render.scene.SetScene(std::move(scene));
        TraceSettings settings = LookAt({8, 0, 0}, {0, 0, 0}, 0.2f, 32);
        settings.biases.shadowTerminator = isOn;
        return render.Render(settings, 4).mean;
    };
    const FloatImage truth = picture(96, false), off = picture(8, false), on = picture(8, true);
    const float brightest = 0.8f / 3.14159265f;
    glm::dvec3 grazed(0.0), lit(0.0);  // sums of the three
    for (size_t i = 0; i < truth.values.size(); ++i)
        (truth.values[i].y > 0.25f * brightest ? lit : grazed) +=
            glm::dvec3(truth.values[i].y, off.values[i].y, on.values[i].y);
    EXPECT_GT(grazed.z, 1.1 * grazed.y);
    EXPECT_LT(std::abs(grazed.z - grazed.x), 0.5 * std::abs(grazed.y - grazed.x));
    EXPECT_NEAR(lit.z, lit.y, 0.02 * lit.y);
    const double before = off.Mean().y, after = on.Mean().y;
    EXPECT_GT(after, 1.002 * before) << "the bias that docs/sampling.md names";
    EXPECT_LT(after, 1.05 * before);
}

}  // namespace raygraph::testing::trace_bias_test

// The thin lens, by the circle of confusion: a point at distance d along the view, through a lens of radius R
// that is sharp at distance f, is a disc of radius R |1/f - 1/d| on the film at distance 1. Its second moment
// along each axis is a quarter of the squared radius.
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
    // Measures a shining square that spans 4 x 4 pixels without a lens. The camera looks along -z from the
    // origin.
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

// LambertPath: the loop and the recursion that the bench compares do the same work.
namespace raygraph::testing::recursion_test {

using passes::PathForm;

namespace {

class LambertPathTest : public VulkanTest {
  protected:
    void SetUp() override {
        VulkanTest::SetUp();
        if (!passes::CanRecurse(Device()))
            GTEST_SKIP() << "maxRayRecursionDepth is " << Device().Info().maxRayRecursionDepth;
    }
    FloatImage Render(PathForm form, const passes::TraceSettings& settings) {
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const Readback radiance =
            render.renderer.ReadBack(passes::LambertPath(render.renderer, ids, settings, form));
        render.renderer.Execute();
        return ToFloatImage(radiance);
    }

    SceneRender render{Device()};
};

// Largest difference of a component, relative to the larger of the two.
double LargestRelativeDifference(const FloatImage& a, const FloatImage& b) {
    double largest = 0.0;
    for (size_t i = 0; i < a.values.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double x = double{a.values[i][c]}, y = double{b.values[i][c]};
            if (x != y) largest = std::max(largest, std::abs(x - y) / std::max(std::abs(x), std::abs(y)));
        }
    return largest;
}

}  // namespace

TEST_F(LambertPathTest, BothForms_SumTenBouncesInAClosedBox) {
    const double albedo = 0.75, emission = 0.25;
    render.scene.SetScene(
        SceneOf({BoxMesh(1.0f)}, {Lambert(glm::vec3(float(albedo)), glm::vec3(float(emission)))}));
    const passes::TraceSettings settings = LookAt({-0.8f, 0.1f, 0.3f}, {1.0f, -0.5f, 0.0f}, 1.2f, 32);
    const double sum = emission * (1.0 - std::pow(albedo, kLambertBounces + 1)) / (1.0 - albedo);
    for (const PathForm form : {PathForm::Loop, PathForm::Recursive})
        for (const glm::vec4& value : Render(form, settings).values)
            ASSERT_NEAR(value.x, sum, 1e-5 * sum) << "form " << int(form);
}

TEST_F(LambertPathTest, BothForms_SeeTheSkyAndWhatAFloorReflectsOfIt) {
    render.scene.SetScene(SceneOf({QuadMesh(1.0f)}, {Lambert({0.5f, 0.25f, 0.125f})}));
    render.scene.SetEnvironment({.radiance = glm::vec3(2.0f)});
    const passes::TraceSettings settings = LookAt({0, 0, 4}, {0, 0, 0}, 1.0f, 32);
    for (const PathForm form : {PathForm::Loop, PathForm::Recursive}) {
        const FloatImage image = Render(form, settings);
        EXPECT_EQ(glm::vec3(image.At(0, 0)), glm::vec3(2.0f)) << "form " << int(form);
        EXPECT_EQ(glm::vec3(image.At(16, 16)), glm::vec3(1.0f, 0.5f, 0.25f)) << "form " << int(form);
    }
}

// Boxes under a sky: paths of every length.
TEST_F(LambertPathTest, BothForms_GiveTheSamePicture) {
    render.scene.SetScene(SceneOf(
        {BoxMesh(0.4f, 0), SphereMesh(0.5f, 12, 1), QuadMesh(2.0f, 2)},
        {Lambert({0.8f, 0.3f, 0.1f}), Lambert(glm::vec3(0.9f), {0.0f, 0.2f, 0.4f}), Lambert(glm::vec3(0.7f))},
        {Translation({0.4f, -0.5f, 0.5f}), Translation({-0.6f, 0.2f, 0.55f}), glm::mat4x3(1.0f)}));
    render.scene.SetEnvironment({.radiance = {0.5f, 0.6f, 0.7f}});
    passes::TraceSettings settings = LookAt({0.5f, -2.0f, 2.0f}, {0, 0, 0.3f}, 0.9f, 64);
    settings.sampleIndex = 3;
    const FloatImage loop = Render(PathForm::Loop, settings);
    const FloatImage recursive = Render(PathForm::Recursive, settings);
    EXPECT_LT(LargestRelativeDifference(loop, recursive), 1e-5);
    settings.sampleIndex = 4;
    EXPECT_GT(LargestRelativeDifference(loop, Render(PathForm::Recursive, settings)), 0.1)
        << "another sample is another picture";
}

}  // namespace raygraph::testing::recursion_test
