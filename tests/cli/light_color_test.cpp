// Tests the color of a scene's light against closed forms.
#include "editor/session/settings/light_settings.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace raygraph::session::light_color_test {
namespace {

using std::numbers::pi;

void ExpectColor(const std::optional<glm::dvec3>& color, const glm::dvec3& expected) {
    ASSERT_TRUE(color.has_value());
    for (int c = 0; c < 3; ++c) EXPECT_NEAR((*color)[c], expected[c], 1e-6 * (1.0 + expected[c])) << c;
}

// Makes a square of side 2, scaled by 3, that emits (1, 2, 4) on one side.
SceneInput Square() {
    SceneInput input;
    scene::SceneData& scene = input.data;
    scene.materials.push_back({.emissiveFactor = {0.5f, 1.0f, 2.0f}, .emissiveStrength = 2.0f});
    scene::Primitive& primitive = scene.meshes.emplace_back().primitives.emplace_back();
    primitive.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    primitive.indices = {0, 1, 2, 0, 2, 3};
    primitive.bounds = {{-1, -1, 0}, {1, 1, 0}};
    scene.instances.emplace_back().objectToWorld[0] = {3, 0, 0};
    scene.instances[0].objectToWorld[1] = {0, 3, 0};
    scene.instances[0].objectToWorld[2] = {0, 0, 3};
    scene.bounds = {{-3, -3, 0}, {3, 3, 0}};
    return input;
}
constexpr double kRadius2 = 18.0;  // squared radius of these bounds

TEST(LightColor, OfSurfaces) {
    SceneInput input = Square();
    const double power = pi * 36.0;
    ExpectColor(LightColor(input, {}), power * glm::dvec3(1, 2, 4));
    input.data.materials[0].isDoubleSided = true;
    ExpectColor(LightColor(input, {}), 2.0 * power * glm::dvec3(1, 2, 4));
    // One texture has a white and a black texel, and the image of another is half as bright: the mean is in
    // linear light
    input.data.materials[0].isDoubleSided = false;
    input.data.materials[0].emissiveTexture.texture = 0;
    input.data.textures.push_back({.image = 0, .colorSpace = scene::ColorSpace::Srgb});
    input.data.images.push_back({.width = 2, .height = 1, .rgba = {255, 255, 0, 255, 0, 188, 0, 0}});
    const double half = std::pow((188.0 / 255.0 + 0.055) / 1.055, 2.4);
    EXPECT_NEAR(half, 0.5, 5e-3);
    ExpectColor(LightColor(input, {}), power * glm::dvec3(0.5, 2.0 * (1.0 + half) / 2.0, 0.0));
    input.data.materials[0].isUnlit = true;
    EXPECT_FALSE(LightColor(input, {})) << "a picture, and no lamp";
}

TEST(LightColor, OfRoundPrimitivesThatAreScaled) {
    SceneInput input = Square();
    scene::Primitive& sphere = input.data.meshes[0].primitives[0];
    sphere.positions = {{0, 0, 0}};
    sphere.indices = {0, 0};
    sphere.radii = {0.5f};
    sphere.bounds = {{-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f}};
    const PictureSettings dark{.light = DefaultLight::None};
    ExpectColor(LightColor(input, dark), pi * 4.0 * pi * 1.5 * 1.5 * glm::dvec3(1, 2, 4));
    // A sphere flattened to a disc has two sides, with a total area of 2 pi r^2
    input.data.instances[0].objectToWorld[2] = {0, 0, 1e-4f};
    const std::optional<glm::dvec3> disc = LightColor(input, dark);
    ASSERT_TRUE(disc);
    EXPECT_NEAR(disc->x, pi * 2.0 * pi * 1.5 * 1.5, 0.2 * pi * 2.0 * pi * 1.5 * 1.5);
}

TEST(LightColor, WhatIsHiddenDoesNotShine) {
    SceneInput input = Square();
    const PictureSettings dark{.light = DefaultLight::None};
    input.data.nodes.emplace_back().isVisible = false;
    input.data.nodeOrder = {0};
    input.data.instances[0].node = 0;
    scene::Light& light = input.data.lights.emplace_back();
    light.node = 0;
    EXPECT_FALSE(LightColor(input, dark));
    input.data.nodes[0].isVisible = true;
    light.color = {1, 0, 0};
    light.intensity = 2.0f;
    const glm::dvec3 surfaces = pi * 36.0 * glm::dvec3(1, 2, 4);
    ExpectColor(LightColor(input, dark), surfaces + glm::dvec3(8.0 * pi, 0, 0));
    PictureSettings settings;
    settings.paths.lights.isOn = false;  // lights are not rendered then
    ExpectColor(LightColor(input, settings), surfaces);
}

TEST(LightColor, OfPunctualLights) {
    SceneInput input = Square();
    input.data.materials[0].emissiveFactor = glm::vec3(0.0f);
    scene::Light& light = input.data.lights.emplace_back();
    light.color = {1, 2, 3};
    light.intensity = 5.0f;
    light.type = scene::LightType::Directional;
    ExpectColor(LightColor(input, {}), pi * kRadius2 * 5.0 * glm::dvec3(1, 2, 3));
    light.type = scene::LightType::Spot;
    light.innerConeAngle = 0.5f;
    light.outerConeAngle = 0.7f;
    // Integrates over the cosine by the midpoint rule
    const double outer = std::cos(double{0.7f}), scale = 1.0 / (std::cos(double{0.5f}) - outer);
    double integral = 0.0;
    constexpr int kSteps = 200000;
    for (int i = 0; i < kSteps; ++i) {
        const double c = outer + (1.0 - outer) * (i + 0.5) / kSteps;
        const double falloff = std::min((c - outer) * scale, 1.0);
        integral += falloff * falloff * (1.0 - outer) / kSteps;
    }
    ExpectColor(LightColor(input, {}), 2.0 * pi * integral * 5.0 * glm::dvec3(1, 2, 3));
}

TEST(LightColor, OfTheEnvironment) {
    SceneInput input = Square();
    input.data.materials[0].emissiveFactor = glm::vec3(0.0f);
    PictureSettings settings;
    settings.background = {{0.5f, 1.0f, 2.0f}};
    const double share = 4.0 * pi * pi * kRadius2;
    ExpectColor(LightColor(input, settings), share * glm::dvec3(0.5, 1.0, 2.0));
    // A map replaces the background. The middle one of three rows is twice as long as each other: sin 90 and
    // 30 degrees
    input.environment = {1, 3, {0, 0, 0, 1, 4, 2, 0, 1, 0, 8, 0, 1}};
    settings.environmentTint = {1.0f, 0.5f, 1.0f};
    ExpectColor(LightColor(input, settings), share * glm::dvec3(2.0, 0.5 * (1.0 + 2.0), 0.0));
    // The scene's own map
    input.data.environment.map = input.environment;
    input.environment = {};
    ExpectColor(LightColor(input, settings), share * glm::dvec3(0.5, 1.0, 2.0));
    settings.background.reset();
    ExpectColor(LightColor(input, settings), share * glm::dvec3(2.0, 1.5, 0.0));
}

}  // namespace
}  // namespace raygraph::session::light_color_test
