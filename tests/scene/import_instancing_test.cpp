// EXT_mesh_gpu_instancing: a node's mesh placed at each of its transforms.
#include <gtest/gtest.h>

#include <cmath>

#include "renderer/scene/gltf/save_gltf.h"
#include "tests/scene/gltf_document.h"
#include "tests/scene/same_scene.h"
#include "tests/support/reference_assets.h"

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
