#include <gtest/gtest.h>
#include <array>
#include <cmath>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>
#include <string_view>

#include "passes/raster.h"
#include "renderer/gpu_scene/lights/own_light.h"
#include "renderer/gpu_scene/streaming/prepared_scene.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/scene_fields.h"
#include "renderer/scene/model/studio.h"
#include "tests/passes/cell_scenes.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/ies_text.h"
#include "tests/support/reference_assets.h"
#include "tests/support/scene_render.h"
#include "tests/support/source_file.h"
#include "tests/support/vulkan_test.h"

// Which scenes have light of their own, and which are black without the studio.
namespace raygraph::testing::own_light_test {
namespace {

const glm::vec3 kGray(0.5f);
// Facing down.
const glm::mat4x3 kDown = glm::mat4x3(glm::rotate(glm::mat4(1.0f), glm::radians(90.0f), {1.0f, 0.0f, 0.0f}));
const glm::mat4x3 kUp = glm::mat4x3(glm::rotate(glm::mat4(1.0f), glm::radians(-90.0f), {1.0f, 0.0f, 0.0f}));

glm::mat4x3 At(glm::mat4x3 turned, const glm::vec3& place) {
    turned[3] = place;
    return turned;
}

scene::Light Bulb(float intensity) {
    scene::Light light;
    light.intensity = intensity;
    return light;
}

// A floor of 4 m below a lamp of 20 cm that shines down with this radiance.
scene::SceneData FloorAndLamp(float radiance) {
    scene::SceneData data =
        SceneOf({QuadMesh(2.0f, 0), QuadMesh(0.1f, 1)}, {Lambert(kGray), Lambert(kGray, glm::vec3(radiance))},
                {kUp, At(kDown, {0, 1, 0})});
    data.materials[0].isDoubleSided = data.materials[1].isDoubleSided = false;
    return data;
}

// A ball, of whose texture one texel of 64 x 64 glows: a logo.
scene::SceneData BallWithLogo() {
    scene::SceneData data = SceneOf({SphereMesh(1.0f, 32)}, {Lambert(kGray, glm::vec3(1.0f))});
    scene::Primitive& primitive = data.meshes[0].primitives[0];
    for (const glm::vec3& p : primitive.positions)
        primitive.uv0.emplace_back(0.5f + std::atan2(p.z, p.x) / 6.2831853f, std::acos(p.y) / 3.1415927f);
    data.textures.resize(1);
    data.textures[0].colorSpace = scene::ColorSpace::Srgb;
    scene::ImageData& image = data.images.emplace_back();
    image.width = image.height = 64;
    image.rgba.assign(4 * 64 * 64, 0);
    for (size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
    // Where the framing view sees it: half way up, towards +z
    const size_t logo = 4 * (32 * 64 + 48);
    image.rgba[logo] = image.rgba[logo + 1] = image.rgba[logo + 2] = 255;
    data.materials[0].emissiveTexture.texture = 0;
    return data;
}

// Adds a texture of one texel: where there are no texture coordinates, all surfaces have its color.
int32_t AddTexel(scene::SceneData& data, const std::array<uint8_t, 4>& rgba) {
    scene::Texture& texture = data.textures.emplace_back();
    texture.image = static_cast<uint32_t>(data.images.size());
    texture.colorSpace = scene::ColorSpace::Srgb;
    data.images.push_back(
        {.name = "", .width = 1, .height = 1, .rgba = std::vector<uint8_t>(rgba.begin(), rgba.end())});
    return static_cast<int32_t>(data.textures.size() - 1);
}

// Adds an animation of one value, which holds at all times.
void Animate(scene::SceneData& data, const scene::AnimationTarget& target, const std::vector<float>& value) {
    scene::Animation& animation = data.animations.emplace_back();
    animation.samplers.push_back(
        {.width = static_cast<uint32_t>(value.size()), .times = {0.0f}, .values = value});
    animation.channels.push_back({0, target});
}

// The place of a field among those that animations name.
template <typename List>
uint8_t IndexOf(std::string_view name, const List& list) {
    uint8_t index = 0, found = 255;
    std::apply([&](const auto&... field) { ((name == field.name ? found = index : found, ++index), ...); },
               list);
    return found;
}

scene::AnimationTarget OfMaterial(std::string_view name, uint32_t material) {
    return {scene::AnimatedProperty::MaterialField, IndexOf(name, scene::material_fields::kAll), material};
}
scene::AnimationTarget OfLight(std::string_view name) {
    return {scene::AnimatedProperty::LightField, IndexOf(name, scene::light_fields::kAll), 0};
}
scene::AnimationTarget VisibilityOf(uint32_t node) {
    return {scene::AnimatedProperty::Visibility, 0, node};
}

TEST(OwnLight, ASceneWithoutLightHasNone) {
    EXPECT_FALSE(HasOwnLight({}));
    EXPECT_FALSE(HasOwnLight(SceneOf({BoxMesh(1.0f)}, {Lambert(kGray)})));
}

TEST(OwnLight, APunctualLightCountsIfItShinesOrAnAnimationMakesItShine) {
    scene::SceneData hidden = SceneOf({BoxMesh(1.0f)}, {Lambert(kGray)});
    hidden.nodes.resize(3);
    hidden.nodes[1].parent = 0;
    hidden.nodeOrder = {0, 1, 2};
    hidden.lights = {Bulb(1.0f)};
    hidden.lights[0].node = 1;
    EXPECT_TRUE(HasOwnLight(hidden));
    hidden.nodes[0].isVisible = false;
    EXPECT_FALSE(HasOwnLight(hidden));
    EXPECT_FALSE(MayHaveOwnLight(hidden));
    const auto withVisibility = [&](uint32_t node, float value) {
        scene::SceneData data = hidden;
        Animate(data, VisibilityOf(node), {value});
        return HasOwnLight(data);
    };
    EXPECT_TRUE(withVisibility(0, 1.0f));
    EXPECT_FALSE(withVisibility(0, 0.0f)) << "it stays hidden";
    EXPECT_FALSE(withVisibility(1, 1.0f)) << "what is above it stays hidden";
    EXPECT_FALSE(withVisibility(2, 1.0f)) << "another node";
    Animate(hidden, {scene::AnimatedProperty::Translation}, {1, 2, 3});
    EXPECT_FALSE(HasOwnLight(hidden)) << "what moves the node turns no light on";

    scene::SceneData dark = SceneOf({BoxMesh(1.0f)}, {Lambert(kGray)});
    dark.lights = {Bulb(0.0f)};
    EXPECT_FALSE(HasOwnLight(dark));
    EXPECT_FALSE(MayHaveOwnLight(dark));
    Animate(dark, OfLight("color"), {1, 1, 1});
    EXPECT_FALSE(HasOwnLight(dark)) << "a color alone does not shine";
    Animate(dark, OfLight("intensity"), {0.0f});
    EXPECT_FALSE(HasOwnLight(dark));
    Animate(dark, OfLight("intensity"), {2.0f});
    EXPECT_TRUE(HasOwnLight(dark));
    EXPECT_TRUE(MayHaveOwnLight(dark));
}

TEST(OwnLight, EmissionCountsIfItLightsAQuarterOfWhatIsSeen) {
    EXPECT_TRUE(HasOwnLight(FloorAndLamp(10.0f)));
    EXPECT_FALSE(HasOwnLight(FloorAndLamp(0.1f))) << "the floor is all but black at exposure 0";
    scene::SceneData away = FloorAndLamp(10.0f);
    away.instances[1].objectToWorld = At(kUp, {0, 1, 0});
    EXPECT_FALSE(HasOwnLight(away)) << "it shines to the sky, and is little to see itself";
    EXPECT_FALSE(HasOwnLight(BallWithLogo()));
    scene::SceneData glowing = BallWithLogo();
    std::ranges::fill(glowing.images[0].rgba, uint8_t{255});
    EXPECT_TRUE(HasOwnLight(glowing)) << "all of it is bright";
}

TEST(OwnLight, WhatStandsInTheLightCountsAndGlassDoesNot) {
    scene::SceneData covered = FloorAndLamp(10.0f);
    covered.meshes.push_back(QuadMesh(0.3f, 2));
    covered.materials.push_back(Lambert(kGray));
    covered.instances.push_back({.mesh = 2, .objectToWorld = At(kDown, {0, 0.95f, 0})});
    EXPECT_FALSE(HasOwnLight(covered));
    covered.materials[2].transmissionFactor = 1.0f;
    EXPECT_TRUE(HasOwnLight(covered));
    covered.materials[2].transmissionFactor = 0.0f;
    covered.materials[2].alphaMode = scene::AlphaMode::Blend;
    EXPECT_FALSE(HasOwnLight(covered)) << "it is blended, and opaque";
    covered.materials[2].baseColorFactor.w = 0.05f;
    EXPECT_TRUE(HasOwnLight(covered));
    // Rays pass by the backs of what is single-sided
    covered.materials[2].alphaMode = scene::AlphaMode::Opaque;
    covered.materials[2].isDoubleSided = false;
    EXPECT_FALSE(HasOwnLight(covered));
    covered.instances[2].objectToWorld = At(kUp, {0, 0.95f, 0});
    EXPECT_TRUE(HasOwnLight(covered));
}

TEST(OwnLight, UnlitSurfacesShowWithoutLight) {
    scene::SceneData data = SceneOf({BoxMesh(1.0f, 0), BoxMesh(0.1f, 1)}, {Lambert(kGray), Lambert(kGray)},
                                    {glm::mat4x3(1.0f), Translation({0, 0, 1.05f})});
    data.materials[1].isUnlit = true;
    EXPECT_FALSE(HasOwnLight(data));
    data.materials[0].isUnlit = true;
    EXPECT_TRUE(HasOwnLight(data));
}

TEST(OwnLight, UnlitSurfacesShowTheirColorWhateverItIs) {
    scene::SceneData data = SceneOf({BoxMesh(1.0f)}, {Lambert(kGray)});
    data.materials[0].isUnlit = true;
    const int32_t dark = AddTexel(data, {2, 2, 2, 255}), bright = AddTexel(data, {200, 200, 200, 255});
    data.materials[0].baseColorTexture.texture = bright;
    EXPECT_TRUE(HasOwnLight(data));
    data.materials[0].baseColorTexture.texture = dark;
    EXPECT_FALSE(HasOwnLight(data)) << "the map is all but black";
    EXPECT_TRUE(MayHaveOwnLight(data));
    data.materials[0].baseColorTexture.texture = bright;
    data.materials[0].baseColorFactor = {0.001f, 0.001f, 0.001f, 1.0f};
    EXPECT_FALSE(HasOwnLight(data));
    data.materials[0].baseColorFactor = glm::vec4(1.0f);
    scene::Primitive& box = data.meshes[0].primitives[0];
    box.colors.assign(box.positions.size(), {0.0f, 0.0f, 0.0f, 1.0f});
    EXPECT_FALSE(HasOwnLight(data)) << "vertex colors count, too";
    data.materials[0].emissiveFactor = glm::vec3(100.0f);
    EXPECT_FALSE(HasOwnLight(data)) << "what is unlit emits nothing";
    data.materials[0].baseColorFactor = {0.0f, 0.0f, 0.0f, 1.0f};
    EXPECT_FALSE(MayHaveOwnLight(data));
}

TEST(OwnLight, UnlitSurfacesLightOthersByTheirColor) {
    // The ceiling is seen from below only, and the camera is above it
    scene::SceneData data = FloorAndLamp(0.0f);
    data.meshes[1] = QuadMesh(2.0f, 1);
    data.materials[1].isUnlit = true;
    EXPECT_TRUE(HasOwnLight(data));
    data.materials[1].baseColorFactor = {0.004f, 0.004f, 0.004f, 1.0f};
    EXPECT_FALSE(HasOwnLight(data));
}

TEST(OwnLight, LightPassesAndComesFromNoHoleOfAMask) {
    scene::SceneData covered = FloorAndLamp(10.0f);
    covered.meshes.push_back(QuadMesh(0.3f, 2));
    covered.materials.push_back(Lambert(kGray));
    covered.materials[2].alphaMode = scene::AlphaMode::Mask;
    covered.instances.push_back({.mesh = 2, .objectToWorld = At(kDown, {0, 0.95f, 0})});
    const int32_t hole = AddTexel(covered, {255, 255, 255, 100});
    EXPECT_FALSE(HasOwnLight(covered));
    covered.materials[2].baseColorTexture.texture = hole;
    EXPECT_TRUE(HasOwnLight(covered)) << "the cover is a hole";
    covered.materials[2].alphaCutoff = 0.3f;
    EXPECT_FALSE(HasOwnLight(covered));
    covered.materials[2].alphaCutoff = 0.5f;
    covered.materials[1].alphaMode = scene::AlphaMode::Mask;
    EXPECT_TRUE(HasOwnLight(covered));
    covered.materials[1].baseColorTexture.texture = hole;
    EXPECT_FALSE(HasOwnLight(covered)) << "the lamp is a hole";
}

TEST(OwnLight, WhatIsTransparentIsNotSeen) {
    for (const bool isUnlit : {false, true}) {
        scene::SceneData data =
            SceneOf({BoxMesh(1.0f, 0), BoxMesh(2.0f, 1)}, {Lambert(kGray), Lambert(kGray, glm::vec3(1e-3f))});
        scene::Material& shell = data.materials[1];
        shell.isDoubleSided = true;
        shell.isUnlit = isUnlit;
        shell.emissiveStrength = isUnlit ? 0.0f : 10.0f;  // it is seen, and too dark to light the box
        shell.baseColorFactor = glm::vec4(0.01f, 0.01f, 0.01f, 1.0f);
        EXPECT_TRUE(HasOwnLight(data)) << isUnlit;
        shell.alphaMode = scene::AlphaMode::Blend;
        shell.baseColorFactor.w = 0.02f;
        EXPECT_FALSE(HasOwnLight(data)) << isUnlit;
        shell.alphaMode = scene::AlphaMode::Mask;
        EXPECT_FALSE(HasOwnLight(data)) << isUnlit;
        shell.alphaCutoff = 0.01f;
        EXPECT_TRUE(HasOwnLight(data)) << isUnlit;
    }
}

TEST(OwnLight, LampsThatAreScaledUnevenlyHaveThePowerOfTheirArea) {
    // The lamp above the floor is flattened along its normal, and another one shines to the sky
    scene::SceneData data = FloorAndLamp(40.0f);
    data.instances[1].objectToWorld =
        glm::mat4x3(glm::mat4(At(kDown, {0, 1, 0})) * glm::scale(glm::mat4(1.0f), {1.0f, 1.0f, 1e-5f}));
    EXPECT_TRUE(HasOwnLight(data));
    data.meshes.push_back(QuadMesh(0.1f, 1));
    for (int i = 0; i < 4; ++i)
        data.instances.push_back({.mesh = 2, .objectToWorld = At(kUp, {0.5f * float(i), 0.5f, 0})});
    EXPECT_TRUE(HasOwnLight(data));
}

TEST(OwnLight, TheScenesCamerasDecideIfThereAreSome) {
    // A closed room, dark from outside
    scene::SceneData room =
        SceneOf({BoxMesh(1.0f, 0), QuadMesh(0.2f, 1)}, {Lambert(kGray), Lambert(kGray, glm::vec3(10.0f))},
                {glm::mat4x3(1.0f), At(kDown, {0, 0.9f, 0})});
    EXPECT_FALSE(HasOwnLight(room));
    room.cameras.emplace_back().cameraToWorld[3] = {0, 0, 0.9f};
    EXPECT_TRUE(HasOwnLight(room));
    // One that sees nothing is none
    room.cameras[0].cameraToWorld[3] = {0, 50, 0};
    EXPECT_FALSE(HasOwnLight(room));
}

TEST(OwnLight, ItDoesNotDependOnPlaceUnitOrNumberOfPlacements) {
    for (const float unit : {1e-3f, 1.0f, 1e3f})
        for (const glm::vec3& place : {glm::vec3(0.0f), glm::vec3(1e6f, 0.0f, -2e6f)}) {
            for (const bool isLit : {false, true}) {
                scene::SceneData data = isLit ? FloorAndLamp(10.0f) : BallWithLogo();
                data.bounds = {};
                for (scene::Instance& instance : data.instances) {
                    instance.objectToWorld = glm::mat4x3(glm::scale(glm::mat4(1.0f), glm::vec3(unit)) *
                                                         glm::mat4(instance.objectToWorld));
                    instance.translationResidual = instance.objectToWorld[3];
                    instance.objectToWorld[3] = place;
                    data.bounds.Extend(place);
                }
                EXPECT_EQ(HasOwnLight(data), isLit) << unit << " " << place.x;
            }
        }
    // A room of 3 m with a lamp, on ground that is a million times as large
    for (const float ground : {10.0f, 1e5f, 1e7f}) {
        scene::SceneData room =
            SceneOf({BoxMesh(1.5f, 0), QuadMesh(0.3f, 1), QuadMesh(ground, 0)},
                    {Lambert(kGray), Lambert(glm::vec3(0.0f), glm::vec3(20.0f))},
                    {At(glm::mat4x3(1.0f), {}), At(kDown, {0, 1.4f, 0}), At(kUp, {0, -1.6f, 0})});
        for (scene::Material& material : room.materials) material.isDoubleSided = true;
        room.cameras.emplace_back().cameraToWorld[3] = {0.0f, 0.0f, 1.4f};
        EXPECT_TRUE(HasOwnLight(room)) << ground;
    }
    // The first of a thousand lamps would be too far away for most of the floor
    scene::SceneData many = FloorAndLamp(5.0f);
    many.instances[0].objectToWorld = glm::mat4x3(glm::scale(glm::mat4(1.0f), glm::vec3(16.0f)) *
                                                  glm::mat4(many.instances[0].objectToWorld));
    many.instances.pop_back();
    for (int x = -16; x < 16; ++x)
        for (int z = -16; z < 16; ++z)
            many.instances.push_back({.mesh = 1, .objectToWorld = At(kDown, {2 * x + 1, 1, 2 * z + 1})});
    EXPECT_TRUE(HasOwnLight(many));
}

TEST(OwnLight, WhatAnAnimationMakesEmitCountsAtItsBrightest) {
    const auto hasLight = [](const std::vector<float>& factor, const std::vector<float>& strength) {
        scene::SceneData data = FloorAndLamp(0.0f);
        data.materials[1].emissiveStrength = 1.0f;
        if (!factor.empty()) Animate(data, OfMaterial("emissiveFactor", 1), factor);
        if (!strength.empty()) Animate(data, OfMaterial("emissiveStrength", 1), strength);
        return HasOwnLight(data);
    };
    EXPECT_FALSE(hasLight({}, {}));
    EXPECT_FALSE(hasLight({}, {10.0f})) << "its factor stays 0";
    EXPECT_FALSE(hasLight({0.1f, 0.1f, 0.1f}, {}));
    EXPECT_TRUE(hasLight({10.0f, 10.0f, 10.0f}, {}));
    EXPECT_TRUE(hasLight({0.1f, 0.1f, 0.1f}, {100.0f}));
    EXPECT_FALSE(hasLight({0.1f, 0.1f, 0.1f}, {1.0f}));
    // A color that is all but black lights nothing, however large the ceiling is that has it
    scene::SceneData ceiling = FloorAndLamp(0.0f);
    ceiling.materials[1].emissiveStrength = 1.0f;
    ceiling.meshes[1] = QuadMesh(2.0f, 1);
    Animate(ceiling, OfMaterial("emissiveFactor", 1), {1e-4f, 1e-4f, 1e-4f});
    EXPECT_FALSE(HasOwnLight(ceiling));
    // Values of cubic splines are between their tangents
    scene::SceneData spline = FloorAndLamp(0.0f);
    spline.materials[1].emissiveStrength = 1.0f;
    scene::Animation& animation = spline.animations.emplace_back();
    animation.samplers.push_back({.interpolation = scene::Interpolation::CubicSpline,
                                  .width = 3,
                                  .times = {0.0f},
                                  .values = {50, 50, 50, 0, 0, 0, 50, 50, 50}});
    animation.channels.push_back({0, OfMaterial("emissiveFactor", 1)});
    EXPECT_FALSE(HasOwnLight(spline));
    animation.samplers[0].values = {0, 0, 0, 10, 10, 10, 0, 0, 0};
    EXPECT_TRUE(HasOwnLight(spline));
    // An unlit color, likewise
    scene::SceneData unlit = SceneOf({BoxMesh(1.0f)}, {Lambert(glm::vec3(0.0f))});
    unlit.materials[0].isUnlit = true;
    EXPECT_FALSE(HasOwnLight(unlit));
    Animate(unlit, OfMaterial("baseColorFactor", 0), {1, 1, 1, 1});
    EXPECT_TRUE(HasOwnLight(unlit));
}

TEST(OwnLight, ALampThatAnAnimationShowsCounts) {
    scene::SceneData data = FloorAndLamp(10.0f);
    data.nodes.resize(2);
    data.nodeOrder = {0, 1};
    for (uint32_t i = 0; i < 2; ++i) data.instances[i].node = i;
    EXPECT_TRUE(HasOwnLight(data));
    data.nodes[1].isVisible = false;
    EXPECT_FALSE(HasOwnLight(data));
    EXPECT_FALSE(MayHaveOwnLight(data));
    Animate(data, VisibilityOf(0), {1.0f});
    EXPECT_FALSE(HasOwnLight(data)) << "it shows the floor";
    Animate(data, VisibilityOf(1), {0.0f});
    EXPECT_FALSE(HasOwnLight(data));
    Animate(data, VisibilityOf(1), {1.0f});
    EXPECT_TRUE(HasOwnLight(data));
}

TEST(OwnLight, PointsAndLinesThatEmitLight) {
    scene::SceneData data =
        SceneOf({RoundSphere(0.2f, 1, {0, 1, 0}), QuadMesh(2.0f, 0)},
                {Lambert(kGray), Lambert(kGray, glm::vec3(10.0f))}, {glm::mat4x3(1.0f), kUp});
    EXPECT_TRUE(HasOwnLight(data));
    data.meshes[0] = RoundMesh({{-1, 1, 0}, {1, 1, 0}}, {0, 1}, {0.05f}, 1);
    EXPECT_TRUE(HasOwnLight(data));
    data.materials[1].emissiveFactor = glm::vec3(0.0f);
    EXPECT_FALSE(HasOwnLight(data));
}

TEST(OwnLight, TheProjectsScenesWithALampKeepTheirLight) {
    const auto hasLight = [](const std::string& name) {
        return HasOwnLight(scene::LoadGltf(test::SourceFile("scenes/" + name + ".gltf")));
    };
    for (const char* name :
         {"cornell", "closed_box_a50", "small_light", "instanced_field", "many_lights", "terrace"})
        EXPECT_TRUE(hasLight(name)) << name;
    for (const char* name : {"furnace_sphere", "furnace_row", "glass_sphere", "checker_floor", "thin_films"})
        EXPECT_FALSE(hasLight(name)) << name;
}

TEST(OwnLight, PublishedModelsAreLitOrNot) {
    RAYGRAPH_SKIP_WITHOUT_ASSET_SCENES();
    const auto hasLight = [](const char* name) {
        return HasOwnLight(scene::LoadGltf(*test::ReferenceAssets() / "scenes" / name));
    };
    for (const char* name : {"known/CornellBox_bevy.glb", "known/Lights.glb", "known/UnlitTest.glb",
                             "large/bunny_69k.glb", "large/boxes_65536_nodes.glb"})
        EXPECT_TRUE(hasLight(name)) << name;
    for (const char* name : {"known/WaterBottle.glb", "known/FlightHelmet.glb", "known/CesiumMilkTruck.glb"})
        EXPECT_FALSE(hasLight(name)) << name;
}

}  // namespace
}  // namespace raygraph::testing::own_light_test

// The built-in studio: what it does to a gray ball, and when a GpuScene shows it.
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
    // From the same direction, with the ball in the middle
    const glm::dvec3 toEye(-scene::ViewOfBounds(ball.bounds, 1.0f).forward);
    scene::CameraView view = scene::CameraView::LookAt(4.0 * toEye, glm::dvec3(0.0), {0.0f, 1.0f, 0.0f});
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

// Lights with profiles, from the text of a glTF file to what is seen.
namespace raygraph::testing::ies_light_scene_test {

namespace {

using test::GltfDocument;
using test::IesText;
using test::Json;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr glm::vec3 kPlace(0.25f, 2.0f, -0.5f);  // of the light, above the floor

// A white floor at y = 0, and the light of `file` above it, whose -z is down and whose +x is the world's +z.
GltfDocument Floor(const IesText& file) {
    GltfDocument document;
    const size_t positions = document.AddAccessor<float>({-9, 0, 9, 9, 0, 9, 9, 0, -9, -9, 0, -9}, 3);
    const size_t indices = document.AddAccessor<uint16_t>({0, 1, 2, 0, 2, 3}, 1);
    document.AddNode({{"mesh", document.AddMesh({{"attributes", {{"POSITION", positions}}},
                                                 {"indices", indices},
                                                 {"material", document.AddMaterial(Json::object())}})}});
    document.json["extensions"]["EXT_lights_ies"]["lights"] =
        Json::array({{{"uri", test::DataUri(test::ToBytes(file.Text()))}}});
    document.AddNode(
        {{"translation", {kPlace.x, kPlace.y, kPlace.z}},
         {"rotation", {-0.5, -0.5, -0.5, 0.5}},
         {"scale", {2, 0.5, 3}},
         {"extensions", {{"EXT_lights_ies", {{"light", 0}, {"multiplier", 2}, {"color", {1, 0.5, 0.25}}}}}}});
    return document;
}

class IesLightScene : public VulkanTest {
  protected:
    static passes::TraceSettings LookDownAt(const glm::vec3& point) {
        passes::TraceSettings settings;
        settings.extent = {1, 1};
        settings.camera = ToRecord(scene::CameraView::LookAt(point + glm::vec3(0, 1, 0), point, {1, 0, 0}));
        settings.camera.right *= 1e-4f;
        settings.camera.up *= 1e-4f;
        settings.scattering.brdf = BrdfModel::Lambert;
        return settings;
    }
    glm::vec3 Traced(const glm::vec3& point) { return render.TraceOnce(LookDownAt(point)).At(0, 0); }
    glm::vec3 Drawn(const glm::vec3& point, passes::RasterShadows shadows) {
        const passes::TraceSettings settings = LookDownAt(point);
        render.renderer.BeginFrame();
        const SceneIds ids = render.scene.Declare(render.renderer);
        const passes::RasterVisibility seen =
            passes::DrawVisibility(render.renderer, ids, settings, passes::FilmPosition::Center);
        const Readback drawn = render.renderer.ReadBack(
            passes::RasterShade(render.renderer, ids, settings, seen, environment, {.shadows = shadows}));
        render.renderer.Execute();
        return ToFloatImage(drawn).At(0, 0);
    }
    SceneRender render{Device()};
    passes::FilteredEnvironment environment{"environment"};
};

// The radiance of a white floor under I candela: I cos / (pi d^2).
glm::vec3 Expected(const glm::vec3& point, const std::function<double(const glm::dvec3&)>& intensity) {
    const glm::dvec3 way = glm::dvec3(point) - glm::dvec3(kPlace);
    const double distance = glm::length(way);
    const glm::dvec3 own(way.z / distance, way.x / distance, way.y / distance);  // in the light's axes
    const double radiance = intensity(own) * (-way.y / distance) / (std::numbers::pi * distance * distance);
    return glm::vec3(2.0, 1.0, 0.5) * float(radiance);
}

void ExpectNear(const glm::vec3& seen, const glm::vec3& expected, const char* what) {
    EXPECT_LT(glm::distance(seen, expected), 1e-3f * glm::length(expected) + 1e-6f)
        << what << ": " << seen.x << ' ' << seen.y << ' ' << seen.z << " for " << expected.x << ' '
        << expected.y << ' ' << expected.z;
}

constexpr std::array<glm::vec3, 5> kPoints{
    {{0.5f, 0, -0.75f}, {1.0f, 0, -0.5f}, {0.3f, 0, 1.5f}, {-1.5f, 0, -2.0f}, {4.0f, 0, 1.0f}}};

}  // namespace

TEST_F(IesLightScene, IrradianceOnAPlaneIsThatOfTheProfile) {
    const auto c = [](double v, double h) { return (180.0 - v) * (30.0 + h); };
    render.scene.SetScene(
        test::Load(Floor({.vertical = {0, 180}, .horizontal = {0, 90, 180}, .candela = c})));
    const auto intensityC = [&](const glm::dvec3& d) {
        return c(std::acos(-d.z) / kDegree, std::atan2(std::abs(d.y), d.x) / kDegree);
    };
    for (const glm::vec3& point : kPoints) {
        const glm::vec3 expected = Expected(point, intensityC);
        ExpectNear(Traced(point), expected, "traced");
        ExpectNear(Drawn(point, passes::RasterShadows::Off), expected, "drawn");
        ExpectNear(Drawn(point, passes::RasterShadows::Maps), expected, "drawn with shadow maps");
    }
    // Horizontal angles are clockwise: positive ones towards the light's -y
    const auto b = [](double v, double h) { return 1000.0 + 5.0 * v + 3.0 * h; };
    render.scene.SetScene(
        test::Load(Floor({.type = 2, .vertical = {-90, 0, 90}, .horizontal = {-90, 90}, .candela = b})));
    const auto intensityB = [&](const glm::dvec3& d) {
        return b(std::atan2(d.x, -d.z) / kDegree, std::asin(-d.y) / kDegree);
    };
    for (const glm::vec3& point : kPoints) {
        ExpectNear(Traced(point), Expected(point, intensityB), "traced, type B");
        ExpectNear(Drawn(point, passes::RasterShadows::Off), Expected(point, intensityB), "drawn, type B");
    }
}

TEST_F(IesLightScene, EditsOfColorAndFactorShowAndOthersAreRefused) {
    render.scene.SetEnvironment({});
    const IesText file{.vertical = {0, 90}, .candela = [](double, double) { return 50.0; }};
    render.scene.SetScene(test::Load(Floor(file)));
    const auto constant = [](const glm::dvec3&) { return 50.0; };
    const glm::vec3 expected = Expected(kPoints[1], constant);
    ExpectNear(Traced(kPoints[1]), expected, "as in the file");
    scene::Light light = render.scene.Light(0);
    EXPECT_EQ(light.profile, 0u);
    light.intensity = 1.0f;
    light.color = {0.5f, 0.5f, 0.25f};
    render.scene.SetLight(0, light);
    ExpectNear(Traced(kPoints[1]), expected * glm::vec3(0.25f, 0.5f, 0.5f), "edited");
    light.profile = 1;
    EXPECT_THROW(render.scene.SetLight(0, light), Error);
    light.profile = scene::kNone;  // a point light of 1 cd
    render.scene.SetLight(0, light);
    ExpectNear(Traced(kPoints[1]), expected * glm::vec3(0.25f, 0.5f, 0.5f) / 50.0f, "without the profile");
    // The next scene has no profile
    GltfDocument plain = Floor(file);
    plain.json["nodes"][1].erase("extensions");
    render.scene.SetScene(test::Load(plain));
    EXPECT_EQ(Traced(kPoints[1]), glm::vec3(0.0f));
}

}  // namespace raygraph::testing::ies_light_scene_test
