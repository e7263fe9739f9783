// Which scenes have light of their own, and which are black without the studio.
#include "renderer/gpu_scene/lights/own_light.h"

#include <gtest/gtest.h>

#include <array>
#include <glm/gtc/matrix_transform.hpp>
#include <string_view>

#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/light_fields.h"
#include "renderer/scene/model/material_fields.h"
#include "tests/support/reference_assets.h"
#include "tests/support/scene_render.h"
#include "tests/support/source_file.h"

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
