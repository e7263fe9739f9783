// Every kind of light against its closed form, on the device, by light sampling.
#include <cmath>

#include "tests/support/same_image.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

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
    // The same near the world's origin and 100 m off, where float steps are 1000 times as large
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

TEST_F(TraceLights, Trace_EnvironmentOfUnitRadianceGivesPi) {
    SetWallAnd({}, {});
    render.scene.SetEnvironment({.radiance = glm::vec3(1.0f)});
    ExpectIrradiance(M_PI);
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
