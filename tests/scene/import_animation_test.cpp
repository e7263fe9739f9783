// Skins, morph targets and animations.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "renderer/scene/animation/deform.h"
#include "renderer/scene/animation/pose.h"
#include "renderer/scene/gltf/save_gltf.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"

// Skins of glTF, joints and weights of vertices: what is read, repaired and refused.
namespace raygraph::test::import_skin_test {
namespace {

using glm::vec3;

Json& Attributes(GltfDocument& document) {
    return document.json["meshes"][0]["primitives"][0]["attributes"];
}

const scene::JointInfluences& InfluencesOf(const scene::SceneData& scene) {
    return OnlyPrimitive(scene).influences;
}

// The deformed positions of the only instance, in the world.
std::vector<vec3> Deformed(scene::SceneData& scene) {
    scene::DeformInstances(scene);
    const scene::Instance& instance = scene.instances[0];
    const scene::Skin& skin = scene.skins[scene.nodes[instance.node].skin];
    std::vector<glm::mat4x3> matrices(skin.joints.size());
    scene::JointMatrices(scene::WorldTransforms(scene), skin,
                         {instance.objectToWorld, instance.translationResidual}, matrices);
    scene::DeformedStreams streams;
    scene::DeformPrimitive(OnlyPrimitive(scene), scene::MorphWeights(scene, instance), matrices, streams);
    for (vec3& position : streams.positions) position = instance.objectToWorld * glm::vec4(position, 1.0f);
    return streams.positions;
}

TEST(ImportSkin, VerticesFollowTheirJoints) {
    scene::SceneData scene = Load(SkinnedTriangle());
    EXPECT_TRUE(scene.warnings.empty());
    ASSERT_EQ(scene.skins.size(), 1u);
    EXPECT_EQ(scene.skins[0].name, "bones");
    EXPECT_EQ(scene.skins[0].joints, (std::vector<uint32_t>{1, 2}));
    EXPECT_EQ(scene.skins[0].inverseBinds[1][3], vec3(-1, 0, 0));
    EXPECT_EQ(scene.nodes[0].skin, 0u);
    EXPECT_FALSE(scene.instances[0].isDeformed);
    const scene::JointInfluences& influences = InfluencesOf(scene);
    EXPECT_EQ(influences.perVertex, 2u) << "of eight, two are ever used";
    EXPECT_EQ(influences.joints, (std::vector<uint16_t>{0, 0, 1, 0, 0, 1}));
    EXPECT_EQ(influences.weights, (std::vector<float>{1, 0, 1, 0, 0.5f, 0.5f}));
    ASSERT_EQ(influences.bounds.size(), 2u);
    EXPECT_EQ(influences.bounds[0].max, vec3(0, 1, 0));
    EXPECT_EQ(influences.bounds[1].min, vec3(0, 0, 0));
    scene.nodes[2].translation = {1, 0, 4};
    EXPECT_EQ(Deformed(scene), (std::vector<vec3>{{0, 0, 0}, {1, 0, 4}, {0, 1, 2}}));
}

// The mesh's own node and those above it do not count.
TEST(ImportSkin, TransformOfItsNodeIsIgnored) {
    GltfDocument document = SkinnedTriangle();
    document.json["nodes"][0]["translation"] = {50, 60, 70};
    document.json["nodes"][0]["scale"] = {0, 0, 0};
    scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    ASSERT_EQ(scene.instances.size(), 1u) << "flat, and placed by its joints all the same";
    EXPECT_TRUE(scene.instances[0].isCollapsed);
    EXPECT_EQ(Deformed(scene)[1], vec3(1, 0, 0));
    EXPECT_FALSE(scene.instances[0].isCollapsed);
}

TEST(ImportSkin, WithoutMatricesTheyAreTheIdentity) {
    GltfDocument document = SkinnedTriangle();
    document.json["skins"][0].erase("inverseBindMatrices");
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.skins[0].inverseBinds, (std::vector<glm::mat4x3>(2, glm::mat4x3(1.0f))));
}

TEST(ImportSkin, AllSetsOfAllTypesAreRead) {
    GltfDocument document = SkinnedTriangle();
    Json& attributes = Attributes(document);
    attributes["JOINTS_0"] = document.AddAccessor<uint16_t>({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}, 4);
    attributes["WEIGHTS_0"] =
        document.AddAccessor<uint8_t>({51, 0, 0, 0, 0, 255, 0, 0, 255, 0, 0, 0}, 4, true);
    attributes["JOINTS_1"] = document.AddAccessor<uint8_t>({0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 4);
    attributes["WEIGHTS_1"] =
        document.AddAccessor<uint16_t>({39321, 13107, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 4, true);
    const scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
    const scene::JointInfluences& influences = InfluencesOf(scene);
    ASSERT_EQ(influences.perVertex, 3u);
    EXPECT_EQ(influences.joints, (std::vector<uint16_t>{0, 1, 1, 1, 0, 0, 0, 0, 0})) << "the heaviest first";
    const std::vector<float> expected{0.6f, 0.2f, 0.2f, 1, 0, 0, 1, 0, 0};
    for (size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(influences.weights[i], expected[i], 1e-6f) << i;
}

TEST(ImportSkin, MoreThanEightSetsGiveAWarning) {
    GltfDocument document = SkinnedTriangle();
    for (int set = 1; set < 10; ++set) {
        Attributes(document)["JOINTS_" + std::to_string(set)] = Attributes(document)["JOINTS_0"];
        Attributes(document)["WEIGHTS_" + std::to_string(set)] = Attributes(document)["WEIGHTS_0"];
    }
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.warnings.size(), 2u);
    EXPECT_EQ(scene.warnings[0],
              "scene.gltf: meshes[0].primitives[0].attributes.JOINTS_8: is not read: the first 8 sets are");
    EXPECT_EQ(InfluencesOf(scene).perVertex, 16u);
    EXPECT_FLOAT_EQ(InfluencesOf(scene).weights[0], 0.125f);
}

TEST(ImportSkin, WeightsAreMadeToSumToOne) {
    GltfDocument document = SkinnedTriangle();
    Attributes(document)["WEIGHTS_0"] =
        document.AddAccessor<float>({3, 0, 0, 0, 0, 0, 0, 0, 0.5f, 1.5f, -4, 0}, 4);
    const scene::SceneData scene = Load(document);
    const std::string at = "scene.gltf: meshes[0].primitives[0].attributes: ";
    EXPECT_EQ(scene.warnings, (std::vector<std::string>{
                                  at + "1 value is negative, taken as 0",
                                  at + "1 vertex follows no joint, taken as following the first of JOINTS_0",
                                  at + "2 vertices have weights that do not sum to 1, normalized"}));
    EXPECT_EQ(InfluencesOf(scene).weights, (std::vector<float>{1, 0, 1, 0, 0.75f, 0.25f}));
    EXPECT_EQ(InfluencesOf(scene).joints, (std::vector<uint16_t>{0, 0, 1, 0, 1, 0}));
}

// A joint with weight 0 may have any index.
TEST(ImportSkin, JointsWithoutWeightAreLeftOut) {
    GltfDocument document = SkinnedTriangle();
    Attributes(document)["JOINTS_0"] =
        document.AddAccessor<uint8_t>({0, 0, 99, 0, 1, 99, 0, 0, 0, 1, 0, 99}, 4);
    EXPECT_TRUE(Load(document).warnings.empty());
}

TEST(ImportSkin, FlatNormalsSplitInfluencesToo) {
    GltfDocument document = SkinnedTriangle();
    Attributes(document).erase("NORMAL");
    document.json["meshes"][0]["primitives"][0]["indices"] =
        document.AddAccessor<uint8_t>({0, 1, 2, 2, 1, 0}, 1);
    const scene::SceneData scene = Load(document);
    EXPECT_TRUE(OnlyPrimitive(scene).hasFlatNormals);
    EXPECT_EQ(InfluencesOf(scene).joints, (std::vector<uint16_t>{0, 0, 1, 0, 0, 1, 0, 1, 1, 0, 0, 0}));
}

// Two triangles whose texture is mirrored along their common edge get two tangents there: its vertices are split.
TEST(ImportSkin, TangentsSplitInfluencesAndTargetsToo) {
    GltfDocument document;
    const size_t positions = document.AddAccessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, -1, 0, 0}, 3);
    const size_t normals = document.AddAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
    const size_t uv = document.AddAccessor<float>({0, 0, 1, 0, 0, 1, 1, 0}, 2);
    // Each vertex follows the joint of its number, and a little that of the next
    const size_t joints = document.AddAccessor<uint8_t>({0, 1, 0, 0, 1, 2, 0, 0, 2, 3, 0, 0, 3, 4, 0, 0}, 4);
    const size_t weights = document.AddAccessor<float>(
        {0.75f, 0.25f, 0, 0, 0.625f, 0.375f, 0, 0, 0.75f, 0.25f, 0, 0, 0.625f, 0.375f, 0, 0}, 4);
    const size_t shifts = document.AddAccessor<float>({0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 4}, 3);
    const size_t mesh =
        document.AddMesh({{"attributes",
                           {{"POSITION", positions},
                            {"NORMAL", normals},
                            {"TEXCOORD_0", uv},
                            {"JOINTS_0", joints},
                            {"WEIGHTS_0", weights}}},
                          {"targets", Json::array({{{"POSITION", shifts}, {"NORMAL", shifts}}})},
                          {"indices", document.AddAccessor<uint8_t>({0, 1, 2, 0, 2, 3}, 1)},
                          {"material", 0}});
    document.AddMaterial({{"normalTexture", {{"index", 0}}}});
    document.Add("images", {{"uri", DataUri(MakePng(1, 1, {128, 128, 255, 255}))}});
    document.Add("textures", {{"source", 0}});
    document.AddNode({{"mesh", mesh}, {"skin", 0}});
    document.Add("skins", {{"joints", {0, 0, 0, 0, 0}}});
    const scene::SceneData scene = Load(document);
    const scene::Primitive& primitive = OnlyPrimitive(scene);
    ASSERT_EQ(primitive.positions.size(), 6u);
    ASSERT_EQ(primitive.influences.joints.size(), 12u);
    ASSERT_EQ(primitive.influences.weights.size(), 12u);
    for (size_t i = 0; i < 6; ++i) {
        const float number = primitive.targets[0].positions[i].z;
        EXPECT_EQ(primitive.influences.joints[2 * i] + 1.0f, number);
        EXPECT_EQ(primitive.influences.joints[2 * i + 1], number);
        const float weight = primitive.influences.joints[2 * i] % 2 == 0 ? 0.75f : 0.625f;
        EXPECT_EQ(primitive.influences.weights[2 * i], weight);
        EXPECT_EQ(primitive.influences.weights[2 * i + 1], 1.0f - weight);
        EXPECT_EQ(primitive.targets[0].normals[i].z, number);
        EXPECT_EQ(primitive.positions[i].y, number == 3.0f ? 1.0f : 0.0f) << "vertex 2 is the upper one";
    }
}

// An index list that uses few of the vertices gets only those.
TEST(ImportSkin, OnlyVerticesThatAreUsedAreKept) {
    GltfDocument document = SkinnedTriangle();
    std::vector<float> positions(3 * 100, 0.0f), weights(4 * 100, 0.0f), normals(3 * 100, 1.0f);
    std::vector<uint8_t> joints(4 * 100, 77);
    for (size_t vertex : {10u, 20u, 30u}) {
        positions[3 * vertex] = float(vertex);
        weights[4 * vertex] = 1.0f;
        joints[4 * vertex] = vertex == 20 ? 1 : 0;
    }
    Json& attributes = Attributes(document);
    attributes = {{"POSITION", document.AddAccessor(positions, 3)},
                  {"NORMAL", document.AddAccessor(normals, 3)},
                  {"JOINTS_0", document.AddAccessor(joints, 4)},
                  {"WEIGHTS_0", document.AddAccessor(weights, 4)}};
    document.json["meshes"][0]["primitives"][0]["indices"] = document.AddAccessor<uint8_t>({30, 20, 10}, 1);
    const scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(InfluencesOf(scene).joints, (std::vector<uint16_t>{0, 1, 0}));
}

TEST(ImportSkin, WithoutUseItIsLeftOutWithAWarning) {
    const auto warning = [](auto change) {
        GltfDocument document = SkinnedTriangle();
        change(document);
        const scene::SceneData scene = Load(document);
        EXPECT_EQ(scene.nodes[0].skin, scene::kNone);
        for (const scene::Instance& instance : scene.instances)
            EXPECT_TRUE(scene.meshes[instance.mesh].primitives[0].influences.IsEmpty()) << "not read either";
        return scene.warnings.size() == 1 ? scene.warnings[0] : "not one";
    };
    const std::string at = "scene.gltf: nodes[0].skin: ";
    EXPECT_EQ(warning([](GltfDocument& d) { d.json["nodes"][0].erase("mesh"); }),
              at + "is of a node without a mesh, ignored");
    EXPECT_EQ(warning([](GltfDocument& d) {
                  Attributes(d).erase("JOINTS_0");
                  Attributes(d).erase("WEIGHTS_0");
              }),
              at + "meshes[0] has no JOINTS_0 and WEIGHTS_0 in all primitives, the skin is left out");
    EXPECT_EQ(warning([](GltfDocument& d) {
                  d.json["scenes"][0]["nodes"] = {0, 1};
              }),
              at + "its joint nodes[2] is not in the scene, the skin is left out");
    EXPECT_EQ(warning([](GltfDocument& d) {
                  d.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
                      0;
              }),
              at + "is of a node with EXT_mesh_gpu_instancing, left out");
}

// Joints are those of the skins that the mesh is placed with; without one, nobody looks at them.
TEST(ImportSkin, EverySkinOfAMeshHasItsJoints) {
    GltfDocument document = SkinnedTriangle();
    document.Add("skins", {{"joints", {1}}});
    document.AddNode({{"mesh", 0}, {"skin", 1}});
    EXPECT_EQ(
        LoadError(document),
        "scene.gltf: meshes[0].primitives[0].attributes: vertex 1 follows joint 1, skins[1] has 1 joint");
    document.json["scenes"][0]["nodes"] = {0, 1, 2};
    EXPECT_EQ(LoadError(document), "loaded") << "the other is not placed";
}

TEST(ImportSkin, BadOnesAreRefused) {
    GltfDocument document = SkinnedTriangle();
    const size_t joints = Attributes(document)["JOINTS_0"];
    const size_t weights = Attributes(document)["WEIGHTS_0"];
    const size_t one = AddMatrices(document, std::vector<float>(16, 0.0f));
    std::vector<float> projective(32, 0.0f);
    const size_t notAffine = AddMatrices(document, projective);
    const size_t wrong = document.AddAccessor<uint8_t>({5, 0, 0, 0, 5, 0, 0, 0, 5, 0, 0, 0}, 4);
    const auto named = [](size_t accessor) { return "accessors[" + std::to_string(accessor) + "]"; };
    const std::string at = "meshes[0].primitives[0].attributes";
    const std::string notJoints = " must be VEC4 of unsigned byte or unsigned short";
    const std::string notWeights =
        " must be VEC4 of float, normalized unsigned byte or normalized unsigned short";
    const struct {
        const char* where;
        Json value;
        std::string message;
    } rows[] = {
        {"/skins/0/joints", Json::array(), "skins[0].joints: has no elements, must have at least 1"},
        {"/skins/0/joints", {1, 9}, "skins[0].joints[1]: is 9, but there are 3 nodes"},
        {"/skins/0", Json::object(), "skins[0].joints: is absent, must be an array"},
        {"/skins/0/inverseBindMatrices", one,
         "skins[0].inverseBindMatrices: " + named(one) + " has 1 element, the skin has 2 joints"},
        {"/skins/0/inverseBindMatrices", weights,
         "skins[0].inverseBindMatrices: " + named(weights) + " must be MAT4 of float"},
        {"/skins/0/inverseBindMatrices", notAffine,
         "skins[0].inverseBindMatrices: element 0 is not affine: its last row must be 0 0 0 1"},
        {"/nodes/0/skin", 1, "nodes[0].skin: is 1, but there is 1 skin"},
        {"/meshes/0/primitives/0/attributes/JOINTS_0", weights,
         at + ".JOINTS_0: " + named(weights) + notJoints},
        {"/meshes/0/primitives/0/attributes/WEIGHTS_0", joints,
         at + ".WEIGHTS_0: " + named(joints) + notWeights},
        {"/meshes/0/primitives/0/attributes/JOINTS_1", joints, at + ": has JOINTS_1 without WEIGHTS_1"},
        {"/meshes/0/primitives/0/attributes/WEIGHTS_1", weights, at + ": has WEIGHTS_1 without JOINTS_1"},
        {"/meshes/0/primitives/0/attributes/JOINTS_0", wrong,
         at + ": vertex 0 follows joint 5, skins[0] has 2 joints"},
    };
    for (const auto& [where, value, message] : rows) {
        GltfDocument changed = document;
        changed.json[Json::json_pointer(where)] = value;
        EXPECT_EQ(LoadError(changed), "scene.gltf: " + message) << where;
    }
}

TEST(ImportSkin, SavingKeepsItAndTheAnimations) {
    GltfDocument document = SkinnedTriangle();
    Animate(document, {{"node", 2}, {"path", "rotation"}}, {0, 1}, {0, 0, 0, 1, 0, 0, 1, 0}, 4, "STEP");
    Animate(document, Pointer("/nodes/1/scale"), {0, 1}, {1, 1, 1, 2, 2, 2}, 3);
    SceneFolder folder;
    const std::filesystem::path source = folder.Write("scene.gltf", document.Text());
    scene::SceneData edited = scene::LoadGltf(source);
    edited.nodes[1].translation = {1, 2, 3};
    scene::UpdateWorldTransforms(edited);
    for (const char* name : {"saved.gltf", "saved.glb"}) {
        const std::filesystem::path target = folder.Path() / name;
        scene::SaveGltf(source, edited, target);
        const scene::SceneData saved = scene::LoadGltf(target);
        ExpectSame(edited, saved);
        EXPECT_EQ(saved.nodes[1].translation, vec3(1, 2, 3));
    }
}

}  // namespace
}  // namespace raygraph::test::import_skin_test

// Morph targets of glTF: what is read, repaired and refused.
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

// Animations of glTF: what is read, repaired and refused.
namespace raygraph::test::import_animation_test {
namespace {

using glm::vec3;
using scene::AnimatedProperty;
using scene::Interpolation;

Json Target(const char* path, size_t node = 0) {
    return {{"node", node}, {"path", path}};
}

// A triangle that moves from (1, 2, 3) to (3, 2, 1) within a second.
GltfDocument Moving() {
    GltfDocument document;
    document.AddTriangle();
    Animate(document, Target("translation"), {0, 1}, {1, 2, 3, 3, 2, 1}, 3);
    document.json["animations"][0]["name"] = "walk";
    return document;
}

scene::SceneData PosedAt(scene::SceneData scene, double seconds, uint32_t animation = 0) {
    scene::PoseEvaluator evaluator(scene);
    scene::PoseApplier applier(scene);
    applier.Apply(scene, evaluator.Evaluate(scene, std::array{scene::ClipState{animation, seconds}}));
    return scene;
}

TEST(ImportAnimation, ChannelsHaveTheirSamplersAndTargets) {
    GltfDocument document = Moving();
    document.json["animations"][0]["samplers"].push_back(
        {{"input", document.AddAccessor<float>({0.5f, 2.5f}, 1)},
         {"output", document.AddAccessor<float>({0, 0, 0, 1, 1, 0, 0, 0}, 4)},
         {"interpolation", "STEP"}});
    document.json["animations"][0]["channels"].push_back({{"sampler", 1}, {"target", Target("rotation")}});
    const scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    ASSERT_EQ(scene.animations.size(), 1u);
    const scene::Animation& animation = scene.animations[0];
    EXPECT_EQ(animation.name, "walk");
    EXPECT_EQ(animation.duration, 2.5f);
    ASSERT_EQ(animation.samplers.size(), 2u);
    EXPECT_EQ(animation.samplers[0].interpolation, Interpolation::Linear);
    EXPECT_EQ(animation.samplers[0].width, 3u);
    EXPECT_EQ(animation.samplers[0].times, (std::vector<float>{0, 1}));
    EXPECT_EQ(animation.samplers[0].values, (std::vector<float>{1, 2, 3, 3, 2, 1}));
    EXPECT_EQ(animation.samplers[1].interpolation, Interpolation::Step);
    ASSERT_EQ(animation.channels.size(), 2u);
    EXPECT_EQ(animation.channels[1].sampler, 1u);
    EXPECT_EQ(animation.channels[1].target.property, AnimatedProperty::Rotation);
    EXPECT_EQ(animation.channels[1].target.object, 0u);
    EXPECT_EQ(PosedAt(scene, 0.5).instances[0].objectToWorld[3], vec3(2, 2, 2));
    EXPECT_EQ(PosedAt(scene, 2.5).instances[0].objectToWorld[1], vec3(0, -1, 0)) << "half a turn about +x";
}

TEST(ImportAnimation, CubicSplinesHaveThreeValuesAKey) {
    GltfDocument document;
    document.AddTriangle();
    Animate(document, Target("scale"), {0, 2}, {9, 9, 9, 1, 1, 1, 1, 0, 0, -1, 0, 0, 1, 1, 1, 9, 9, 9}, 3,
            "CUBICSPLINE");
    const scene::SceneData scene = Load(document);
    // Tangents of 1 and -1 a second over 2 s: 1 + 1/8 * 2 + 1/8 * 2 in the middle
    EXPECT_FLOAT_EQ(PosedAt(scene, 1).nodes[0].scale.x, 1.5f);
    EXPECT_FLOAT_EQ(PosedAt(scene, 1).nodes[0].scale.y, 1.0f);
}

TEST(ImportAnimation, RotationsMayBeNormalizedIntegers) {
    const auto angle = [](auto values) {
        GltfDocument document;
        document.AddTriangle();
        const size_t input = document.AddAccessor<float>({0}, 1);
        AddAnimation(document, input, document.AddAccessor(values, 4, true), Target("rotation"));
        const scene::SceneData scene = PosedAt(Load(document), 0);
        EXPECT_TRUE(scene.warnings.empty());
        EXPECT_NEAR(glm::length(scene.nodes[0].rotation), 1.0f, 1e-6f);
        return 2.0f * std::atan2(scene.nodes[0].rotation.z, scene.nodes[0].rotation.w);
    };
    EXPECT_NEAR(angle(std::vector<int8_t>{0, 0, 90, 90}), M_PI / 2, 1e-6);
    EXPECT_NEAR(angle(std::vector<uint8_t>{0, 0, 180, 180}), M_PI / 2, 1e-6);
    EXPECT_NEAR(angle(std::vector<int16_t>{0, 0, -23170, 23170}), -M_PI / 2, 1e-6);
    EXPECT_NEAR(angle(std::vector<uint16_t>{0, 0, 65535, 0}), M_PI, 1e-6);
}

TEST(ImportAnimation, AccessorsMayBeSparse) {
    GltfDocument document = Moving();
    const size_t ids = document.AddBufferView(BytesOf<uint8_t>({1}));
    const size_t values = document.AddBufferView(BytesOf<float>({7, 8, 9}));
    const size_t output = document.json["animations"][0]["samplers"][0]["output"];
    document.json["accessors"][output]["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", ids}, {"componentType", kUint8}}},
        {"values", {{"bufferView", values}}}};
    EXPECT_EQ(PosedAt(Load(document), 1).nodes[0].translation, vec3(7, 8, 9));
}

TEST(ImportAnimation, WhatCannotBeMovedIsLeftOutWithAWarning) {
    const auto warning = [](const Json& target, const char* node = nullptr) {
        GltfDocument document = Moving();
        document.json["animations"][0]["channels"][0]["target"] = target;
        if (node) document.json["nodes"][0].update(Json::parse(node));
        const scene::SceneData scene = Load(document);
        EXPECT_TRUE(scene.animations[0].channels.empty());
        EXPECT_TRUE(scene.animations[0].samplers.empty());
        return scene.warnings.size() == 1 ? scene.warnings[0] : "not one";
    };
    EXPECT_EQ(warning({{"path", "translation"}}),
              "scene.gltf: animations[0].channels[0].target: has no node, ignored");
    EXPECT_EQ(warning(Target("color")),
              "scene.gltf: animations[0].channels[0].target.path: is none that is read, ignored");
    EXPECT_EQ(warning(Target("weights")),
              "scene.gltf: animations[0].channels[0].target: nodes[0] has no such morph targets, ignored");
    EXPECT_EQ(warning(Target("translation"), R"({"matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]})"),
              "scene.gltf: animations[0].channels[0].target: nodes[0] has a matrix, and cannot be animated");
}

TEST(ImportAnimation, FirstChannelOfATargetCounts) {
    GltfDocument document = Moving();
    Json& animation = document.json["animations"][0];
    animation["samplers"].push_back(animation["samplers"][0]);
    animation["samplers"][1]["output"] = document.AddAccessor<float>({0, 0, 0, 0, 0, 0}, 3);
    animation["channels"].push_back({{"sampler", 1}, {"target", Target("translation")}});
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_EQ(scene.warnings[0],
              "scene.gltf: animations[0].channels[1].target: is that of another channel, too: the first one "
              "counts");
    EXPECT_EQ(PosedAt(scene, 0).nodes[0].translation, vec3(1, 2, 3));
}

TEST(ImportAnimation, NodesOutsideTheSceneAreMovedAndNotSeen) {
    GltfDocument document = Moving();
    document.Add("nodes", {{"name", "elsewhere"}});
    document.json["animations"][0]["channels"][0]["target"]["node"] = 1;
    const scene::SceneData scene = PosedAt(Load(document), 1);
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(scene.nodes[1].translation, vec3(3, 2, 1));
    EXPECT_EQ(scene.instances[0].objectToWorld[3], vec3(0));
}

// A mesh that grows from nothing is there from the start, unseen.
TEST(ImportAnimation, WhatGrowsFromNothingIsKept) {
    GltfDocument document;
    document.AddTriangle();
    document.json["nodes"][0]["scale"] = {0, 0, 0};
    EXPECT_TRUE(Load(document).instances.empty());
    Animate(document, Target("scale"), {0, 1}, {0, 0, 0, 2, 2, 2}, 3);
    const scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    ASSERT_EQ(scene.instances.size(), 1u);
    EXPECT_TRUE(scene.instances[0].isCollapsed);
    EXPECT_TRUE(scene.bounds.IsEmpty());
    const scene::SceneData grown = PosedAt(scene, 1);
    EXPECT_FALSE(grown.instances[0].isCollapsed);
    EXPECT_EQ(grown.instances[0].objectToWorld[0].x, 2.0f);
    EXPECT_EQ(grown.bounds.max, vec3(2, 2, 0));
}

TEST(ImportAnimation, BadOnesAreRefused) {
    GltfDocument document = Moving();
    const size_t three = document.AddAccessor<float>({0, 1, 2}, 1);
    const size_t bytes = document.AddAccessor<uint8_t>({0, 1}, 1, true);
    const size_t wholes = document.AddAccessor<int8_t>({0, 0, 0, 1, 0, 0, 0, 1}, 4);
    const size_t matrices = AddMatrices(document, std::vector<float>(32, 1.0f));
    const auto named = [](size_t accessor) { return "accessors[" + std::to_string(accessor) + "]"; };
    const auto change = [&](const char* where, const Json& value, const std::string& message) {
        GltfDocument changed = document;
        changed.json["animations"][0].merge_patch(
            Json::parse(R"({"channels": [{"sampler": 0, "target": {"node": 0,
            "path": "translation"}}]})"));
        changed.json["animations"][0][Json::json_pointer(where)] = value;
        EXPECT_EQ(LoadError(changed), "scene.gltf: animations[0]" + message) << where;
    };
    const char *input = "/samplers/0/input", *output = "/samplers/0/output";
    change(input, bytes, ".samplers[0].input: " + named(bytes) + " must be SCALAR of float");
    change(input, 99,
           ".samplers[0].input: is 99, but there are " + std::to_string(matrices + 1) + " accessors");
    change(output, three, ".samplers[0].output: " + named(three) + " must be VEC3 of float, bytes or shorts");
    change(output, matrices,
           ".samplers[0].output: " + named(matrices) + " must be VEC3 of float, bytes or shorts");
    change("/samplers/0/interpolation", "SMOOTH",
           ".samplers[0].interpolation: is \"SMOOTH\", must be LINEAR, STEP or CUBICSPLINE");
    change("/channels/0/sampler", 1, ".channels[0].sampler: is 1, but there is 1 sampler");
    change("/channels/0/target/node", 5, ".channels[0].target.node: is 5, but there is 1 node");
    change("/channels/0/target", Json::object(), ".channels[0].target.path: is absent, must be a string");
    change("/channels/0/target/path", 7, ".channels[0].target.path: is 7, must be a string");
    change("/samplers", 7, ".channels[0].sampler: is 0, but there are 0 samplers");
    GltfDocument rotated = document;
    rotated.json["animations"][0]["channels"][0]["target"]["path"] = "rotation";
    rotated.json["animations"][0]["samplers"][0]["output"] = wholes;
    EXPECT_EQ(LoadError(rotated), "scene.gltf: animations[0].samplers[0].output: " + named(wholes) +
                                      " must be VEC4 of float, normalized bytes or normalized shorts");
}

// Exporters write such files; the scene at rest is as it should be, and the animation says why it cannot be played.
TEST(ImportAnimation, UnusableKeysOfWhatIsShownAreADefectOfTheAnimation) {
    const auto defect = [](const char* path, const std::vector<float>& times,
                           const std::vector<float>& values, size_t components) {
        GltfDocument document = Moving();
        Json& animation = document.json["animations"][0];
        animation["samplers"].push_back({{"input", document.AddAccessor<float>(times, 1)},
                                         {"output", document.AddAccessor<float>(values, components)}});
        animation["channels"].insert(animation["channels"].begin(),
                                     Json{{"sampler", 1}, {"target", Target(path)}});
        animation["channels"][1]["target"]["path"] = "translation";
        const scene::SceneData scene = Load(document);
        EXPECT_EQ(scene.animations[0].channels.size(), 1u);
        EXPECT_EQ(scene.animations[0].samplers.size(), 1u);
        EXPECT_EQ(scene.animations[0].duration, 1.0f);
        const Error error = testing::ErrorOf([&] { PosedAt(scene, 1); });
        EXPECT_EQ(error.Kind(), ErrorKind::BadInput);
        EXPECT_EQ(error.what(), scene.animations[0].defect);
        EXPECT_EQ(scene.warnings,
                  std::vector{error.what() + std::string("; the animation cannot be played")});
        return scene.animations[0].defect;
    };
    const std::string at = "scene.gltf: animations[0].samplers[1].";
    EXPECT_EQ(defect("scale", {1, 1}, {1, 1, 1, 1, 1, 1}, 3),
              at + "input: accessors[4] element 1 is 1, not greater than the one before it");
    EXPECT_EQ(defect("scale", {-1, 9}, {1, 1, 1, 1, 1, 1}, 3),
              at + "input: accessors[4] element 0 is -1, a time must not be negative");
    EXPECT_EQ(defect("scale", {0, 1, 9}, {1, 1, 1, 1, 1, 1}, 3),
              at + "output: accessors[5] has 2 elements, must have 3 for 3 keys of LINEAR");
    EXPECT_EQ(defect("scale", {0}, {1, 1, 1, 1, 1, 1}, 3),
              at + "output: accessors[5] has 2 elements, must have 1 for 1 key of LINEAR");
    EXPECT_EQ(defect("rotation", {0, 9}, {0, 0, 0, 1, 0, 0, 0, 0}, 4),
              at + "output: key 1 is a quaternion of length 0");
}

// Weights are scalars, vectors are not: what one sampler is for one channel says nothing about another.
TEST(ImportAnimation, SharedSamplersAreCheckedForEachUse) {
    GltfDocument document;
    Json& primitive = document.AddTriangle();
    const size_t lifted = document.AddAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
    primitive["targets"] = {{{"POSITION", lifted}}, {{"POSITION", lifted}}, {{"POSITION", lifted}}};
    Animate(document, Target("weights"), {0}, {1, 2, 3}, 1);
    Json& channels = document.json["animations"][0]["channels"];
    channels.push_back({{"sampler", 0}, {"target", Target("translation")}});
    const std::string first = LoadError(document);
    EXPECT_NE(first.find("must be VEC3 of float"), std::string::npos) << first;
    std::swap(channels[0], channels[1]);
    EXPECT_EQ(LoadError(document), first);
}

// Samplers that no channel uses are checked as far as their accessors, and not decoded.
TEST(ImportAnimation, SamplersWithoutAChannelAreNotRead) {
    GltfDocument document = Moving();
    const size_t falling = document.AddAccessor<float>({1, 0}, 1);
    document.json["animations"][0]["samplers"].push_back({{"input", falling}, {"output", 0}});
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.animations[0].samplers.size(), 1u);
}

TEST(ImportAnimation, MemoryIsCharged) {
    GltfDocument document = Moving();
    const size_t many =
        document.Add("accessors", {{"componentType", kFloat}, {"count", 4000000000u}, {"type", "SCALAR"}});
    const size_t vectors =
        document.Add("accessors", {{"componentType", kFloat}, {"count", 4000000000u}, {"type", "VEC3"}});
    document.json["animations"][0]["samplers"][0] = {{"input", many}, {"output", vectors}};
    EXPECT_EQ(
        LoadError(document).find("scene.gltf: animations[0].samplers[0].input: decoded geometry exceeds the "
                                 "limit of "),
        0u)
        << LoadError(document);
}

}  // namespace
}  // namespace raygraph::test::import_animation_test
