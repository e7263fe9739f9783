// Animations: interpolation, pointers, broken keys, and published files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <vector>

#include "renderer/scene/animation/animation.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/animation/pose.h"
#include "renderer/scene/gltf/still_scene.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/scene_fields.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/reference_assets.h"

// The value of an animation's sampler at a time, against values computed by hand.
namespace raygraph::scene::animation_test {
namespace {

double Number(const AnimationSampler& sampler, double seconds, uint32_t interval = 0) {
    double value = 0.0;
    SampleAnimation(sampler, seconds, false, interval, &value);
    return value;
}

using Rotation = std::array<double, 4>;
Rotation RotationAt(const AnimationSampler& sampler, double seconds) {
    Rotation value{};
    uint32_t interval = 0;
    SampleAnimation(sampler, seconds, true, interval, value.data());
    return value;
}

// x, y, z, w of a turn about +z.
std::array<float, 4> AboutZ(double radians) {
    return {0, 0, float(std::sin(radians / 2)), float(std::cos(radians / 2))};
}
AnimationSampler Turns(std::vector<double> angles) {
    AnimationSampler sampler{.width = 4, .times = {}, .values = {}};
    for (const double angle : angles) {
        sampler.times.push_back(float(sampler.times.size()));
        const std::array<float, 4> key = AboutZ(angle);
        sampler.values.insert(sampler.values.end(), key.begin(), key.end());
    }
    return sampler;
}
double AngleOf(const Rotation& q) {
    return 2.0 * std::atan2(q[2], q[3]);
}

TEST(AnimationSampler, LinearIsStraightBetweenItsKeysAndHeldOutside) {
    const AnimationSampler sampler{.times = {1, 2, 4}, .values = {10, 20, 0}};
    EXPECT_EQ(Number(sampler, -5), 10);
    EXPECT_EQ(Number(sampler, 1), 10);
    EXPECT_DOUBLE_EQ(Number(sampler, 1.25), 12.5);
    EXPECT_EQ(Number(sampler, 2), 20);
    EXPECT_DOUBLE_EQ(Number(sampler, 2.5), 15);
    EXPECT_EQ(Number(sampler, 4), 0);
    EXPECT_EQ(Number(sampler, 1e9), 0);
    EXPECT_EQ(Number(sampler, std::numeric_limits<double>::quiet_NaN()), 10);
    EXPECT_EQ(Number(sampler, std::numeric_limits<double>::infinity()), 0);
}

TEST(AnimationSampler, StepHoldsTheKeyBefore) {
    const AnimationSampler sampler{
        .interpolation = Interpolation::Step, .times = {1, 2, 4}, .values = {10, 20, 0}};
    EXPECT_EQ(Number(sampler, 1.999), 10);
    EXPECT_EQ(Number(sampler, 2), 20);
    EXPECT_EQ(Number(sampler, 3.999), 20);
    EXPECT_EQ(Number(sampler, 4), 0);
}

// p(t) of appendix C.5 with p0 = 1, m0 = 2 * 3, p1 = 5, m1 = 2 * (-4), over an interval of 2 s. At t = 1/4:
// h00 = 27/32, h10 = 9/64, h01 = 5/32, h11 = -3/64.
TEST(AnimationSampler, CubicSplineScalesItsTangentsByTheInterval) {
    const AnimationSampler sampler{
        .interpolation = Interpolation::CubicSpline, .times = {10, 12}, .values = {99, 1, 3, -4, 5, 77}};
    const double expected = 27.0 / 32 * 1 + 9.0 / 64 * 6 + 5.0 / 32 * 5 - 3.0 / 64 * -8;
    EXPECT_DOUBLE_EQ(Number(sampler, 10.5), expected);
    // Values, not tangents, at the ends and outside
    EXPECT_EQ(Number(sampler, 10), 1);
    EXPECT_EQ(Number(sampler, 12), 5);
    EXPECT_EQ(Number(sampler, 0), 1);
    EXPECT_EQ(Number(sampler, 20), 5);
    // The slopes at the ends are the tangents, per second
    EXPECT_NEAR((Number(sampler, 10 + 1e-6) - 1) / 1e-6, 3, 1e-4);
    EXPECT_NEAR((5 - Number(sampler, 12 - 1e-6)) / 1e-6, -4, 1e-4);
}

TEST(AnimationSampler, CubicSplineTakesEachKeysOwnTriple) {
    const AnimationSampler sampler{.interpolation = Interpolation::CubicSpline,
                                   .width = 2,
                                   .times = {0, 1, 2},
                                   .values = {0, 0, 1, 2, 0, 0, 0, 0, 3, 4, 0, 0, 0, 0, 5, 6, 0, 0}};
    double value[2];
    uint32_t interval = 0;
    SampleAnimation(sampler, 1.5, false, interval, value);
    EXPECT_DOUBLE_EQ(value[0], 4);
    EXPECT_DOUBLE_EQ(value[1], 5);
}

TEST(AnimationSampler, RotationsTurnAtConstantSpeed) {
    const AnimationSampler sampler = Turns({0.0, 2.0});
    for (const double share : {0.1, 0.25, 0.5, 0.9})
        EXPECT_NEAR(AngleOf(RotationAt(sampler, share)), 2.0 * share, 1e-6) << share;
}

TEST(AnimationSampler, RotationsTakeTheShorterArc) {
    // A turn by 3 and one by -3 are 0.28 apart, through pi; the second key with all signs changed is the same
    const AnimationSampler sampler = Turns({3.0, -3.0});
    const double half = AngleOf(RotationAt(sampler, 0.5));
    EXPECT_NEAR(std::abs(half), M_PI, 1e-6);
    AnimationSampler other = Turns({0.0, 1.0});
    for (size_t i = 4; i < 8; ++i) other.values[i] = -other.values[i];
    EXPECT_NEAR(AngleOf(RotationAt(other, 0.5)), 0.5, 1e-6);
}

TEST(AnimationSampler, RotationsHaveUnitLength) {
    AnimationSampler cubic{
        .interpolation = Interpolation::CubicSpline,
        .width = 4,
        .times = {0, 1},
        .values = {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0}};
    const Rotation q = RotationAt(cubic, 0.5);
    EXPECT_NEAR(q[2] * q[2] + q[3] * q[3], 1.0, 1e-12);
    // 0.5 * w + (0.5 + 0.125 * 3) * z, normalized
    EXPECT_NEAR(q[2] / q[3], 0.875 / 0.5, 1e-6);
    AnimationSampler held = Turns({0.5});
    for (float& value : held.values) value *= 3.0f;
    EXPECT_NEAR(AngleOf(RotationAt(held, 0.0)), 0.5, 1e-6);
    EXPECT_NEAR(RotationAt(held, 0.0)[3], std::cos(0.25), 1e-6);
}

// Opposite keys whose spline passes through 0 have no rotation there: the one before is kept, without NaN.
TEST(AnimationSampler, SplineThroughNothingKeepsTheKey) {
    const AnimationSampler sampler{
        .interpolation = Interpolation::CubicSpline,
        .width = 4,
        .times = {0, 1},
        .values = {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0}};
    EXPECT_EQ(RotationAt(sampler, 0.5), (Rotation{0, 0, 0, 1}));
}

// The value does not depend on the previous time.
TEST(AnimationSampler, RememberedIntervalIsOnlyAHint) {
    AnimationSampler sampler{.times = {}, .values = {}};
    for (int i = 0; i < 100; ++i) {
        sampler.times.push_back(float(i * i));
        sampler.values.push_back(float(i));
    }
    uint32_t interval = 0;
    for (int step = 0; step < 2000; ++step) {
        const double seconds = (step * 7919 % 2000) * 4.9;
        double value = 0.0;
        SampleAnimation(sampler, seconds, false, interval, &value);
        const double root = std::floor(std::sqrt(seconds));
        EXPECT_NEAR(value, root + (seconds - root * root) / (2 * root + 1), 1e-9) << seconds;
        EXPECT_EQ(value, Number(sampler, seconds, uint32_t(step % 120)));
    }
}

}  // namespace
}  // namespace raygraph::scene::animation_test

// KHR_animation_pointer: what each pointer moves, and which are none.
namespace raygraph::test::animation_pointer_test {
namespace {

using glm::vec2;
using glm::vec3;

// A triangle with a material and two targets; a perspective camera placed twice, an orthographic one, a spot
// light placed twice and a sun.
GltfDocument Everything() {
    GltfDocument document;
    Json& primitive = document.AddTriangle();
    primitive["material"] = document.AddMaterial({{"name", "first"}});
    const size_t lifted = document.AddAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
    primitive["targets"] = {{{"POSITION", lifted}}, {{"POSITION", lifted}}};
    document.AddMaterial({{"extensions", {{"KHR_materials_pbrSpecularGlossiness", Json::object()}}}});
    document.Add("cameras", {{"type", "orthographic"},
                             {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"zfar", 9}, {"znear", 0}}}});
    document.Add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}});
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "directional"}}, {{"type", "spot"}, {"spot", Json::object()}}};
    for (const int i : {1, 0, 1})
        document.AddNode({{"camera", i}, {"extensions", {{"KHR_lights_punctual", {{"light", i}}}}}});
    return document;
}

// The scene at the end of an animation that sets what the pointer says.
scene::SceneData Set(const std::string& pointer, const std::vector<float>& value,
                     GltfDocument document = Everything()) {
    const size_t components = pointer.ends_with("weights") ? 1 : value.size();
    std::vector<float> values(value.size(), 0.5f);
    if (pointer.ends_with("rotation") && value.size() == 4) values = {0, 0, 0, 1};
    values.insert(values.end(), value.begin(), value.end());
    Animate(document, Pointer(pointer), {0, 1}, values, components);
    scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
    scene::PoseEvaluator evaluator(scene);
    scene::PoseApplier applier(scene);
    applier.Apply(scene, evaluator.Evaluate(scene, std::array{scene::ClipState{0, 1}}));
    return scene;
}

TEST(AnimationPointer, MovesNodes) {
    EXPECT_EQ(Set("/nodes/0/translation", {1, 2, 3}).nodes[0].translation, vec3(1, 2, 3));
    EXPECT_EQ(Set("/nodes/0/scale", {1, 2, 3}).nodes[0].scale, vec3(1, 2, 3));
    EXPECT_EQ(Set("/nodes/0/rotation", {0, 1, 0, 0}).nodes[0].rotation, glm::quat(0, 0, 1, 0));
    EXPECT_EQ(Set("/nodes/0/weights", {3, 4}).nodes[0].weights, (std::vector<float>{3, 4}));
    EXPECT_EQ(Set("/nodes/0/weights/1", {4}).nodes[0].weights, (std::vector<float>{0, 4}));
}

// Nodes that have weights of their own keep them.
TEST(AnimationPointer, MovesTheWeightsOfMeshes) {
    const scene::SceneData scene = Set("/meshes/0/weights", {3, 4});
    EXPECT_EQ(scene.meshes[0].weights, (std::vector<float>{3, 4}));
    EXPECT_TRUE(scene.nodes[0].weights.empty());
    EXPECT_EQ(Set("/meshes/0/weights/0", {3}).meshes[0].weights, (std::vector<float>{3, 0}));
    GltfDocument document = Everything();
    document.AddNode({{"mesh", 0}, {"weights", {5, 6}}});
    Animate(document, Pointer("/meshes/0/weights"), {0, 1}, {0, 0, 3, 4}, 1);
    scene::SceneData own = Load(document);
    ASSERT_EQ(own.instances.size(), 2u);
    scene::PoseEvaluator evaluator(own);
    scene::PoseApplier applier(own);
    const scene::PoseChanges& changes =
        applier.Apply(own, evaluator.Evaluate(own, std::array{scene::ClipState{0, 1}}));
    EXPECT_EQ(own.nodes[4].weights, (std::vector<float>{5, 6}));
    const uint32_t plain = own.instances[0].node == 0 ? 0 : 1;
    EXPECT_EQ(changes.reweighted, std::vector<uint32_t>{plain});
    EXPECT_EQ(own.bounds.max.z, 11.0f) << "the greater of 3 + 4 and 5 + 6";
}

// Limits what a small file can make an evaluator store: a pointer to the weights of a mesh is one property,
// however often the mesh is placed.
TEST(AnimationPointer, WeightsOfAMeshAreOneProperty) {
    GltfDocument document = Everything();
    for (int i = 0; i < 300; ++i) document.AddNode({{"mesh", 0}});
    Animate(document, Pointer("/meshes/0/weights"), {0, 1}, {0, 0, 3, 4}, 1);
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.animations[0].channels.size(), 1u);
    scene::PoseEvaluator evaluator(scene);
    EXPECT_EQ(evaluator.Rest().properties.size(), 1u);
    EXPECT_EQ(evaluator.Rest().values.size(), 2u);
}

// Each node's weights are numbers of their own, and charged.
TEST(AnimationPointer, WeightsOfManyNodesAreCharged) {
    constexpr size_t kNodes = 300, kTargets = 1000;
    GltfDocument document;
    Json& primitive = document.AddTriangle();
    const size_t lifted = document.AddAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
    primitive["targets"] = Json::array();
    for (size_t i = 0; i < kTargets; ++i) primitive["targets"].push_back({{"POSITION", lifted}});
    Animate(document, {{"node", 0}, {"path", "weights"}}, {0}, std::vector<float>(kTargets, 1.0f), 1);
    scene::LoadOptions options;
    options.limits.maxGeometryBytes = uint64_t{1} << 20;
    EXPECT_EQ(LoadError(document, options), "loaded");
    for (size_t i = 1; i <= kNodes; ++i) {
        document.AddNode({{"mesh", 0}});
        document.json["animations"][0]["channels"].push_back(
            {{"sampler", 0}, {"target", {{"node", i}, {"path", "weights"}}}});
    }
    EXPECT_EQ(LoadError(document, options).find("scene.gltf: animations[0].channels["), 0u);
    EXPECT_NE(LoadError(document, options).find("].target: decoded geometry exceeds the limit of "),
              std::string::npos);
}

TEST(AnimationPointer, HidesNodes) {
    GltfDocument document = Everything();
    const size_t input = document.AddAccessor<float>({0, 1}, 1);
    const size_t output = document.AddAccessor<uint8_t>({1, 0}, 1);
    AddAnimation(document, input, output, Pointer("/nodes/0/extensions/KHR_node_visibility/visible"), "STEP");
    scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    scene::PoseEvaluator evaluator(scene);
    scene::PoseApplier applier(scene);
    applier.Apply(scene, evaluator.Evaluate(scene, std::array{scene::ClipState{0, 0.99}}));
    EXPECT_TRUE(scene.nodes[0].isVisible);
    applier.Apply(scene, evaluator.Evaluate(scene, std::array{scene::ClipState{0, 1}}));
    EXPECT_FALSE(scene.nodes[0].isVisible);
    document.json["animations"][0]["samplers"][0]["interpolation"] = "LINEAR";
    scene = Load(document);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_EQ(scene.animations[0].samplers[0].interpolation, scene::Interpolation::Step);
}

// The place of a field in the file.
template <typename Field>
std::string PathOf(const Field& field) {
    std::string key = field.key;
    std::replace(key.begin(), key.end(), '.', '/');
    const std::string object = field.object;
    const std::string prefix = object.empty()               ? ""
                               : object.starts_with("KHR_") ? "extensions/" + object + "/"
                                                            : object + "/";
    return prefix + key;
}

// Numbers of a field's type, in its range.
std::vector<float> Values(const scene::FieldRange& range, size_t count) {
    std::vector<float> values;
    for (size_t i = 0; i < count; ++i)
        values.push_back(std::clamp(0.75f + 0.125f * float(i % 2), range.min, range.max));
    return values;
}
template <std::same_as<float> T>
std::vector<float> NumbersOf(T value) {
    return {value};
}
template <int Length>
std::vector<float> NumbersOf(const glm::vec<Length, float>& value) {
    return {&value[0], &value[0] + Length};
}

TEST(AnimationPointer, MovesEveryNumberOfAMaterial) {
    size_t count = 0;
    scene::ForEachMaterialField([&](const auto& field) {
        using Value = typename std::decay_t<decltype(field)>::Value;
        if constexpr (requires(Value value) { NumbersOf(value); }) {
            const std::vector<float> values = Values(field.range, NumbersOf(Value{}).size());
            const scene::SceneData scene = Set("/materials/0/" + PathOf(field), values);
            EXPECT_EQ(NumbersOf(scene.materials[0].*field.member), values) << field.name;
            ++count;
        }
    });
    EXPECT_GE(count, size_t{30});
}

TEST(AnimationPointer, MovesTheTransformOfEveryTexture) {
    size_t count = 0;
    scene::ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<std::decay_t<decltype(field)>, scene::TextureField>) {
            const std::string path = "/materials/0/" + PathOf(field) + "/extensions/KHR_texture_transform/";
            const auto transform = [&](const char* key, const std::vector<float>& value) {
                return (Set(path + key, value).materials[0].*field.member).transform;
            };
            EXPECT_EQ(transform("offset", {3, 4}).offset, vec2(3, 4)) << field.name;
            EXPECT_EQ(transform("rotation", {3}).rotation, 3.0f) << field.name;
            EXPECT_EQ(transform("scale", {3, 4}).scale, vec2(3, 4)) << field.name;
            ++count;
        }
    });
    EXPECT_GE(count, size_t{18});
}

TEST(AnimationPointer, MovesFlagsOfMaterials) {
    GltfDocument document = Everything();
    const size_t input = document.AddAccessor<float>({0, 1}, 1);
    AddAnimation(document, input, document.AddAccessor<uint8_t>({0, 9}, 1),
                 Pointer("/materials/0/doubleSided"), "STEP");
    scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    scene::PoseEvaluator evaluator(scene);
    scene::PoseApplier applier(scene);
    applier.Apply(scene, evaluator.Evaluate(scene, std::array{scene::ClipState{0, 1}}));
    EXPECT_TRUE(scene.materials[0].isDoubleSided);
}

// The file has 1 minus the roughness there, and no place for what the extension replaces.
TEST(AnimationPointer, GlossinessIsOneMinusRoughness) {
    const std::string extension = "/materials/1/extensions/KHR_materials_pbrSpecularGlossiness/";
    EXPECT_EQ(Set(extension + "glossinessFactor", {0.75f}).materials[1].roughnessFactor, 0.25f);
    EXPECT_EQ(Set(extension + "diffuseFactor", {0.5f, 0.25f, 0, 1}).materials[1].baseColorFactor,
              glm::vec4(0.5f, 0.25f, 0, 1));
    EXPECT_EQ(Set(extension + "specularFactor", {0.5f, 0.25f, 0}).materials[1].specularColorFactor,
              vec3(0.5f, 0.25f, 0));
}

TEST(AnimationPointer, MovesAllCamerasMadeOfTheFilesOne) {
    // Pointers of camera 0 come first
    const scene::SceneData wide = Set("/cameras/1/perspective/yfov", {2});
    ASSERT_EQ(wide.cameras.size(), 3u);
    EXPECT_EQ(wide.cameras[1].yFov, 2.0f);
    EXPECT_EQ(wide.cameras[2].yFov, 2.0f);
    EXPECT_EQ(wide.cameras[0].yFov, 0.8f);
    EXPECT_EQ(Set("/cameras/1/perspective/aspectRatio", {2}).cameras[1].aspectRatio, 2.0f);
    EXPECT_EQ(Set("/cameras/1/perspective/znear", {2}).cameras[1].zNear, 2.0f);
    EXPECT_EQ(Set("/cameras/1/perspective/zfar", {2}).cameras[1].zFar, 2.0f);
    EXPECT_EQ(Set("/cameras/0/orthographic/xmag", {2}).cameras[0].xMag, 2.0f);
    EXPECT_EQ(Set("/cameras/0/orthographic/ymag", {2}).cameras[0].yMag, 2.0f);
    EXPECT_EQ(Set("/cameras/0/orthographic/znear", {2}).cameras[0].zNear, 2.0f);
    EXPECT_EQ(Set("/cameras/0/orthographic/zfar", {2}).cameras[0].zFar, 2.0f);
}

TEST(AnimationPointer, MovesAllLightsMadeOfTheFilesOne) {
    const std::string lights = "/extensions/KHR_lights_punctual/lights/";
    const scene::SceneData red = Set(lights + "1/color", {1, 0, 0});
    ASSERT_EQ(red.lights.size(), 3u);
    EXPECT_EQ(red.lights[0].color, vec3(1));
    EXPECT_EQ(red.lights[1].color, vec3(1, 0, 0));
    EXPECT_EQ(red.lights[2].color, vec3(1, 0, 0));
    EXPECT_EQ(Set(lights + "0/intensity", {7}).lights[0].intensity, 7.0f);
    EXPECT_EQ(Set(lights + "1/range", {7}).lights[1].range, 7.0f);
    EXPECT_EQ(Set(lights + "1/spot/innerConeAngle", {0.25f}).lights[1].innerConeAngle, 0.25f);
    EXPECT_EQ(Set(lights + "1/spot/outerConeAngle", {1}).lights[1].outerConeAngle, 1.0f);
}

// A picture with --at shows such a scene.
TEST(AnimationPointer, ShowsInAFrozenScene) {
    GltfDocument document = Everything();
    document.json["extensionsUsed"] = {"KHR_animation_pointer"};
    document.json["extensionsRequired"] = {"KHR_animation_pointer"};
    Animate(document, Pointer("/materials/0/emissiveFactor"), {0, 1}, {0, 0, 0, 1, 0.5f, 0}, 3);
    scene::SceneData scene = Load(document);
    scene::FreezePose(scene, scene::FindClips(scene, "", 0.5));
    EXPECT_EQ(scene.materials[0].emissiveFactor, vec3(0.5f, 0.25f, 0));
    EXPECT_TRUE(scene.animations.empty());
}

TEST(AnimationPointer, NumbersMayBeIntegers) {
    GltfDocument document = Everything();
    const size_t input = document.AddAccessor<float>({0}, 1);
    AddAnimation(document, input, document.AddAccessor<uint8_t>({3}, 1),
                 Pointer("/extensions/KHR_lights_punctual/lights/0/intensity"));
    AddAnimation(document, input, document.AddAccessor<uint16_t>({65535, 0, 13107}, 3, true),
                 Pointer("/materials/0/emissiveFactor"));
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.animations[0].samplers[0].values, std::vector<float>{3});
    EXPECT_EQ(scene.animations[1].samplers[0].values, (std::vector<float>{1, 0, 0.2f}));
}

// A property is one target, with and without a pointer.
TEST(AnimationPointer, IsTheTargetItPointsAt) {
    GltfDocument document = Everything();
    Animate(document, {{"node", 0}, {"path", "translation"}}, {0}, {1, 2, 3}, 3);
    document.json["animations"][0]["channels"].push_back(
        {{"sampler", 0}, {"target", Pointer("/nodes/0/translation")}});
    EXPECT_EQ(Load(document).warnings.size(), 1u);
    EXPECT_EQ(Load(document).animations[0].channels.size(), 1u);
    Animate(document, Pointer("/nodes/0/weights/1"), {0}, {1}, 1);
    document.json["animations"][1]["samplers"].push_back(
        {{"input", document.AddAccessor<float>({0}, 1)}, {"output", document.AddAccessor<float>({1, 2}, 1)}});
    document.json["animations"][1]["channels"].push_back(
        {{"sampler", 1}, {"target", Pointer("/nodes/0/weights")}});
    EXPECT_EQ(Load(document).animations[1].channels.size(), 1u) << "a weight, and all of them";
}

TEST(AnimationPointer, WhatIsNotReadGivesOneWarning) {
    const char* pointers[] = {"/nodes/0/name",
                              "/nodes/0",
                              "/nodes",
                              "/asset/version",
                              "/nodes/0/translation/0",
                              "/materials/0/alphaMode",
                              "/materials/0/extras/priority",
                              "/materials/0/extensions/KHR_materials_unlit",
                              "/materials/0/extensions/KHR_materials_unlit/",
                              "/materials/0/normalTexture",
                              "/materials/0/normalTexture/texCoord",
                              "/materials/0/normalTexture/extensions/KHR_texture_transform/texCoord",
                              "/materials/1/pbrMetallicRoughness/metallicFactor",
                              "/materials/0/extensions/KHR_materials_pbrSpecularGlossiness/glossinessFactor",
                              "/cameras/0/perspective/yfov",
                              "/extensions/KHR_lights_punctual/lights/0/range",
                              "/extensions/KHR_lights_punctual/lights/0/spot/innerConeAngle",
                              "/extensions/EXT_lights_ies/lights/0/multiplier",
                              "/no~1th~0ing"};
    GltfDocument document = Everything();
    const size_t input = document.AddAccessor<float>({0}, 1);
    for (const char* pointer : pointers) AddAnimation(document, input, input, Pointer(pointer));
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_EQ(scene.warnings[0],
              "scene.gltf: animations[0].channels[0].target.extensions.KHR_animation_pointer.pointer: is "
              "\"/nodes/0/name\", which is not animated here (and 18 more)");
    for (const scene::Animation& animation : scene.animations) EXPECT_TRUE(animation.channels.empty());
}

TEST(AnimationPointer, MalformedOnesAreRefused) {
    const std::string at =
        "scene.gltf: animations[0].channels[0].target.extensions.KHR_animation_pointer.pointer: is ";
    const struct {
        const char* pointer;
        const char* message;
    } rows[] = {
        {"", "\"\", which is no JSON pointer"},
        {"nodes/0/scale", "\"nodes/0/scale\", which is no JSON pointer"},
        {"/nodes/0/sca~2le", "\"/nodes/0/sca~2le\", which is no JSON pointer"},
        {"/nodes/0/scale~", "\"/nodes/0/scale~\", which is no JSON pointer"},
        {"/nodes/x/scale", "\"/nodes/x/scale\", must name a node by its index"},
        {"/nodes/00/scale", "\"/nodes/00/scale\", must name a node by its index"},
        {"/nodes/-1/scale", "\"/nodes/-1/scale\", must name a node by its index"},
        {"/nodes//scale", "\"/nodes//scale\", must name a node by its index"},
        {"/nodes/4/scale", "\"/nodes/4/scale\", but there are 4 nodes"},
        {"/nodes/99999999999/scale", "\"/nodes/99999999999/scale\", must name a node by its index"},
        {"/materials/2/alphaCutoff", "\"/materials/2/alphaCutoff\", but there are 2 materials"},
        {"/meshes/1/weights", "\"/meshes/1/weights\", but there is 1 mesh"},
        {"/cameras/2/perspective/yfov", "\"/cameras/2/perspective/yfov\", but there are 2 cameras"},
        {"/extensions/KHR_lights_punctual/lights/2/color",
         "\"/extensions/KHR_lights_punctual/lights/2/color\", but there are 2 lights"},
        {"/nodes/0/weights/x", "\"/nodes/0/weights/x\", must name a weight by its index"},
    };
    for (const auto& [pointer, message] : rows) {
        GltfDocument document = Everything();
        Animate(document, Pointer(pointer), {0}, {1, 2, 3}, 3);
        EXPECT_EQ(LoadError(document), at + message);
    }
    GltfDocument document = Everything();
    Animate(document, Pointer("/nodes/0/scale"), {0}, {1, 2}, 2);
    EXPECT_EQ(LoadError(document), "scene.gltf: animations[0].samplers[0].output: accessors[" +
                                       std::to_string(document.json["accessors"].size() - 1) +
                                       "] must be VEC3 of float, bytes or shorts");
    document.json["animations"][0]["channels"][0]["target"]["extensions"]["KHR_animation_pointer"] =
        Json::object();
    EXPECT_EQ(
        LoadError(document),
        "scene.gltf: animations[0].channels[0].target.extensions.KHR_animation_pointer.pointer: is absent, "
        "must be a string");
}

}  // namespace
}  // namespace raygraph::test::animation_pointer_test

// Keys of animations that cannot be used: an error of an animation that plays, if pictures show what they move.
namespace raygraph::test::broken_keys_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// A triangle at node 0, and beside it a node of the scene that places nothing, with an animation of each of the
// paths, whose keys are broken as said.
GltfDocument WithBrokenKeys(bool areTimes, const std::vector<Json>& targets) {
    GltfDocument document;
    document.AddTriangle();
    document.AddNode({{"name", "empty"}});
    const std::vector<float> times{0, areTimes ? kInfinity : 1}, values{0, 0, 0, areTimes ? 1 : kNan, 0, 0};
    for (const Json& target : targets) Animate(document, target, times, values, 3);
    return document;
}

Json Translation(size_t node) {
    return {{"node", node}, {"path", "translation"}};
}

// Returns the message of the error with which playing the animation ends.
std::string Played(const scene::SceneData& scene, uint32_t animation) {
    const std::array clips{scene::ClipState{.animation = animation, .seconds = 0.5}};
    try {
        scene::RequirePlayable(scene, clips);
        scene::PoseEvaluator evaluator(scene);
        evaluator.Evaluate(scene, clips);
    } catch (const Error& error) {
        EXPECT_EQ(error.Kind(), ErrorKind::BadInput);
        return error.what();
    }
    return "played";
}

TEST(BrokenKeys, RefuseTheAnimationThatPlays) {
    for (const bool areTimes : {true, false}) {
        const scene::SceneData scene = Load(WithBrokenKeys(areTimes, {Translation(0), Translation(0)}));
        const std::string stream = areTimes ? "input" : "output";
        const std::string line = "scene.gltf: animations[0].samplers[0]." + stream + ": accessors[" +
                                 std::to_string(areTimes ? 2 : 3) + "] element 1 is not finite";
        EXPECT_THAT(scene.warnings, ElementsAre(line + "; the animation cannot be played (and 1 more)"));
        ASSERT_EQ(scene.animations.size(), 2u);
        EXPECT_TRUE(scene.animations[0].channels.empty());
        EXPECT_EQ(scene.animations[0].duration, 0.0f);
        EXPECT_EQ(Played(scene, 0), line);
        EXPECT_THAT(Played(scene, 1), HasSubstr("animations[1]"));
        const std::array silent{scene::ClipState{.animation = 0, .weight = 0.0f}};
        EXPECT_NO_THROW(scene::RequirePlayable(scene, silent)) << "without a weight it does not play";
    }
}

TEST(BrokenKeys, OfWhatNoPictureShows_LeaveTheirChannelsOut) {
    for (const bool areTimes : {true, false}) {
        const scene::SceneData scene = Load(WithBrokenKeys(areTimes, {Translation(1)}));
        ASSERT_EQ(scene.warnings.size(), 1u);
        EXPECT_THAT(scene.warnings[0], HasSubstr("element 1 is not finite; its channels are left out"));
        EXPECT_EQ(Played(scene, 0), "played");
    }
    // A camera, a mesh and a joint below a node are shown, a mesh outside of the scene is not
    const auto played = [](auto&& change) {
        GltfDocument document = WithBrokenKeys(true, {Translation(1)});
        change(document);
        return Played(Load(document), 0);
    };
    const Json camera{{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}};
    EXPECT_NE(played([&](GltfDocument& document) {
                  document.json["nodes"][1]["camera"] = document.Add("cameras", camera);
              }),
              "played");
    EXPECT_NE(played([](GltfDocument& document) {
                  document.json["nodes"][1]["children"] = {document.Add("nodes", {{"mesh", 0}})};
              }),
              "played");
    EXPECT_EQ(played([](GltfDocument& document) {
                  document.json["scenes"][0]["nodes"] = {0};
                  document.json["nodes"][1]["mesh"] = 0;
              }),
              "played");
    GltfDocument skinned = SkinnedTriangle();
    Animate(skinned, Translation(1), {0, kInfinity}, {0, 0, 0, 1, 0, 0}, 3);
    EXPECT_NE(Played(Load(skinned), 0), "played");
}

// One sampler of two channels, of which one moves what is shown.
TEST(BrokenKeys, ThatChannelsShare_AreWarnedOfOnce) {
    GltfDocument document = WithBrokenKeys(false, {Translation(1)});
    document.json["animations"][0]["channels"].push_back({{"sampler", 0}, {"target", Translation(0)}});
    const scene::SceneData scene = Load(document);
    EXPECT_THAT(scene.warnings,
                ElementsAre(HasSubstr("element 1 is not finite; the animation cannot be played")));
    EXPECT_THAT(scene.warnings[0], ::testing::Not(HasSubstr("more")));
}

TEST(BrokenKeys, MaterialsThatNoPrimitiveHasMayHaveBrokenKeys) {
    for (const size_t material : {0, 1}) {
        GltfDocument document =
            WithBrokenKeys(true, {Pointer("/materials/" + std::to_string(material) + "/emissiveFactor")});
        document.json["extensionsUsed"] = {"KHR_animation_pointer"};
        document.json["meshes"][0]["primitives"][0]["material"] = document.AddMaterial(Json::object());
        document.AddMaterial(Json::object());
        EXPECT_EQ(Played(Load(document), 0) == "played", material == 1);
    }
}

}  // namespace
}  // namespace raygraph::test::broken_keys_test

// Published models with animations, skins and morph targets, at a time: where their vertices are in the world.
// The numbers were computed from the files by a program in another language, which shares nothing with ours.
namespace raygraph::test::published_motion_test {
namespace {

using glm::vec3;
using scene::kNone;

struct Row {
    const char* file;
    uint32_t animation;  // kNone: the rest pose
    double seconds;
    vec3 min, max, mean;  // over the corners of all triangles
};
const Row kRows[] = {
    {"SimpleSkin.gltf",
     0,
     0,
     {-0.50000f, 0.00000f, 0.00000f},
     {0.50000f, 2.00000f, 0.00000f},
     {0.000000f, 1.000000f, 0.000000f}},
    {"SimpleSkin.gltf",
     0,
     1.2,
     {-1.00000f, 0.00000f, 0.00000f},
     {0.50000f, 1.50000f, 0.00000f},
     {-0.208333f, 0.833333f, 0.000000f}},
    {"SimpleSkin.gltf",
     0,
     5,
     {-0.55178f, 0.00000f, 0.00000f},
     {1.06083f, 2.06049f, 0.00000f},
     {0.126539f, 0.930279f, 0.000000f}},
    {"RiggedSimple.glb",
     0,
     1,
     {-1.00000f, -4.57508f, -2.86531f},
     {1.00000f, 4.10119f, 1.00000f},
     {0.002216f, -0.236317f, -0.820256f}},
    {"RiggedFigure.glb",
     0,
     0.7,
     {-0.47572f, -0.00000f, -0.12384f},
     {0.46732f, 1.46545f, 0.21469f},
     {-0.000639f, 0.695547f, 0.028346f}},
    {"Fox.glb",
     2,
     0.4,
     {-13.08644f, 6.43600f, -92.64679f},
     {13.75206f, 69.34771f, 72.43568f},
     {-0.041306f, 38.117716f, 1.397207f}},
    {"Fox.glb",
     0,
     1.3,
     {-11.59712f, -0.13068f, -82.82688f},
     {25.48049f, 75.98534f, 57.92423f},
     {2.999373f, 32.314676f, -2.467304f}},
    {"AnimatedMorphCube.glb",
     0,
     1.1,
     {-1.00000f, -1.00000f, -1.00000f},
     {1.00000f, 1.00000f, -0.45414f},
     {-0.000000f, -0.000000f, -0.727072f}},
    {"MorphPrimitivesTest.glb",
     kNone,
     0,
     {-0.50000f, 0.00000f, -0.50000f},
     {0.50000f, 0.10000f, 0.50000f},
     {0.000000f, 0.056250f, 0.000000f}},
    {"BoxAnimated.glb",
     0,
     1,
     {-0.50000f, -0.50000f, -0.50000f},
     {0.50000f, 2.51600f, 0.50000f},
     {0.000006f, 0.484252f, -0.001787f}},
    {"BoxAnimated.glb",
     0,
     2.8,
     {-0.50000f, -0.50000f, -0.50000f},
     {0.50000f, 2.39434f, 0.50000f},
     {0.000006f, 0.454540f, -0.000044f}},
    {"CesiumMilkTruck.glb",
     0,
     0.3,
     {-2.43091f, 0.00103f, -1.39600f},
     {2.43800f, 2.58437f, 1.39600f},
     {0.325158f, 0.886324f, -0.001424f}},
    {"InterpolationTest.glb",
     0,
     0.9,
     {-4.38678f, -2.15946f, -1.00000f},
     {4.34834f, 7.95891f, 1.00894f},
     {0.008187f, 3.286750f, 0.019231f}},
    {"InterpolationTest.glb",
     1,
     0.9,
     {-4.38678f, -2.15946f, -1.00000f},
     {4.34834f, 7.95891f, 1.00894f},
     {0.008187f, 3.286750f, 0.019231f}},
    {"InterpolationTest.glb",
     2,
     0.9,
     {-4.38678f, -2.15946f, -1.00000f},
     {4.34834f, 7.95891f, 1.00367f},
     {0.008187f, 3.286750f, 0.019231f}},
    {"InterpolationTest.glb",
     3,
     0.9,
     {-4.38678f, -2.15946f, -1.00000f},
     {4.34834f, 7.95891f, 1.00894f},
     {0.008187f, 3.286750f, 0.019231f}},
    {"InterpolationTest.glb",
     4,
     0.9,
     {-4.38678f, -2.15946f, -1.00000f},
     {4.35251f, 7.95891f, 1.00894f},
     {0.008187f, 3.286750f, 0.019231f}},
    {"InterpolationTest.glb",
     5,
     0.9,
     {-4.36236f, -2.15946f, -1.00000f},
     {4.34834f, 7.95891f, 1.00894f},
     {0.008187f, 3.286750f, 0.019231f}},
    {"InterpolationTest.glb",
     6,
     0.9,
     {-4.38678f, -2.15946f, -1.00000f},
     {4.34834f, 7.95891f, 1.00894f},
     {0.008187f, 3.214180f, 0.019231f}},
    {"InterpolationTest.glb",
     7,
     0.9,
     {-4.38678f, -2.15946f, -1.00000f},
     {4.34834f, 7.95891f, 1.00894f},
     {0.008187f, 3.236594f, 0.019231f}},
    {"InterpolationTest.glb",
     8,
     0.9,
     {-4.38678f, -2.15946f, -1.00000f},
     {4.34834f, 7.73419f, 1.00894f},
     {0.008187f, 3.251959f, 0.019231f}},
};

TEST(PublishedMotion, VerticesAreWhereTheFilesSay) {
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    for (const Row& row : kRows) {
        SCOPED_TRACE(std::string(row.file) + " " + std::to_string(row.animation));
        scene::SceneData scene = scene::LoadGltf(*ReferenceAssets() / "scenes" / "known" / row.file);
        // The weights of some vertices sum to 0.2
        const bool isUneven = row.file == std::string_view("RiggedFigure.glb");
        EXPECT_EQ(scene.warnings.size(), isUneven ? 1u : 0u) << ::testing::PrintToString(scene.warnings);
        scene::PoseEvaluator evaluator(scene);
        scene::PoseApplier applier(scene);
        if (row.animation != kNone) {
            const std::array clips{scene::ClipState{row.animation, row.seconds}};
            applier.Apply(scene, evaluator.Evaluate(scene, clips));
        }
        scene::Bounds exact;
        glm::dvec3 sum(0.0);
        size_t count = 0;
        scene::DeformedStreams streams;
        for (const scene::Instance& instance : scene.instances) {
            const uint32_t skin = scene.nodes[instance.node].skin;
            for (const scene::Primitive& primitive : scene.meshes[instance.mesh].primitives) {
                scene::DeformPrimitive(primitive, scene::MorphWeights(scene, instance),
                                       applier.JointMatricesOf(skin), streams);
                for (const uint32_t index : primitive.indices) {
                    const vec3 place = instance.objectToWorld * glm::vec4(streams.positions[index], 1.0f);
                    exact.Extend(place);
                    sum += glm::dvec3(place);
                    ++count;
                }
            }
        }
        const float size = glm::length(row.max - row.min);
        const vec3 mean(sum / double(count));
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(exact.min[i], row.min[i], 2e-5f * size) << i;
            EXPECT_NEAR(exact.max[i], row.max[i], 2e-5f * size) << i;
            EXPECT_NEAR(mean[i], row.mean[i], 1e-5f * size) << i;
            // The scene's own bounds are around it, and not much wider
            EXPECT_LE(scene.bounds.min[i], exact.min[i] + 1e-5f * size) << i;
            EXPECT_GE(scene.bounds.max[i], exact.max[i] - 1e-5f * size) << i;
        }
        EXPECT_LT(scene.bounds.Radius(), 1.6f * exact.Radius());
    }
}

// A scene frozen at this time, which anything can draw, gives the same result.
TEST(PublishedMotion, FrozenScenesAreThere) {
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    for (const Row& row : kRows) {
        SCOPED_TRACE(std::string(row.file) + " " + std::to_string(row.animation));
        scene::SceneData scene = scene::LoadGltf(*ReferenceAssets() / "scenes" / "known" / row.file);
        std::vector<scene::ClipState> clips;
        if (row.animation != kNone) clips.push_back({row.animation, row.seconds});
        scene::FreezePose(scene, clips);
        EXPECT_NO_THROW(scene::Check(scene, "frozen"));
        const float size = glm::length(row.max - row.min);
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(scene.bounds.min[i], row.min[i], 0.05f * size) << i;
            EXPECT_NEAR(scene.bounds.max[i], row.max[i], 0.05f * size) << i;
        }
        scene::Bounds exact;
        for (const scene::Instance& instance : scene.instances)
            for (const scene::Primitive& primitive : scene.meshes[instance.mesh].primitives)
                for (const uint32_t index : primitive.indices)
                    exact.Extend(instance.objectToWorld * glm::vec4(primitive.positions[index], 1.0f));
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(exact.min[i], row.min[i], 2e-5f * size) << i;
            EXPECT_NEAR(exact.max[i], row.max[i], 2e-5f * size) << i;
        }
    }
}

}  // namespace
}  // namespace raygraph::test::published_motion_test
