// Morph targets of glTF: what is read, repaired and refused.
#include <gtest/gtest.h>

#include <array>

#include "renderer/scene/animation/deform.h"
#include "renderer/scene/animation/pose.h"
#include "tests/scene/motion_document.h"

namespace raygraph::test::import_morph_test {
namespace {

using glm::vec3;

Json& Primitive(GltfDocument& document) {
    return document.json["meshes"][0]["primitives"][0];
}

// Two targets: the first lifts all vertices by their number, the second turns the normals.
GltfDocument Morphed() {
    GltfDocument document;
    document.AddTriangle();
    const size_t lifted = document.AddAccessor<float>({0, 0, 0, 0, 0, 1, 0, 0, 2}, 3);
    const size_t turned = document.AddAccessor<float>({1, 0, 0, 1, 0, 0, 1, 0, 0}, 3);
    Primitive(document)["targets"] = {{{"POSITION", lifted}}, {{"NORMAL", turned}}};
    return document;
}

TEST(ImportMorph, TargetsHaveTheStreamsOfTheFile) {
    GltfDocument document = Morphed();
    document.json["meshes"][0]["weights"] = {0.25f, -2};
    const scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    const scene::Primitive& primitive = OnlyPrimitive(scene);
    ASSERT_EQ(primitive.targets.size(), 2u);
    EXPECT_EQ(primitive.targets[0].positions, (std::vector<vec3>{{0, 0, 0}, {0, 0, 1}, {0, 0, 2}}));
    EXPECT_TRUE(primitive.targets[0].normals.empty());
    EXPECT_EQ(primitive.targets[0].bounds.max, vec3(0, 0, 2));
    EXPECT_EQ(primitive.targets[1].normals, (std::vector<vec3>(3, vec3(1, 0, 0))));
    EXPECT_TRUE(primitive.targets[1].bounds.IsEmpty());
    EXPECT_EQ(scene.meshes[0].weights, (std::vector<float>{0.25f, -2}));
    EXPECT_TRUE(scene.nodes[0].weights.empty());
    EXPECT_EQ(primitive.positions[2], vec3(0, 1, 0)) << "the base shape";
}

TEST(ImportMorph, WithoutWeightsTheyAreZero) {
    EXPECT_EQ(Load(Morphed()).meshes[0].weights, (std::vector<float>{0, 0}));
}

TEST(ImportMorph, WeightsOfTheNodeCountBeforeThoseOfTheMesh) {
    GltfDocument document = Morphed();
    document.json["meshes"][0]["weights"] = {1, 0};
    document.AddNode({{"mesh", 0}, {"weights", {3, 0}}});
    scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.bounds.max.z, 0.0f) << "nothing is deformed yet";
    scene::DeformInstances(scene);
    EXPECT_EQ(scene::MorphWeights(scene, scene.instances[0])[0], 1.0f);
    EXPECT_EQ(scene::MorphWeights(scene, scene.instances[1])[0], 3.0f);
    EXPECT_EQ(scene.bounds.max.z, 6.0f);
}

TEST(ImportMorph, AccessorsMayBeSparseAndQuantized) {
    GltfDocument document = Morphed();
    document.json["extensionsUsed"] = {"KHR_mesh_quantization"};
    const size_t ids = document.AddBufferView(BytesOf<uint8_t>({1}));
    const size_t values = document.AddBufferView(BytesOf<float>({7, 8, 9}));
    const size_t sparse =
        document.Add("accessors", {{"componentType", kFloat},
                                   {"count", 3},
                                   {"type", "VEC3"},
                                   {"sparse",
                                    {{"count", 1},
                                     {"indices", {{"bufferView", ids}, {"componentType", kUint8}}},
                                     {"values", {{"bufferView", values}}}}}});
    const size_t shorts = document.AddAccessor<int16_t>({0, 0, 0, 100, 0, -3, 0, 0, 0}, 3);
    const size_t bytes = document.AddAccessor<int8_t>({127, 0, -127, 0, 0, 0, 0, 0, 0}, 3, true);
    Primitive(document)["targets"] = {{{"POSITION", sparse}}, {{"POSITION", shorts}, {"NORMAL", bytes}}};
    const scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    const std::vector<scene::MorphTarget>& targets = OnlyPrimitive(scene).targets;
    EXPECT_EQ(targets[0].positions, (std::vector<vec3>{{0, 0, 0}, {7, 8, 9}, {0, 0, 0}}));
    EXPECT_EQ(targets[1].positions[1], vec3(100, 0, -3));
    EXPECT_EQ(targets[1].normals[0], vec3(1, 0, -1));
    document.json.erase("extensionsUsed");
    EXPECT_EQ(Load(document).warnings.size(), 1u) << "not named, as for attributes";
}

// Streams of nothing but zeros, which exporters write, take no memory.
// Tangents of the base are not read without normals either, since they are perpendicular to them.
TEST(ImportMorph, TangentsWithoutNormalsAreNotRead) {
    GltfDocument document;
    Json& primitive = document.AddTriangle();
    primitive["attributes"].erase("NORMAL");
    const size_t lifted = document.AddAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
    primitive["attributes"]["TANGENT"] = document.AddAccessor<float>({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1}, 4);
    primitive["targets"] = {{{"POSITION", lifted}, {"TANGENT", lifted}}};
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.meshes.size(), 1u);
    EXPECT_TRUE(scene.meshes[0].primitives[0].tangents.empty());
    EXPECT_TRUE(scene.meshes[0].primitives[0].targets[0].tangents.empty());
    EXPECT_EQ(scene.meshes[0].primitives[0].targets[0].positions.size(), 3u);
}

TEST(ImportMorph, ZerosAreNoStream) {
    GltfDocument document = Morphed();
    const size_t zeros = document.AddAccessor<float>(std::vector<float>(9, 0.0f), 3);
    Primitive(document)["targets"] = {{{"POSITION", zeros}, {"NORMAL", zeros}}};
    EXPECT_TRUE(OnlyPrimitive(Load(document)).targets[0].positions.empty());
    EXPECT_TRUE(OnlyPrimitive(Load(document)).targets[0].normals.empty());
}

TEST(ImportMorph, FlatNormalsSplitTargetsAndDropTheirNormals) {
    GltfDocument document = Morphed();
    Primitive(document)["attributes"].erase("NORMAL");
    Primitive(document)["indices"] = document.AddAccessor<uint8_t>({2, 1, 0, 0, 1, 2}, 1);
    const scene::SceneData scene = Load(document);
    const scene::Primitive& primitive = OnlyPrimitive(scene);
    ASSERT_EQ(primitive.targets[0].positions.size(), 6u);
    EXPECT_EQ(primitive.targets[0].positions[0].z, 2.0f);
    EXPECT_EQ(primitive.targets[0].positions[5].z, 2.0f);
    EXPECT_TRUE(primitive.targets[1].normals.empty()) << "there are none to be displaced";
    EXPECT_TRUE(primitive.hasFlatNormals);
    EXPECT_FALSE(OnlyPrimitive(Load(Morphed())).hasFlatNormals);
}

TEST(ImportMorph, OtherAttributesGiveAWarning) {
    GltfDocument document = Morphed();
    Primitive(document)["targets"][0]["TEXCOORD_0"] = 0;
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_EQ(
        scene.warnings[0],
        "scene.gltf: meshes[0].primitives[0].targets[0]: displaces more than POSITION, NORMAL and TANGENT, "
        "which is not read");
}

TEST(ImportMorph, WeightsWithoutTargetsGiveAWarning) {
    GltfDocument document;
    document.AddTriangle();
    document.json["meshes"][0]["weights"] = {1};
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.warnings,
              std::vector<std::string>{"scene.gltf: meshes[0].weights: are of a mesh without morph "
                                       "targets, ignored"});
    EXPECT_TRUE(scene.meshes[0].weights.empty());
}

// Points as spheres keep their shape.
TEST(ImportMorph, PointsKeepTheirBaseShape) {
    GltfDocument document = Morphed();
    Primitive(document)["mode"] = 0;
    scene::LoadOptions options;
    options.pointsAndLines = {.points = {.value = 0.1f}};
    const scene::SceneData scene = Load(document, options);
    EXPECT_EQ(scene.warnings.size(), 1u);
    EXPECT_TRUE(OnlyPrimitive(scene).targets.empty());
}

TEST(ImportMorph, WeightsAreAnimated) {
    GltfDocument document = Morphed();
    Animate(document, {{"node", 0}, {"path", "weights"}}, {0, 1}, {0, 0, 1, 4}, 1);
    const size_t bytes = document.AddAccessor<uint8_t>({0, 0, 255, 51}, 1, true);
    AddAnimation(document, document.json["animations"][0]["samplers"][0]["input"], bytes,
                 {{"node", 0}, {"path", "weights"}});
    scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(scene.animations[0].samplers[0].width, 2u);
    scene::PoseEvaluator evaluator(scene);
    scene::PoseApplier applier(scene);
    applier.Apply(scene, evaluator.Evaluate(scene, std::array{scene::ClipState{0, 0.5}}));
    EXPECT_EQ(scene.nodes[0].weights, (std::vector<float>{0.5f, 2}));
    applier.Apply(scene, evaluator.Evaluate(scene, std::array{scene::ClipState{1, 1}}));
    EXPECT_EQ(scene.nodes[0].weights, (std::vector<float>{1, 0.2f}));
}

TEST(ImportMorph, BadOnesAreRefused) {
    GltfDocument document = Morphed();
    const size_t two = document.AddAccessor<float>({0, 0, 0, 1, 1, 1}, 3);
    const size_t pairs = document.AddAccessor<float>({0, 0, 0, 1, 1, 1}, 2);
    const auto named = [](size_t accessor) { return "accessors[" + std::to_string(accessor) + "]"; };
    const std::string first = "meshes[0].primitives[0].targets[0].";
    const std::string notEqual = first + "POSITION: " + named(two) + " has 2 elements, POSITION has 3";
    const std::string notVector =
        first + "POSITION: " + named(pairs) + " must be VEC3 of float, byte or short";
    const std::string notTangent =
        first + "TANGENT: " + named(pairs) + " must be VEC3 of float, normalized byte or normalized short";
    ExpectRefused(
        document,
        {{"/meshes/0/primitives/0/targets/0/POSITION", two, notEqual.c_str()},
         {"/meshes/0/primitives/0/targets/0/POSITION", pairs, notVector.c_str()},
         {"/meshes/0/primitives/0/targets/0/TANGENT", pairs, notTangent.c_str()},
         {"/meshes/0/weights", {1, 2, 3}, "meshes[0].weights: has 3 elements, the mesh has 2 morph targets"},
         {"/meshes/0/weights", {1, "x"}, "meshes[0].weights[1]: is \"x\", must be a number"},
         {"/nodes/0/weights", {1}, "nodes[0].weights: has 1 element, the mesh has 2 morph targets"},
         {"/nodes/0/weights", 1, "nodes[0].weights: is 1, must be an array"}});
    GltfDocument uneven = Morphed();
    Json other = Primitive(uneven);
    other["targets"].erase(1);
    uneven.json["meshes"][0]["primitives"].push_back(other);
    EXPECT_EQ(LoadError(uneven),
              "scene.gltf: meshes[0].primitives[1].targets: has 1 element, that of primitives[0] has 2");
}

TEST(ImportMorph, MemoryIsCharged) {
    GltfDocument document;
    const size_t many =
        document.Add("accessors", {{"componentType", kFloat}, {"count", 30000000u}, {"type", "VEC3"}});
    const size_t mesh = document.AddMesh({{"attributes", {{"POSITION", many}, {"NORMAL", many}}},
                                          {"targets", Json(64, {{"POSITION", many}})}});
    document.AddNode({{"mesh", mesh}});
    EXPECT_NE(LoadError(document).find("decoded geometry exceeds the limit of "), std::string::npos)
        << LoadError(document);
}

}  // namespace
}  // namespace raygraph::test::import_morph_test
