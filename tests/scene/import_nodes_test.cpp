// Nodes: their tree, instances, visibility, and variants.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "renderer/scene/gltf/save_gltf.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/variants.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"
#include "tests/support/reference_assets.h"

// The graph: transforms, scenes, cameras, lights, and malformed graphs.
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

// EXT_mesh_gpu_instancing: a node's mesh placed at each of its transforms.
namespace raygraph::test::import_instancing_test {
namespace {

using glm::vec3;
using glm::vec4;

constexpr const char* kExtension = "EXT_mesh_gpu_instancing";

void ExpectNear(const vec3& actual, const vec3& expected, float tolerance = 1e-6f) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(actual[i], expected[i], tolerance) << "component " << i;
}

// Returns the position of a point of the mesh after the instance's transform.
vec3 Placed(const scene::Instance& instance, const vec3& point) {
    return instance.objectToWorld * vec4(point, 1.0f);
}

// A triangle whose node has these attributes.
GltfDocument Instanced(const std::function<void(GltfDocument&, Json& attributes)>& add) {
    GltfDocument document;
    document.AddTriangle();
    document.json["extensionsUsed"] = document.json["extensionsRequired"] = Json::array({kExtension});
    Json attributes = Json::object();
    add(document, attributes);
    document.json["nodes"][0]["extensions"][kExtension]["attributes"] = attributes;
    return document;
}

// Two of them, turned, scaled and moved.
GltfDocument Two() {
    return Instanced([](GltfDocument& document, Json& attributes) {
        const float h = std::sqrt(0.5f);  // A quarter turn about +z.
        attributes["TRANSLATION"] = document.AddAccessor<float>({10, 20, 30, -1, -2, -3}, 3);
        attributes["ROTATION"] = document.AddAccessor<float>({0, 0, h, h, 0, 0, 0, 1}, 4);
        attributes["SCALE"] = document.AddAccessor<float>({2, 3, 4, 5, 5, 5}, 3);
    });
}

TEST(Instancing, EachIsTranslatedAfterRotationAfterScaleWithinItsNode) {
    GltfDocument document = Two();
    document.json["nodes"][0]["translation"] = {100, 0, 0};
    const scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    ASSERT_EQ(scene.instances.size(), 2u);
    for (const scene::Instance& instance : scene.instances) {
        EXPECT_EQ(instance.mesh, 0u);
        EXPECT_EQ(instance.node, 0u);
    }
    ExpectNear(Placed(scene.instances[0], {1, 0, 0}), {110, 22, 30}, 1e-5f);
    ExpectNear(Placed(scene.instances[0], {0, 1, 0}), {107, 20, 30}, 1e-5f);
    ExpectNear(Placed(scene.instances[1], {1, 1, 0}), {104, 3, -3}, 1e-5f);
    ExpectNear(scene.bounds.min, {99, -2, -3}, 1e-5f);
    ExpectNear(scene.bounds.max, {110, 22, 30}, 1e-5f);
}

TEST(Instancing, EachAttributeIsOptional) {
    const GltfDocument moved = Instanced([](GltfDocument& document, Json& attributes) {
        attributes["TRANSLATION"] = document.AddAccessor<float>({1, 0, 0, 0, 2, 0, 0, 0, 3}, 3);
    });
    const scene::SceneData scene = Load(moved);
    ASSERT_EQ(scene.instances.size(), 3u);
    ExpectNear(Placed(scene.instances[2], {1, 0, 0}), {1, 0, 3});
    const GltfDocument scaled = Instanced([](GltfDocument& document, Json& attributes) {
        attributes["SCALE"] = document.AddAccessor<float>({1, 1, 1, 2, 2, 2}, 3);
    });
    ASSERT_EQ(Load(scaled).instances.size(), 2u);
    ExpectNear(Placed(Load(scaled).instances[1], {1, 0, 0}), {2, 0, 0});
}

TEST(Instancing, RotationsMayBeNormalizedBytesOrShorts) {
    const auto expectTurned = [](const GltfDocument& document) {
        const scene::SceneData scene = Load(document);
        EXPECT_TRUE(scene.warnings.empty());
        ASSERT_EQ(scene.instances.size(), 2u);
        ExpectNear(Placed(scene.instances[0], {1, 0, 0}), {0, 1, 0}, 1e-6f);
        ExpectNear(Placed(scene.instances[1], {1, 0, 0}), {-1, 0, 0}, 1e-6f);
    };
    expectTurned(Instanced([](GltfDocument& document, Json& attributes) {
        attributes["ROTATION"] = document.AddAccessor<int8_t>({0, 0, 90, 90, 0, 0, -127, 0}, 4, true);
    }));
    expectTurned(Instanced([](GltfDocument& document, Json& attributes) {
        attributes["ROTATION"] = document.AddAccessor<int16_t>({0, 0, 23170, 23170, 0, 0, 32767, 0}, 4, true);
    }));
}

TEST(Instancing, OtherAttributesAreIgnored) {
    const GltfDocument document = Instanced([](GltfDocument& d, Json& attributes) {
        attributes["TRANSLATION"] = d.AddAccessor<float>({1, 0, 0, 0, 2, 0}, 3);
        attributes["_ID"] = d.AddAccessor<uint8_t>({1, 2, 3}, 1);
    });
    EXPECT_EQ(Load(document).instances.size(), 2u);
    EXPECT_TRUE(Load(document).warnings.empty());
}

TEST(Instancing, WithoutATransformOrAMeshThereIsAWarning) {
    const GltfDocument none = Instanced([](GltfDocument& d, Json& attributes) {
        attributes["_ID"] = d.AddAccessor<uint8_t>({1, 2, 3}, 1);
    });
    ASSERT_EQ(Load(none).instances.size(), 1u);
    EXPECT_EQ(Load(none).warnings,
              std::vector<std::string>{"scene.gltf: nodes[0].extensions.EXT_mesh_gpu_instancing: has no "
                                       "TRANSLATION, ROTATION or SCALE, the mesh is shown once"});
    GltfDocument empty = Two();
    empty.json["nodes"][0].erase("mesh");
    ASSERT_EQ(Load(empty).warnings.size(), 1u);
    EXPECT_EQ(
        Load(empty).warnings[0],
        "scene.gltf: nodes[0].extensions.EXT_mesh_gpu_instancing: is of a node without a mesh, ignored");
}

TEST(Instancing, ScaledToNothingIsLeftOutWithAWarning) {
    const GltfDocument document = Instanced([](GltfDocument& d, Json& attributes) {
        attributes["SCALE"] = d.AddAccessor<float>({1, 1, 1, 0, 0, 0, 1, 0, 0, 2, 0, 2}, 3);
    });
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.instances.size(), 2u);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_EQ(scene.warnings[0],
              "scene.gltf: nodes[0].extensions.EXT_mesh_gpu_instancing.attributes: instance 1 is scaled to "
              "nothing or to a line, left out (and 1 more)");
}

TEST(Instancing, AccessorsMayBeSparseOrWithoutBytes) {
    GltfDocument document = Instanced([](GltfDocument& d, Json& attributes) {
        const size_t ids = d.AddBufferView(BytesOf<uint8_t>({1}));
        const size_t values = d.AddBufferView(BytesOf<float>({7, 8, 9}));
        attributes["TRANSLATION"] =
            d.Add("accessors", {{"componentType", kFloat},
                                {"count", 3},
                                {"type", "VEC3"},
                                {"sparse",
                                 {{"count", 1},
                                  {"indices", {{"bufferView", ids}, {"componentType", kUint8}}},
                                  {"values", {{"bufferView", values}}}}}});
    });
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.instances.size(), 3u);
    ExpectNear(Placed(scene.instances[0], vec3(0)), {0, 0, 0});
    ExpectNear(Placed(scene.instances[1], vec3(0)), {7, 8, 9});
    document.json["accessors"].back().erase("sparse");
    EXPECT_EQ(Load(document).instances.size(), 3u);
}

TEST(Instancing, BadAttributesAreRefused) {
    GltfDocument document = Two();
    const size_t three = document.AddAccessor<float>({1, 1, 1, 1, 1, 1, 1, 1, 1}, 3);
    const size_t bytes = document.AddAccessor<int8_t>({1, 1, 1, 0, 1, 1, 1, 0}, 4, false);
    const size_t zeros = document.AddAccessor<float>({0, 0, 0, 1, 0, 0, 0, 0}, 4);
    const size_t translation =
        document.json["nodes"][0]["extensions"][kExtension]["attributes"]["TRANSLATION"];
    const size_t rotation = translation + 1;
    const std::string at = "nodes[0].extensions.EXT_mesh_gpu_instancing.attributes.";
    const std::string notQuaternion = " must be VEC4 of float, normalized byte or normalized short";
    const auto change = [&](const char* where, const Json& value, const std::string& message) {
        GltfDocument changed = document;
        changed.json["nodes"][0]["extensions"][kExtension]["attributes"][where] = value;
        EXPECT_EQ(LoadError(changed), "scene.gltf: " + at + where + ": " + message);
    };
    const auto named = [](size_t accessor) { return "accessors[" + std::to_string(accessor) + "]"; };
    change("SCALE", three, named(three) + " has 3 elements, TRANSLATION has 2");
    change("SCALE", rotation, named(rotation) + " must be VEC3 of float");
    change("TRANSLATION", bytes, named(bytes) + " must be VEC3 of float");
    change("ROTATION", bytes, named(bytes) + notQuaternion);
    change("ROTATION", three, named(three) + notQuaternion);
    change("ROTATION", zeros, "element 1 is a quaternion of length 0");
    change("ROTATION", 99, "is 99, but there are 8 accessors");
    change("ROTATION", "x", "is \"x\", must be a whole number of at least 0");
    GltfDocument infinite = document;
    infinite.json["nodes"][0]["scale"] = {1e30, 1e30, 1e30};
    infinite.json["nodes"][0]["extensions"][kExtension]["attributes"]["SCALE"] =
        infinite.AddAccessor<float>({1, 1, 1, 1e30f, 1, 1}, 3);
    EXPECT_EQ(LoadError(infinite),
              "scene.gltf: nodes[0].extensions.EXT_mesh_gpu_instancing.attributes: the world transform of "
              "instance 1 is not finite");
}

// A few bytes of file must not become gigabytes.
TEST(Instancing, MemoryIsCharged) {
    const GltfDocument document = Instanced([](GltfDocument& d, Json& attributes) {
        attributes["TRANSLATION"] =
            d.Add("accessors", {{"componentType", kFloat}, {"count", 4000000000u}, {"type", "VEC3"}});
    });
    EXPECT_EQ(LoadError(document).find("scene.gltf: nodes[0].extensions.EXT_mesh_gpu_instancing.attributes: "
                                       "decoded geometry exceeds the limit of "),
              0u)
        << LoadError(document);
}

TEST(Instancing, MovingTheNodeMovesAllOfItsInstances) {
    scene::SceneData scene = Load(Two());
    const vec3 before[2] = {Placed(scene.instances[0], {1, 0, 0}), Placed(scene.instances[1], {1, 0, 0})};
    scene.nodes[0].translation = {0, 0, 7};
    scene::UpdateWorldTransforms(scene);
    for (size_t i = 0; i < 2; ++i)
        ExpectNear(Placed(scene.instances[i], {1, 0, 0}), before[i] + vec3(0, 0, 7), 1e-5f);
}

// 10,000 km from the origin, where floats are 1 m apart.
TEST(Instancing, KeepsItsDigitsFarFromTheOrigin) {
    GltfDocument document = Instanced([](GltfDocument& d, Json& attributes) {
        attributes["TRANSLATION"] = d.AddAccessor<float>({0.25f, 0, 0, 0.5f, 0, 0}, 3);
    });
    document.json["nodes"][0]["translation"] = {10000000.125, 0, 0};
    const scene::SceneData scene = Load(document);
    ASSERT_EQ(scene.instances.size(), 2u);
    const auto place = [](const scene::Instance& instance) {
        return scene::PlacedTransform{instance.objectToWorld, instance.translationResidual}.Place().x;
    };
    EXPECT_EQ(place(scene.instances[0]), 10000000.375);
    EXPECT_EQ(place(scene.instances[1]), 10000000.625);
}

TEST(Instancing, SavingKeepsIt) {
    SceneFolder folder;
    const std::filesystem::path source = folder.Write("scene.gltf", Two().Text());
    scene::SceneData edited = scene::LoadGltf(source);
    edited.nodes[0].translation = {1, 2, 3};
    scene::UpdateWorldTransforms(edited);
    scene::SaveGltf(source, edited, folder.Path() / "saved.gltf");
    const scene::SceneData saved = scene::LoadGltf(folder.Path() / "saved.gltf");
    EXPECT_EQ(saved.instances.size(), 2u);
    ExpectSame(edited, saved);
}

TEST(Instancing, PublishedSceneHasItsBoxes) {
    RAYGRAPH_SKIP_WITHOUT_ASSETS();
    const scene::SceneData scene = scene::LoadGltf(*ReferenceAssets() / "scenes/known/SimpleInstancing.glb");
    EXPECT_EQ(scene.instances.size(), 125u);
    EXPECT_TRUE(scene.warnings.empty());
}

}  // namespace
}  // namespace raygraph::test::import_instancing_test

// KHR_node_visibility: what is hidden, and that it is saved.
namespace raygraph::test::import_visibility_test {
namespace {

constexpr const char* kExtension = "KHR_node_visibility";

// nodes[0] with a mesh, nodes[1] above nodes[2], which has that mesh and a light. The mesh shines.
GltfDocument Family() {
    GltfDocument document;
    document.AddTriangle()["material"] = document.AddMaterial({{"emissiveFactor", {1, 1, 1}}});
    document.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::array({{{"type", "point"}}});
    document.AddNode({{"children", {2}}, {"translation", {5, 0, 0}}});
    document.Add("nodes", {{"mesh", 0}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    return document;
}

void Hide(GltfDocument& document, size_t node, const Json& visible = false) {
    document.json["nodes"][node]["extensions"][kExtension]["visible"] = visible;
}

std::vector<bool> Visible(const GltfDocument& document) {
    return scene::VisibleNodes(Load(document));
}

TEST(Visibility, HiddenNodeHidesAllBelowIt) {
    GltfDocument document = Family();
    EXPECT_EQ(Visible(document), (std::vector<bool>{true, true, true}));
    Hide(document, 1);
    Hide(document, 2, true);
    EXPECT_EQ(Visible(document), (std::vector<bool>{true, false, false}));
    Hide(document, 1, true);
    Hide(document, 2);
    EXPECT_EQ(Visible(document), (std::vector<bool>{true, true, false}));
    EXPECT_TRUE(Load(document).warnings.empty());
}

TEST(Visibility, NodesAreVisibleUnlessTheFileSaysOtherwise) {
    GltfDocument document = Family();
    document.json["nodes"][0]["extensions"][kExtension] = Json::object();
    EXPECT_EQ(Visible(document), (std::vector<bool>{true, true, true}));
    Hide(document, 0, 1);
    EXPECT_EQ(LoadError(document),
              "scene.gltf: nodes[0].extensions.KHR_node_visibility.visible: is 1, must be true or false");
}

TEST(Visibility, HiddenThingsNeitherShineNorBoundTheScene) {
    GltfDocument document = Family();
    scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene::HasVisibleLight(scene));
    EXPECT_EQ(scene.bounds.max.x, 6.0f);
    Hide(document, 1);
    scene = Load(document);
    EXPECT_EQ(scene.instances.size(), 2u);
    EXPECT_EQ(scene.lights.size(), 1u);
    EXPECT_FALSE(scene::HasVisibleLight(scene));
    EXPECT_TRUE(scene::HasEmission(scene));
    EXPECT_EQ(scene.bounds.max.x, 1.0f);
    Hide(document, 0);
    EXPECT_FALSE(scene::HasEmission(Load(document)));
}

TEST(Visibility, IsSavedWhereItWasEdited) {
    SceneFolder folder;
    GltfDocument document = Family();
    Hide(document, 0);
    const std::filesystem::path source = folder.Write("scene.gltf", document.Text());
    scene::SceneData edited = scene::LoadGltf(source);
    edited.nodes[0].isVisible = true;
    edited.nodes[1].isVisible = false;
    scene::UpdateWorldTransforms(edited);
    const std::filesystem::path target = folder.Path() / "saved.gltf";
    scene::SaveGltf(source, edited, target);
    const scene::SceneData saved = scene::LoadGltf(target);
    ExpectSame(edited, saved);
    EXPECT_TRUE(saved.warnings.empty());
    EXPECT_EQ(scene::VisibleNodes(saved), (std::vector<bool>{true, false, false}));
    const Bytes text = folder.Read(target, 1 << 20);
    const Json json = Json::parse(reinterpret_cast<const char*>(text.data()),
                                  reinterpret_cast<const char*>(text.data()) + text.size());
    EXPECT_FALSE(json["nodes"][2]["extensions"].contains(kExtension)) << "not edited, not written";
    EXPECT_EQ(json["extensionsUsed"], Json::array({kExtension}));
}

// The first extension of a file gives it a list of those that it uses, beside its nodes.
TEST(Visibility, IsSavedInAFileWithoutExtensions) {
    for (size_t nodeCount = 1; nodeCount < 4; ++nodeCount) {
        GltfDocument document;
        for (size_t i = 0; i < nodeCount; ++i) document.AddTriangle();
        ASSERT_FALSE(document.json.contains("extensionsUsed"));
        const SceneFolder folder;
        const std::filesystem::path source = folder.Write("scene.gltf", document.Text());
        scene::SceneData edited = scene::LoadGltf(source);
        for (scene::Node& node : edited.nodes) node.isVisible = false;
        scene::SaveGltf(source, edited, folder.Path() / "saved.gltf");
        const scene::SceneData saved = scene::LoadGltf(folder.Path() / "saved.gltf");
        EXPECT_EQ(scene::VisibleNodes(saved), std::vector<bool>(nodeCount, false));
        EXPECT_TRUE(saved.warnings.empty());
    }
}

}  // namespace
}  // namespace raygraph::test::import_visibility_test

// KHR_materials_variants: which materials there are to choose from, and that saving keeps them.
namespace raygraph::test::import_variants_test {
namespace {

constexpr const char* kExtension = "KHR_materials_variants";
constexpr const char* kMappings = "/meshes/0/primitives/0/extensions/KHR_materials_variants/mappings";

// Three materials and three variants: the first two map the triangle, the other one does not.
GltfDocument Shoe() {
    GltfDocument document;
    document.json["extensions"][kExtension]["variants"] = {
        {{"name", "red"}}, {{"name", "blue"}}, {{"name", "plain"}}};
    Json& triangle = document.AddTriangle();
    for (const char* name : {"leather", "paint", "cloth"}) document.AddMaterial({{"name", name}});
    triangle["material"] = 0;
    triangle["extensions"][kExtension]["mappings"] = {{{"material", 2}, {"variants", {1}}},
                                                      {{"material", 1}, {"variants", {0}}, {"name", "x"}}};
    return document;
}

// The materials of the triangle without a variant, then in each.
std::vector<uint32_t> MaterialsByVariant(scene::SceneData scene) {
    std::vector<uint32_t> materials{OnlyPrimitive(scene).material};
    for (uint32_t i = 0; i < scene.variants.size(); ++i) {
        scene::SetVariant(scene, i);
        EXPECT_EQ(scene.variant, i);
        EXPECT_EQ(scene::MaterialOf(OnlyPrimitive(scene), i), OnlyPrimitive(scene).material);
        materials.push_back(OnlyPrimitive(scene).material);
    }
    scene::SetVariant(scene, scene::kNone);
    EXPECT_EQ(OnlyPrimitive(scene).material, materials[0]);
    return materials;
}

TEST(Variants, EachGivesAPrimitiveItsMaterial) {
    GltfDocument document = Shoe();
    const scene::SceneData scene = Load(document);
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(scene.variants, (std::vector<std::string>{"red", "blue", "plain"}));
    EXPECT_EQ(scene.variant, scene::kNone);
    EXPECT_EQ(MaterialsByVariant(scene), (std::vector<uint32_t>{0, 1, 2, 0}));
    // One mapping of several variants, of a primitive whose own material is glTF's default
    document.json["meshes"][0]["primitives"][0].erase("material");
    document.json[Json::json_pointer(kMappings)] = {{{"material", 1}, {"variants", {2, 0}}}};
    EXPECT_EQ(MaterialsByVariant(Load(document)), (std::vector<uint32_t>{3, 1, 3, 1}));
    document.json["meshes"][0]["primitives"][0].erase("extensions");
    EXPECT_EQ(MaterialsByVariant(Load(document)), (std::vector<uint32_t>{3, 3, 3, 3}));
}

TEST(Variants, AreFoundByNameThenByIndex) {
    GltfDocument document = Shoe();
    scene::SceneData scene = Load(document);
    EXPECT_EQ(scene::FindVariant(scene, "blue"), 1u);
    EXPECT_EQ(scene::FindVariant(scene, "1"), 1u);
    EXPECT_EQ(scene::FindVariant(scene, ""), scene::kNone);
    for (const char* absent : {"green", "3", "-1", "1x", "4294967295"}) {
        const Error error = testing::ErrorOf([&] { scene::FindVariant(scene, absent); });
        EXPECT_EQ(error.Kind(), ErrorKind::BadInput);
        EXPECT_EQ(error.what(), "there is no variant \"" + std::string(absent) +
                                    "\"; the scene has 0 \"red\", 1 \"blue\", 2 \"plain\"");
    }
    const Error none = testing::ErrorOf([] { scene::FindVariant({}, "red"); });
    EXPECT_STREQ(none.what(), "there is no variant \"red\"; the scene has no variants");
    EXPECT_EQ(testing::ErrorOf([&] { scene::SetVariant(scene, 3); }).Kind(), ErrorKind::Usage);
    // The name stands for the first, and none for nothing
    scene.variants = {"2", "red", "red", ""};
    for (uint32_t i = 0; i < scene.variants.size(); ++i)
        EXPECT_EQ(scene::FindVariant(scene, scene::VariantText(scene, i)), i == 2 ? 0u : i) << i;
    EXPECT_EQ(scene::VariantText(scene, 1), "red");
    EXPECT_EQ(scene::VariantText(scene, 3), "3");
    EXPECT_EQ(scene::VariantText(scene, scene::kNone), "");
}

TEST(Variants, WhatIsOutOfRangeIsRefused) {
    const std::string at = "meshes[0].primitives[0].extensions.KHR_materials_variants.mappings";
    const auto message = [&](const std::string& rest) { return at + rest; };
    const std::string refusals[] = {
        message("[0].variants[0]: is 3, but there are 3 variants"),
        message("[1].material: is 3, but there are 3 materials"),
        message("[0].variants: is absent, must be an array"),
        message("[0].material: is absent, must be a whole number of at least 0"),
        message("[0].variants[0]: is -1, must be a whole number of at least 0"),
        message("[0].variants: is 1, must be an array"),
        message("[0]: is 1, must be an object"),
        message(": is an object, must be an array"),
    };
    const std::string mappings = kMappings;
    const std::string first = mappings + "/0", variants = first + "/variants", index = variants + "/0",
                      material = mappings + "/1/material";
    ExpectRefused(Shoe(), {
                              {index.c_str(), 3, refusals[0].c_str()},
                              {material.c_str(), 3, refusals[1].c_str()},
                              {first.c_str(), {{"material", 1}}, refusals[2].c_str()},
                              {first.c_str(), {{"variants", {1}}}, refusals[3].c_str()},
                              {index.c_str(), -1, refusals[4].c_str()},
                              {variants.c_str(), 1, refusals[5].c_str()},
                              {first.c_str(), 1, refusals[6].c_str()},
                              {kMappings, Json::object(), refusals[7].c_str()},
                              {"/extensions/KHR_materials_variants", Json::object(),
                               (at + "[0].variants[0]: is 1, but there are 0 variants").c_str()},
                          });
}

TEST(Variants, OneThatIsMappedTwiceKeepsItsFirstMaterial) {
    GltfDocument document = Shoe();
    document.json[Json::json_pointer(kMappings)] = {{{"material", 2}, {"variants", {1, 1}}},
                                                    {{"material", 1}, {"variants", {0, 1}}}};
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(scene.warnings, std::vector<std::string>{
                                  "scene.gltf: meshes[0].primitives[0].extensions.KHR_materials_variants: "
                                  "variant 1 has materials 2 and 1, the first is shown"});
    EXPECT_EQ(MaterialsByVariant(scene), (std::vector<uint32_t>{0, 1, 2, 0}));
}

// Vertices are made once, for all variants.
TEST(Variants, NormalMapOfOneHasTangents) {
    GltfDocument document = Shoe();
    document.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] =
        document.AddAccessor<float>({0, 0, 1, 0, 0, 1}, 2);
    EXPECT_TRUE(OnlyPrimitive(Load(document)).tangents.empty());
    document.Add("images", {{"uri", DataUri(MakePng(1, 1, {128, 128, 255, 255}))}});
    document.Add("textures", {{"source", 0}});
    document.json["materials"][2]["normalTexture"]["index"] = 0;
    const scene::SceneData scene = Load(document);
    EXPECT_EQ(OnlyPrimitive(scene).tangents.size(), 3u);
    EXPECT_TRUE(scene.warnings.empty());
    // The normal map of another variant is turned, which only matters where it is read
    document.json["materials"][1]["normalTexture"] = {
        {"index", 0}, {"extensions", {{"KHR_texture_transform", {{"rotation", 1}}}}}};
    EXPECT_TRUE(Load(document).warnings.empty());
}

TEST(Variants, ScenesOfHostsAreChecked) {
    const auto refusal = [](const auto& change) {
        scene::SceneData scene = Load(Shoe());
        change(scene, scene.meshes[0].primitives[0].variants);
        try {
            scene::Check(scene);
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string("accepted");
    };
    using List = std::vector<scene::VariantMaterial>;
    const std::string at = "scene: meshes[0].primitives[0]: ";
    EXPECT_EQ(refusal([](scene::SceneData&, List&) {}), "accepted");
    EXPECT_EQ(refusal([](scene::SceneData& scene, List&) { scene.variant = 3; }),
              "scene: its variant is 3, there are 3");
    EXPECT_EQ(refusal([](scene::SceneData&, List& list) { list[0].variant = 3; }),
              at + "a variant is 3, there are 3");
    EXPECT_EQ(refusal([](scene::SceneData&, List& list) { list[0].material = 4; }),
              at + "the material of a variant is 4, there are 3");
    EXPECT_EQ(refusal([](scene::SceneData&, List& list) { std::swap(list[0], list[1]); }),
              at + "its variants do not ascend");
    EXPECT_EQ(refusal([](scene::SceneData&, List& list) { list.pop_back(); }),
              at + "its variants do not end with one for all others");
}

TEST(Variants, SavingKeepsThemAndTheMaterialWithoutOne) {
    SceneFolder folder;
    const std::filesystem::path source = folder.Write("scene.gltf", Shoe().Text());
    scene::SceneData edited = scene::LoadGltf(source);
    scene::SetVariant(edited, 1);
    edited.materials[OnlyPrimitive(edited).material].roughnessFactor = 0.25f;
    const std::filesystem::path target = folder.Path() / "saved.gltf";
    scene::SaveGltf(source, edited, target);
    const scene::SceneData saved = scene::LoadGltf(target);
    EXPECT_EQ(saved.variants, edited.variants);
    EXPECT_EQ(MaterialsByVariant(saved), (std::vector<uint32_t>{0, 1, 2, 0}));
    EXPECT_EQ(saved.materials[2].roughnessFactor, 0.25f);
    const Bytes text = folder.Read(target, 1 << 20);
    Json json = Json::parse(reinterpret_cast<const char*>(text.data()),
                            reinterpret_cast<const char*>(text.data()) + text.size());
    json["materials"][2].erase("pbrMetallicRoughness");
    EXPECT_EQ(json, Shoe().json) << "nothing else";
    // Shown as it was saved, and as the file without a variant shows it
    scene::SetVariant(edited, scene::kNone);
    ExpectSame(edited, saved);
}

}  // namespace
}  // namespace raygraph::test::import_variants_test
