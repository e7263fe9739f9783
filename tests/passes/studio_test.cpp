// The built-in studio: what it does to a gray ball, and when a GpuScene shows it.
#include "renderer/scene/model/studio.h"

#include <cmath>
#include <functional>

#include "renderer/gpu_scene/streaming/prepared_scene.h"
#include "tests/passes/scene_parts.h"
#include "tests/support/scene_render.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::testing::studio_test {
namespace {

const glm::vec3 kGray(0.18f);

scene::SceneData Ball() {
    return SceneOf({SphereMesh(1.0f, 64)}, {Lambert(kGray)});
}
// A floor in the light of a large lamp.
scene::SceneData LitFloor() {
    return SceneOf({QuadMesh(1.0f, 0), QuadMesh(0.5f, 1)}, {Lambert(kGray), Lambert(kGray, glm::vec3(4.0f))},
                   {glm::mat4x3(1.0f), Translation({0, 0, 1})});
}

class StudioTest : public VulkanTest {
  protected:
    static bool HasStudio(const GpuScene& scene) {
        const DefaultLight shown = scene.ShownEnvironment().defaultLight;
        EXPECT_NE(shown, DefaultLight::Auto);
        return shown == DefaultLight::Studio;
    }
    // From where a scene without a camera is seen.
    static passes::TraceSettings Framed(const scene::Bounds& bounds, uint32_t size) {
        passes::TraceSettings settings;
        settings.extent = {size, size};
        settings.camera = ToRecord(scene::ViewOfBounds(bounds, 1.0f));
        settings.scattering.brdf = BrdfModel::Lambert;
        return settings;
    }

    SceneRender render{Device()};
    GpuScene& scene = render.scene;
};

TEST_F(StudioTest, AGrayBallHasTheMeanRadianceOfItsReflectance) {
    scene::SceneData ball = Ball();
    scene::CameraView view = scene::ViewOfBounds(ball.bounds, 1.0f);
    view.projection = scene::Projection::Orthographic;
    view.height = 2.0f;
    scene.SetScene(std::move(ball));
    passes::TraceSettings settings = Framed({}, 32);
    settings.camera = ToRecord(view);
    settings.isEnvironmentHidden = true;
    const RenderedImage image = render.Render(settings, 64);
    // Radiance is that of what covers a pixel
    double covered = 0.0;
    for (const glm::vec4& texel : image.mean.values) covered += texel.w;
    const glm::dvec3 mean = image.mean.Mean() * double(image.mean.values.size()) / covered;
    const glm::dvec3 error = image.StandardErrorOfMean() * double(image.mean.values.size()) / covered;
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(mean[c], 0.18, 4.0 * error[c] + 0.001);
        EXPECT_LT(error[c], 0.001);
    }
}

TEST_F(StudioTest, ABallIsBrightOnTheKeysSideAndNowhereBlackOrBurnedOut) {
    scene::SceneData ball = Ball();
    const passes::TraceSettings settings = Framed(ball.bounds, 33);
    scene.SetScene(std::move(ball));
    const RenderedImage image = render.Render(settings, 64);
    const auto at = [&](int x, int y) { return double{image.mean.At(16 + x, 16 + y).y}; };
    EXPECT_GT(at(-6, -6), 1.4 * at(6, 6)) << "upper left against lower right";
    for (const glm::ivec2 place : {glm::ivec2(0, 0), {-8, 0}, {8, 0}, {0, 8}, {0, -8}, {6, 6}}) {
        EXPECT_GT(at(place.x, place.y), 0.25 * 0.18);
        EXPECT_LT(at(place.x, place.y), 3.0 * 0.18);
    }
}

TEST_F(StudioTest, ItIsShownWhereNothingElseLights) {
    EXPECT_TRUE(HasStudio(scene)) << "an empty scene";
    scene.SetScene(Ball());
    EXPECT_TRUE(HasStudio(scene));
    scene.SetScene(LitFloor());
    EXPECT_FALSE(HasStudio(scene));
    scene::SceneData lamp = Ball();
    lamp.lights.emplace_back();
    scene.SetScene(std::move(lamp));
    EXPECT_FALSE(HasStudio(scene));
    scene::SceneData withEnvironment = Ball();
    withEnvironment.environment.map = {1, 1, {0.5f, 0.5f, 0.5f, 1.0f}};
    scene.SetScene(std::move(withEnvironment));
    EXPECT_FALSE(HasStudio(scene));
    scene.SetScene({});
    EXPECT_TRUE(HasStudio(scene));
}

TEST_F(StudioTest, WhatTheHostSaysCounts) {
    scene.SetScene(Ball());
    scene.SetEnvironment({});
    EXPECT_FALSE(HasStudio(scene)) << "black is asked for";
    scene.SetEnvironment({.radiance = glm::vec3(1.0f), .usesScene = true});
    EXPECT_TRUE(HasStudio(scene));
    scene.SetEnvironment(
        {.radiance = glm::vec3(1.0f), .usesScene = true, .defaultLight = DefaultLight::None});
    EXPECT_FALSE(HasStudio(scene));
    scene.SetEnvironment(
        {.radiance = glm::vec3(1.0f), .usesScene = true, .defaultLight = DefaultLight::Studio});
    EXPECT_TRUE(HasStudio(scene));
    scene.SetEnvironmentMap({1, 1, {0.5f, 0.5f, 0.5f, 1.0f}});
    EXPECT_FALSE(HasStudio(scene));
    scene.RemoveEnvironmentMap();
    EXPECT_TRUE(HasStudio(scene));
    scene.SetScene(LitFloor());
    EXPECT_TRUE(HasStudio(scene)) << "it is asked for";
}

TEST_F(StudioTest, ItDoesNotDependOnTheOrderOfCalls) {
    // A box, of which a small part glows: anything that emits would count as light, if it were not measured
    const auto withLogo = [] {
        return SceneOf({BoxMesh(1.0f, 0), QuadMesh(0.05f, 1)},
                       {Lambert(kGray), Lambert(kGray, glm::vec3(1.0f))},
                       {glm::mat4x3(1.0f), Translation({0, 0, 1.05f})});
    };
    const EnvironmentSettings open{.radiance = glm::vec3(1.0f), .usesScene = true};
    const image::ImageF map{1, 1, {0.5f, 0.5f, 0.5f, 1.0f}};
    const std::vector<std::function<void()>> others = {
        [&] { scene.SetEnvironment({}); },
        [&] { scene.SetEnvironment({.usesScene = true, .defaultLight = DefaultLight::None}); },
        [&] { scene.SetEnvironment({.usesScene = true, .defaultLight = DefaultLight::Studio}); },
        [&] { scene.SetEnvironmentMap(map); }};
    for (const auto& setAnother : others) {
        for (const bool isLit : {false, true}) {
            setAnother();
            scene.SetScene(isLit ? LitFloor() : withLogo());
            scene.RemoveEnvironmentMap();
            scene.SetEnvironment(open);
            EXPECT_EQ(HasStudio(scene), !isLit) << "the environment is set after the scene";
            setAnother();
            scene.RemoveEnvironmentMap();
            scene.SetEnvironment(open);
            scene.SetScene(isLit ? LitFloor() : withLogo());
            EXPECT_EQ(HasStudio(scene), !isLit) << "the environment is set before the scene";
        }
        scene.SetScene({});
        setAnother();
        const AddedPart part = scene.Add(withLogo());
        scene.RemoveEnvironmentMap();
        scene.SetEnvironment(open);
        EXPECT_TRUE(HasStudio(scene)) << "the environment is set after a part";
        scene.Remove(part);
    }
}

TEST_F(StudioTest, TintRotationAndWhatIsSeenAreThoseOfAMap) {
    passes::TraceSettings settings = Framed({}, 8);
    const auto corner = [&] { return render.Render(settings, 1).mean.At(0, 0); };
    const glm::vec4 plain = corner();
    EXPECT_GT(plain.y, 0.1f);
    const image::ImageF map = scene::StudioMap();
    scene.SetEnvironmentMap(map);
    EXPECT_EQ(corner(), plain);
    const EnvironmentSettings turned{.radiance = {2.0f, 1.0f, 0.5f}, .rotation = 1.5f, .usesScene = true};
    scene.SetEnvironment(turned);
    const glm::vec4 asMap = corner();
    scene.RemoveEnvironmentMap();
    EXPECT_EQ(corner(), asMap);
    EXPECT_NE(asMap.x / asMap.y, plain.x / plain.y);
}

TEST_F(StudioTest, LightsOfTheHostTurnItOffAndOnAgain) {
    scene.SetScene(Ball());
    const uint32_t light = scene.AddLight({});
    EXPECT_FALSE(HasStudio(scene));
    scene.SetLightVisible(light, false);
    EXPECT_FALSE(HasStudio(scene)) << "nor does it come with a switch";
    scene.RemoveLight(light);
    EXPECT_TRUE(HasStudio(scene));

    const AddedPart part = scene.Add(LitFloor());
    EXPECT_FALSE(HasStudio(scene));
    scene.Remove(part);
    EXPECT_TRUE(HasStudio(scene));
    const AddedPart ball = scene.Add(Ball());
    EXPECT_TRUE(HasStudio(scene));

    const uint32_t lamp = scene.AddMaterial(Lambert(kGray, glm::vec3(1.0f)));
    const uint32_t mesh = scene.AddMesh(QuadMesh(1.0f, lamp));
    EXPECT_TRUE(HasStudio(scene)) << "it is not placed";
    const uint32_t placed = scene.AddInstance(mesh, scene::PlacedTransform{});
    EXPECT_FALSE(HasStudio(scene));
    scene.RemoveInstance(placed);
    EXPECT_TRUE(HasStudio(scene));
    scene.AddInstance(ball.meshes[0], scene::PlacedTransform{});
    EXPECT_TRUE(HasStudio(scene));
}

TEST_F(StudioTest, APartThatStreamsTurnsItOffFromTheStart) {
    scene.SetScene(Ball());
    const auto part = scene.Stream(PreparedScene(LitFloor()));
    EXPECT_FALSE(HasStudio(scene));
    scene.Remove(*part);
    EXPECT_TRUE(HasStudio(scene));
}

TEST_F(StudioTest, EditsOfWhatIsThereDecideNothing) {
    scene.SetScene(Ball());
    scene.SetMaterial(0, Lambert(kGray, glm::vec3(100.0f)));
    EXPECT_TRUE(HasStudio(scene));
    scene.SetScene(LitFloor());
    scene.SetMaterial(1, Lambert(kGray));
    scene.SetVisible(1, false);
    EXPECT_FALSE(HasStudio(scene));
}

TEST_F(StudioTest, WhatIsMadeOfTheEnvironmentFollowsASwitch) {
    scene.SetScene(Ball());
    const auto version = [&] {
        render.renderer.BeginFrame();
        const uint64_t its = scene.Declare(render.renderer).environmentVersion;
        render.renderer.Execute();
        return its;
    };
    const uint64_t studio = version();
    EXPECT_EQ(version(), studio);
    const uint32_t light = scene.AddLight({});
    const uint64_t without = version();
    EXPECT_NE(without, studio);
    scene.RemoveLight(light);
    EXPECT_NE(version(), without);
}

TEST(StudioMap, IsGrayFiniteAndWithoutSharpEdges) {
    const image::ImageF map = scene::StudioMap();
    ASSERT_EQ(map.rgba.size(), size_t{4} * map.width * map.height);
    const auto at = [&](uint32_t x, uint32_t y) {
        return map.rgba[4 * (size_t{y} * map.width + x % map.width)];
    };
    float steepest = 0.0f, brightest = 0.0f;
    for (uint32_t y = 0; y < map.height; ++y)
        for (uint32_t x = 0; x < map.width; ++x) {
            const float* texel = &map.rgba[4 * (size_t{y} * map.width + x)];
            ASSERT_TRUE(std::isfinite(texel[0]) && texel[0] > 0.0f);
            ASSERT_TRUE(texel[0] == texel[1] && texel[1] == texel[2]);
            brightest = std::max(brightest, texel[0]);
            // In the seam, too; rows near the poles have texels closer than that
            steepest = std::max(steepest, std::abs(at(x + 1, y) - at(x, y)));
            if (y > 0) steepest = std::max(steepest, std::abs(at(x, y - 1) - at(x, y)));
        }
    EXPECT_LT(steepest, 0.3f * brightest);
    EXPECT_LT(brightest, 20.0f);
}

TEST(StudioMap, ItsKeyAndRimLightsAreAboveWhatLevelCamerasSee) {
    const image::ImageF map = scene::StudioMap();
    const auto at = [&](uint32_t x, uint32_t y) { return map.rgba[4 * (size_t{y} * map.width + x)]; };
    float brightest = 0.0f, low = 0.0f, beside = 0.0f;
    for (uint32_t y = 0; y < map.height; ++y)
        for (uint32_t x = 0; x < map.width; ++x) {
            const float elevation = 90.0f - 180.0f * (float(y) + 0.5f) / float(map.height);
            brightest = std::max(brightest, at(x, y));
            if (elevation < 20.0f) low = std::max(low, at(x, y));
            // The fill comes from +x, the middle column; the half to the left of it has the backdrop alone
            const bool isAtFill = x > map.width / 4 && x < 3 * map.width / 4;
            if (elevation < 20.0f && !isAtFill) beside = std::max(beside, at(x, y));
        }
    EXPECT_LT(low, 0.25f * brightest);
    EXPECT_LE(beside, 1.01f * at(0, map.height / 2)) << "the backdrop at the horizon";
}

}  // namespace
}  // namespace raygraph::testing::studio_test
