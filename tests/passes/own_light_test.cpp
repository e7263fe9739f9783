// Which scenes have light of their own, and which are black without the studio.
#include "renderer/gpu_scene/own_light.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "renderer/scene/load_gltf.h"
#include "renderer/scene/material_fields.h"
#include "tests/support/reference_assets.h"
#include "tests/support/scene_render.h"
#include "tests/support/source_file.h"

namespace raygraph::testing {
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

TEST(OwnLight, ASceneWithoutLightHasNone) {
    EXPECT_FALSE(HasOwnLight({}));
    EXPECT_FALSE(HasOwnLight(SceneOf({BoxMesh(1.0f)}, {Lambert(kGray)})));
}

TEST(OwnLight, APunctualLightCountsIfItShinesOrAnAnimationMayMakeItShine) {
    scene::SceneData data = SceneOf({BoxMesh(1.0f)}, {Lambert(kGray)});
    data.nodes.resize(1);
    data.nodeOrder = {0};
    data.lights = {Bulb(1.0f)};
    data.lights[0].node = 0;
    EXPECT_TRUE(HasOwnLight(data));
    data.nodes[0].isVisible = false;
    EXPECT_FALSE(HasOwnLight(data));
    scene::Animation& animation = data.animations.emplace_back();
    animation.samplers.push_back({.times = {0.0f}, .values = {1.0f}});
    animation.channels.push_back({0, {scene::AnimatedProperty::Translation}});
    EXPECT_FALSE(HasOwnLight(data)) << "what moves the node turns no light on";
    animation.channels.push_back({0, {scene::AnimatedProperty::Visibility}});
    EXPECT_TRUE(HasOwnLight(data));
    data.nodes[0].isVisible = true;
    data.animations.clear();
    data.lights = {Bulb(0.0f)};
    EXPECT_FALSE(HasOwnLight(data));
    data.animations.emplace_back().channels.push_back({0, {scene::AnimatedProperty::LightField}});
    EXPECT_TRUE(HasOwnLight(data));
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
                    instance.translationRest = instance.objectToWorld[3];
                    instance.objectToWorld[3] = place;
                    data.bounds.Extend(place);
                }
                EXPECT_EQ(HasOwnLight(data), isLit) << unit << " " << place.x;
            }
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

TEST(OwnLight, WhatAnAnimationMakesEmitCounts) {
    scene::SceneData data = FloorAndLamp(0.0f);
    data.materials[1].emissiveStrength = 1.0f;
    scene::Animation& animation = data.animations.emplace_back();
    animation.samplers.push_back({.width = 3, .times = {0.0f, 1.0f}, .values = {0, 0, 0, 9, 9, 9}});
    uint8_t index = 0;
    scene::ForEachMaterialField([&](const auto& field) {
        const uint8_t its = index++;
        if (std::string_view(field.name) == "emissiveFactor")
            animation.channels.push_back({0, {scene::AnimatedProperty::MaterialField, its, 1}});
    });
    ASSERT_EQ(animation.channels.size(), 1u);
    // Taken as 1, which is little for a small lamp, and much for a ceiling
    EXPECT_FALSE(HasOwnLight(data));
    data.meshes[1] = QuadMesh(2.0f, 1);
    EXPECT_TRUE(HasOwnLight(data));
    animation.channels.clear();
    EXPECT_FALSE(HasOwnLight(data));
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
}  // namespace raygraph::testing
