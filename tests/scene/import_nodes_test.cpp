// The graph: transforms, scenes, cameras, lights, and malformed graphs.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "renderer/scene/model/check.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"

namespace raygraph::test::import_nodes_test {
namespace {

using glm::vec3;
using glm::vec4;

void ExpectNear(const vec3& actual, const vec3& expected, float tolerance = 1e-6f) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(actual[i], expected[i], tolerance) << "component " << i;
}

// A triangle's mesh under nodes[0], with no node of its own.
GltfDocument WithMesh() {
    GltfDocument document;
    document.AddTriangle();
    document.json.erase("nodes");
    document.json["scenes"][0] = Json::object();
    return document;
}

TEST(Nodes, TransformIsTranslationAfterRotationAfterScale) {
    GltfDocument document = WithMesh();
    const float h = std::sqrt(0.5f);  // A quarter turn about +z.
    document.AddNode(
        {{"mesh", 0}, {"translation", {10, 20, 30}}, {"rotation", {0, 0, h, h}}, {"scale", {2, 3, 4}}});
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.instances.size(), 1u);
    ExpectNear(scene.instances[0].objectToWorld * vec4(1, 0, 0, 1), {10, 22, 30}, 1e-5f);
    ExpectNear(scene.instances[0].objectToWorld * vec4(0, 1, 0, 1), {7, 20, 30}, 1e-5f);
    ExpectNear(scene.instances[0].objectToWorld * vec4(0, 0, 1, 1), {10, 20, 34}, 1e-5f);
}

TEST(Nodes, MatrixIsColumnMajor) {
    GltfDocument document = WithMesh();
    document.AddNode({{"mesh", 0}, {"matrix", {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1}}});
    const scene::SceneData scene = Load(document);
    ExpectNear(scene.instances[0].objectToWorld * vec4(1, 0, 0, 1), {5, 7, 7});
    ExpectNear(scene.instances[0].objectToWorld * vec4(0, 1, 0, 1), {4, 6, 7});
}

TEST(Nodes, ChildrenMoveWithTheirParents) {
    GltfDocument document = WithMesh();
    document.AddNode({{"scale", {2, 2, 2}}, {"children", {1}}});
    document.Add("nodes", {{"mesh", 0}, {"translation", {1, 0, 0}}});
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.instances.size(), 1u);
    EXPECT_EQ(scene.instances[0].node, 1u);
    ExpectNear(scene.instances[0].objectToWorld * vec4(0, 0, 0, 1), {2, 0, 0});
    ExpectNear(scene.bounds.min, {2, 0, 0});
    ExpectNear(scene.bounds.max, {4, 2, 0});
}

TEST(Nodes, OrderPutsParentsFirstWhateverTheFilesOrder) {
    GltfDocument document = WithMesh();
    document.Add("nodes", {{"name", "leaf"}});
    document.Add("nodes", {{"name", "middle"}, {"children", {0}}});
    document.AddNode({{"name", "root"}, {"children", {1}}});
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.nodeOrder, (std::vector<uint32_t>{2, 1, 0}));
    EXPECT_EQ(scene.nodes[0].name, "leaf");
    EXPECT_EQ(scene.nodes[0].parent, 1u);
    EXPECT_EQ(scene.nodes[2].parent, scene::kNone);
}

TEST(Nodes, NegativeScaleMirrorsTheInstance) {
    GltfDocument document = WithMesh();
    document.AddNode({{"mesh", 0}, {"scale", {-1, 1, 1}}});
    document.AddNode({{"mesh", 0}, {"scale", {-1, -1, 1}}});
    const scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.instances[0].IsMirrored());
    EXPECT_FALSE(scene.instances[1].IsMirrored());
    // The contract of Instance: the object-space normal carried by the inverse transpose keeps the front the
    // front.
    const glm::mat3 linear(scene.instances[0].objectToWorld);
    EXPECT_EQ(glm::transpose(glm::inverse(linear)) * vec3(0, 0, 1), vec3(0, 0, 1));
}

TEST(Nodes, MeshScaledToNothingIsLeftOutWithAWarning) {
    GltfDocument document = WithMesh();
    document.AddNode({{"mesh", 0}, {"scale", {0, 0, 0}}});
    document.AddNode({{"mesh", 0}, {"scale", {0, 1, 0}}});
    document.AddNode({{"mesh", 0}});
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.instances.size(), 1u);
    EXPECT_EQ(scene.instances[0].node, 2u);
    EXPECT_EQ(
        scene.warnings,
        std::vector<std::string>{
            "scene.gltf: nodes[0]: is scaled to nothing or to a line, its mesh is left out (and 1 more)"});
}

TEST(Nodes, FlatMeshIsShownWithoutAWarning) {
    GltfDocument document = WithMesh();
    document.AddNode({{"mesh", 0}, {"scale", {1, 1, 0}}});
    document.AddNode({{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 0, 1, 0, 1, 0, 1, 0, 0, 0, 5, 1}}});
    const scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    ASSERT_EQ(scene.instances.size(), 2u);
    for (const scene::Instance& instance : scene.instances) {
        EXPECT_FALSE(instance.isCollapsed);
        EXPECT_TRUE(scene::CanInvert(instance.objectToWorld));
    }
    EXPECT_NEAR(scene.bounds.max.z, 6.0f, 1e-4f);
}

TEST(Nodes, RotationIsNormalizedWithAWarning) {
    GltfDocument document = WithMesh();
    document.AddNode({{"mesh", 0}, {"rotation", {0, 0, 0, 2}}});
    const scene::SceneData scene = Load(document);
    ExpectNear(scene.instances[0].objectToWorld * vec4(1, 0, 0, 1), {1, 0, 0});
    EXPECT_EQ(scene.warnings,
              std::vector<std::string>{"scene.gltf: nodes[0].rotation: is not of unit length, normalized"});
}

TEST(Nodes, MovingANodeMovesInstancesCamerasLightsAndBounds) {
    GltfDocument document = WithMesh();
    document.Add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 1}}}});
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = {{{"type", "point"}}};
    document.AddNode({{"mesh", 0}, {"camera", 0}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    scene::SceneData scene = Load(document);
    scene.nodes[0].translation = {7, 0, 0};
    scene::UpdateWorldTransforms(scene);
    ExpectNear(scene.instances[0].objectToWorld[3], {7, 0, 0});
    ExpectNear(scene.cameras[0].cameraToWorld[3], {7, 0, 0});
    ExpectNear(scene.lights[0].lightToWorld[3], {7, 0, 0});
    ExpectNear(scene.bounds.min, {7, 0, 0});
    ExpectNear(scene.bounds.max, {8, 1, 0});
}

// 10 km off, float has steps of 1 mm; nodes add up in double.
TEST(Nodes, PlacesFarFromTheOriginKeepTheDigitsOfTheFile) {
    const double far = 10000.0002, near = 0.0123;
    GltfDocument document = WithMesh();
    document.AddNode({{"translation", {far, 0, -far}}, {"children", {1}}});
    document.Add("nodes", {{"mesh", 0}, {"translation", {near, 0.1, 0}}});
    const scene::SceneData scene = Load(document);
    const glm::dvec3 expected(far + near, 0.1, -far);  // float would store 10000.0127
    const scene::Instance& instance = scene.instances[0];
    const scene::PlacedTransform placed{instance.objectToWorld, instance.translationResidual};
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(placed.Place()[i], expected[i], 1e-9) << i;
        EXPECT_EQ(instance.objectToWorld[3][i], static_cast<float>(expected[i])) << i;
        EXPECT_NEAR(placed.RelativeTo(glm::dvec3(9984, 0, -9984))[3][i],
                    expected[i] - glm::dvec3(9984, 0, -9984)[i], 1e-6)
            << i;
    }
}

TEST(Nodes, SharedChildIsRefused) {
    GltfDocument document = WithMesh();
    document.AddNode({{"children", {2}}});
    document.AddNode({{"children", {2}}});
    document.Add("nodes", Json::object());
    EXPECT_EQ(LoadError(document),
              "scene.gltf: nodes[1].children[0]: nodes[2] is already a child of nodes[0]");
}

TEST(Nodes, CycleIsRefused) {
    GltfDocument document = WithMesh();
    document.AddNode(Json::object());
    document.Add("nodes", {{"children", {2}}});
    document.Add("nodes", {{"children", {1}}});
    EXPECT_EQ(LoadError(document), "scene.gltf: nodes[1]: is its own ancestor, or below a node that is");
    document.json["nodes"][1]["children"] = {1};
    document.json["nodes"][2] = Json::object();
    EXPECT_EQ(LoadError(document), "scene.gltf: nodes[1]: is its own ancestor, or below a node that is");
}

TEST(Nodes, IndicesOutOfRangeAreRefused) {
    ExpectRefused(WithMesh(),
                  {{"/nodes/0/mesh", 1, "nodes[0].mesh: is 1, but there is 1 mesh"},
                   {"/nodes/0/camera", 0, "nodes[0].camera: is 0, but there are 0 cameras"},
                   {"/nodes/0/skin", 0, "nodes[0].skin: is 0, but there are 0 skins"},
                   {"/nodes/0/children", {1}, "nodes[0].children[0]: is 1, but there is 1 node"},
                   {"/nodes/0/extensions/KHR_lights_punctual/light", 0,
                    "nodes[0].extensions.KHR_lights_punctual.light: is 0, but there are 0 lights"}});
}

TEST(Nodes, TransformsOfTheWrongShapeAreRefused) {
    ExpectRefused(
        WithMesh(),
        {{"/nodes/0/translation", {1, 2}, "nodes[0].translation: has 2 elements, must have 3"},
         {"/nodes/0/scale", {1, "2", 3}, "nodes[0].scale[1]: is \"2\", must be a number"},
         {"/nodes/0/rotation", {0, 0, 0, 0}, "nodes[0].rotation: is a quaternion of length 0"},
         {"/nodes/0/translation", {1e39, 0, 0}, "nodes[0].translation[0]: is 1e+39, too large for a float"},
         {"/nodes/0/matrix",
          {1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
          "nodes[0].matrix: is not affine: its last row must be 0 0 0 1"}});
}

TEST(Nodes, TransformThatOverflowsIsRefused) {
    GltfDocument document = WithMesh();
    document.AddNode({{"scale", {1e30, 1, 1}}, {"children", {1}}});
    document.Add("nodes", {{"mesh", 0}, {"scale", {1e30, 1, 1}}});
    EXPECT_EQ(LoadError(document), "scene.gltf: nodes[1]: its world transform is not finite");
}

TEST(Nodes, LongChainIsWalkedWithoutRecursionInLinearTime) {
    constexpr size_t kCount = 200000;
    GltfDocument document = WithMesh();
    Json nodes = Json::array();
    for (size_t i = 0; i + 1 < kCount; ++i) nodes.push_back({{"children", {i + 1}}});
    nodes.push_back({{"mesh", 0}});
    document.json["nodes"] = nodes;
    document.json["scenes"][0]["nodes"] = {0};
    const auto start = std::chrono::steady_clock::now();
    EXPECT_EQ(Load(document).instances.size(), 1u);
    // A second where a quadratic walk takes a minute.
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(20));
}

TEST(Scenes, DefaultSceneIsLoadedUnlessAnotherIsAskedFor) {
    GltfDocument document = WithMesh();
    for (int i = 0; i < 3; ++i) document.Add("nodes", {{"mesh", 0}});
    document.json["scenes"] = {{{"name", "first"}, {"nodes", {0}}},
                               {{"name", "second"}, {"nodes", {1}}},
                               {{"name", "both"}, {"nodes", {0, 2}}}};
    document.json["scene"] = 1;
    const auto load = [&](const std::string& which) {
        scene::LoadOptions options;
        options.scene = which;
        return Load(document, options);
    };
    EXPECT_EQ(load("").name, "second");
    EXPECT_EQ(load("").instances[0].node, 1u);
    EXPECT_EQ(load("both").instances.size(), 2u);
    EXPECT_EQ(load("0").instances[0].node, 0u);
    document.json.erase("scene");
    EXPECT_EQ(load("").name, "first");
}

TEST(Scenes, UnknownSceneIsAUsageErrorThatListsThem) {
    GltfDocument document = WithMesh();
    document.json["scenes"][0]["name"] = "hall";
    scene::LoadOptions options;
    options.scene = "cellar";
    EXPECT_EQ(testing::ErrorTextOf([&] { Load(document, options); }),
              "scene.gltf: there is no scene \"cellar\"; there are: 0 \"hall\"");
}

TEST(Scenes, WithoutScenesAllRootsAreShown) {
    GltfDocument document = WithMesh();
    document.AddNode({{"mesh", 0}});
    document.json.erase("scenes");
    document.json.erase("scene");
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.instances.size(), 1u);
    EXPECT_EQ(scene.warnings, std::vector<std::string>{"scene.gltf: has no scenes, all nodes are shown"});
}

TEST(Scenes, EmptySceneIsLegal) {
    const scene::SceneData scene = Load(GltfDocument());
    EXPECT_TRUE(scene.instances.empty());
    EXPECT_TRUE(scene.bounds.IsEmpty());
    EXPECT_TRUE(scene.warnings.empty());
}

TEST(Scenes, BadNodeListsAreRefused) {
    GltfDocument document = WithMesh();
    document.AddNode({{"children", {1}}});
    document.Add("nodes", Json::object());
    constexpr const char* kNodes = "/scenes/0/nodes";
    ExpectRefused(document,
                  {{kNodes, {1}, "scenes[0].nodes[0]: nodes[1] is a child of nodes[0], must be a root"},
                   {kNodes, {0, 0}, "scenes[0].nodes: nodes[0] is listed twice"},
                   {kNodes, {2}, "scenes[0].nodes[0]: is 2, but there are 2 nodes"},
                   {"/scene", 1, "scene: is 1, but there is 1 scene"}});
}

TEST(Statistics, PlacedTrianglesCountEveryInstance) {
    GltfDocument document = WithMesh();
    for (int i = 0; i < 5; ++i) document.AddNode({{"mesh", 0}});
    const scene::SceneStatistics statistics = scene::Statistics(Load(document));
    EXPECT_EQ(statistics.uniqueTriangles, 1u);
    EXPECT_EQ(statistics.placedTriangles, 5u);
    EXPECT_EQ(statistics.instanceCount, 5u);
    EXPECT_EQ(statistics.meshCount, 1u);
    EXPECT_EQ(statistics.geometryBytes, 3u * 12 + 3u * 12 + 3u * 4);
}

}  // namespace
}  // namespace raygraph::test::import_nodes_test
