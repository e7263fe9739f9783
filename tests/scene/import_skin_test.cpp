// Skins of glTF, joints and weights of vertices: what is read, repaired and refused.
#include <gtest/gtest.h>

#include <algorithm>

#include "renderer/scene/animation/deform.h"
#include "renderer/scene/gltf/save_gltf.h"
#include "tests/scene/motion_document.h"
#include "tests/scene/same_scene.h"

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
