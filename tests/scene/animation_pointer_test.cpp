// KHR_animation_pointer: what each pointer moves, and which are none.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <concepts>

#include "renderer/scene/animation/pose.h"
#include "renderer/scene/gltf/still_scene.h"
#include "renderer/scene/model/scene_fields.h"
#include "tests/scene/motion_document.h"

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
