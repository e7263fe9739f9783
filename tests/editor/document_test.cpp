// Tests edits of the open scene, and their history.
#include "editor/app/document.h"

#include <limits>

#include "base/error.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/support/source_file.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::editor::document_test {

namespace {

class DocumentTest : public testing::VulkanTest {
  protected:
    DocumentTest() {
        scene::SceneData data = scene::LoadGltf(test::SourceFile("scenes/cornell.gltf"));
        document = Document("cornell.gltf", data);
        gpu.SetScene(std::move(data));
    }

    // instance that a node with a mesh places
    uint32_t instance = 0;
    uint32_t Node() const { return document.Scene().instances[instance].node; }
    scene::Material Red() const {
        scene::Material material = document.Scene().materials[0];
        material.baseColorFactor = {1, 0, 0, 1};
        return material;
    }

    Renderer renderer{Device()};
    GpuScene gpu{renderer};
    Document document;
};

// Makes a mesh that no instance places.
scene::SceneData OneTriangle() {
    scene::SceneData data;
    data.materials.resize(1);
    data.meshes.resize(1);
    scene::Primitive& triangle = data.meshes[0].primitives.emplace_back();
    triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    triangle.normals.assign(3, {0, 0, 1});
    triangle.indices = {0, 1, 2};
    triangle.bounds = scene::BoundsOf(triangle.positions);
    return data;
}

const glm::mat4x3 kUp{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 5, 0}};

}  // namespace

TEST_F(DocumentTest, KnowsTheHierarchyWithoutVertices) {
    EXPECT_FALSE(document.Roots().empty());
    EXPECT_GT(document.Statistics().placedTriangles, 0u);
    for (const scene::Mesh& mesh : document.Scene().meshes)
        for (const scene::Primitive& primitive : mesh.primitives) EXPECT_TRUE(primitive.positions.empty());
    EXPECT_FALSE(document.BoundsOf(Node()).IsEmpty());
}

TEST_F(DocumentTest, TransformMovesInstanceAndBoundsAndIsUndone) {
    const glm::mat4x3 before = gpu.Transform(instance).matrix;
    const scene::Bounds bounds = document.Scene().bounds;
    document.Apply(TransformEdit{Node(), kUp}, gpu);
    EXPECT_NE(gpu.Transform(instance).matrix, before);
    EXPECT_EQ(gpu.Transform(instance).matrix, document.Scene().instances[instance].objectToWorld);
    EXPECT_GT(document.Scene().bounds.max.y, bounds.max.y);
    document.Undo(gpu);
    EXPECT_EQ(gpu.Transform(instance).matrix, before);
    EXPECT_EQ(document.Scene().bounds.max, bounds.max);
    document.Redo(gpu);
    EXPECT_NE(gpu.Transform(instance).matrix, before);
}

TEST_F(DocumentTest, TransformMovesAllBelowAndNothingElse) {
    // Nodes 0 -> 1 -> 2, and 3 beside them; a light and a camera below
    scene::SceneData data = OneTriangle();
    data.nodes.resize(4);
    data.nodes[1].parent = 0;
    data.nodes[2].parent = 1;
    data.nodes[2].scale = glm::vec3(2.0f);
    data.nodeOrder = {3, 0, 1, 2};
    data.instances = {{0, 3, glm::mat4x3(1.0f)}, {0, 1, glm::mat4x3(1.0f)}, {0, 2, glm::mat4x3(1.0f)}};
    data.lights = {scene::Light{.name = "bulb", .node = 2}};
    data.cameras = {scene::Camera{.name = "eye", .node = 1}};
    scene::UpdateWorldTransforms(data);
    scene::SceneData expected = data;
    Document moved("", data);
    gpu.SetScene(std::move(data));
    EXPECT_EQ(moved.InstancesUnder(0), (std::vector<uint32_t>{1, 2}));
    EXPECT_EQ(moved.InstancesUnder(2), (std::vector<uint32_t>{2}));
    moved.Apply(TransformEdit{0, kUp}, gpu);
    moved.Apply(TransformEdit{1, kUp}, gpu);
    expected.nodes[0].matrix = expected.nodes[1].matrix = kUp;
    scene::UpdateWorldTransforms(expected);
    for (uint32_t i = 0; i < 3; ++i) {
        EXPECT_EQ(moved.Scene().instances[i].objectToWorld, expected.instances[i].objectToWorld) << i;
        EXPECT_EQ(gpu.Transform(i).matrix, expected.instances[i].objectToWorld) << i;
    }
    EXPECT_EQ(moved.Scene().lights[0], expected.lights[0]);
    EXPECT_EQ(gpu.Light(0), expected.lights[0]);
    EXPECT_EQ(moved.Scene().cameras[0].cameraToWorld, expected.cameras[0].cameraToWorld);
    EXPECT_EQ(moved.Scene().bounds.min, expected.bounds.min);
    EXPECT_EQ(moved.Scene().bounds.max, expected.bounds.max);
}

TEST_F(DocumentTest, TransformMovesAllInstancesOfTheNode) {
    scene::SceneData data = OneTriangle();
    data.nodes.resize(2);
    data.nodeOrder = {0, 1};
    const glm::mat4x3 turned{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}, {3, 0, 0}};
    data.instances = {{.node = 0}, {.node = 1, .objectToNode = turned}, {.node = 1, .objectToNode = kUp}};
    scene::UpdateWorldTransforms(data);
    Document moved("", data);
    gpu.SetScene(scene::SceneData(data));
    EXPECT_EQ(moved.InstancesUnder(1), (std::vector<uint32_t>{1, 2}));
    moved.Apply(TransformEdit{1, kUp}, gpu);
    data.nodes[1].matrix = kUp;
    scene::UpdateWorldTransforms(data);
    EXPECT_EQ(data.instances[1].objectToWorld[3], glm::vec3(3, 5, 0));
    for (uint32_t i = 0; i < 3; ++i) {
        EXPECT_EQ(moved.Scene().instances[i].objectToWorld, data.instances[i].objectToWorld) << i;
        EXPECT_EQ(gpu.Transform(i).matrix, data.instances[i].objectToWorld) << i;
    }
    EXPECT_EQ(moved.BoundsOf(1).max, data.bounds.max);
    moved.Undo(gpu);
    EXPECT_EQ(gpu.Transform(1).matrix, turned);
}

TEST_F(DocumentTest, VisibilityHidesAllBelowAndIsUndone) {
    scene::SceneData data = OneTriangle();
    data.nodes.resize(3);
    data.nodes[1].parent = 0;
    data.nodeOrder = {0, 1, 2};
    data.instances = {{.node = 1}, {.node = 2, .objectToWorld = kUp, .objectToNode = kUp}};
    data.lights = {scene::Light{.node = 1}};
    scene::UpdateWorldTransforms(data);
    Document edited("", data);
    gpu.SetScene(std::move(data));
    edited.Apply(VisibilityEdit{0, false}, gpu);
    EXPECT_FALSE(gpu.IsVisible(0));
    EXPECT_TRUE(gpu.IsVisible(1));
    EXPECT_FALSE(gpu.IsLightVisible(0));
    EXPECT_FALSE(edited.IsVisible(1));
    EXPECT_TRUE(edited.Scene().nodes[1].isVisible) << "its own";
    EXPECT_EQ(edited.Scene().bounds.min.y, 5.0f);
    edited.Settle();
    edited.Apply(VisibilityEdit{1, false}, gpu);
    edited.Apply(VisibilityEdit{0, true}, gpu);
    EXPECT_TRUE(edited.IsVisible(0));
    EXPECT_FALSE(gpu.IsVisible(0)) << "hidden itself";
    EXPECT_EQ(edited.EditCount(), 3u) << "another node is another step";
    for (int i = 0; i < 3; ++i) edited.Undo(gpu);
    EXPECT_TRUE(gpu.IsVisible(0));
    EXPECT_TRUE(gpu.IsLightVisible(0));
    EXPECT_EQ(edited.Scene().bounds.min.y, 0.0f);
}

TEST_F(DocumentTest, EachEditDoesTheSmallestWork) {
    const SceneRevisions before = gpu.Revisions();
    document.Apply(MaterialEdit{0, Red()}, gpu);
    EXPECT_EQ(gpu.Revisions().materials, before.materials + 1);
    EXPECT_EQ(gpu.Revisions().transforms, before.transforms);
    EXPECT_EQ(gpu.Revisions().geometry, before.geometry);
}

TEST_F(DocumentTest, EditsWithoutAPauseAreOneStep) {
    const glm::vec4 color = document.Scene().materials[0].baseColorFactor;
    for (const float red : {0.2f, 0.4f, 0.6f}) {
        scene::Material material = document.Scene().materials[0];
        material.baseColorFactor.x = red;
        document.Apply(MaterialEdit{0, material}, gpu);
    }
    EXPECT_EQ(document.EditCount(), 1u);
    document.Undo(gpu);
    EXPECT_EQ(document.Scene().materials[0].baseColorFactor, color);
}

TEST_F(DocumentTest, SettledAndOtherThingsAreStepsOfTheirOwn) {
    document.Apply(MaterialEdit{0, Red()}, gpu);
    document.Settle();
    document.Apply(MaterialEdit{0, Red()}, gpu);
    document.Apply(MaterialEdit{1, Red()}, gpu);
    document.Apply(TransformEdit{Node(), kUp}, gpu);
    EXPECT_EQ(document.EditCount(), 4u);
}

TEST_F(DocumentTest, NewEditForgetsWhatCouldBeRedone) {
    document.Apply(MaterialEdit{0, Red()}, gpu);
    document.Undo(gpu);
    EXPECT_TRUE(document.CanRedo());
    document.Apply(MaterialEdit{1, Red()}, gpu);
    EXPECT_FALSE(document.CanRedo());
    document.Undo(gpu);
    EXPECT_FALSE(document.CanUndo());
    document.Undo(gpu);  // does nothing
    EXPECT_EQ(document.EditCount(), 0u);
}

TEST_F(DocumentTest, RefusedEditChangesNothing) {
    const SceneRevisions before = gpu.Revisions();
    EXPECT_ANY_THROW(document.Apply(MaterialEdit{9999, Red()}, gpu));
    EXPECT_EQ(document.EditCount(), 0u);
    EXPECT_EQ(gpu.Revisions(), before);
}

TEST_F(DocumentTest, RefusedTransformChangesNothing) {
    const glm::mat4x3 before = gpu.Transform(instance).matrix;
    glm::mat4x3 endless = kUp;
    endless[3].x = std::numeric_limits<float>::infinity();
    EXPECT_THROW(document.Apply(TransformEdit{Node(), endless}, gpu), Error);
    EXPECT_EQ(gpu.Transform(instance).matrix, before);
    EXPECT_EQ(document.Scene().instances[instance].objectToWorld, before);
    EXPECT_FALSE(document.CanUndo());
}

TEST_F(DocumentTest, AMeshMayBeFlattenedAndNotToALine) {
    glm::mat4x3 flat = kUp;
    flat[1] = glm::vec3(0.0f);
    document.Apply(TransformEdit{Node(), flat}, gpu);
    EXPECT_TRUE(gpu.IsVisible(instance));
    EXPECT_EQ(gpu.Transform(instance).matrix, document.Scene().instances[instance].objectToWorld);
    EXPECT_EQ(document.LocalTransform(Node()), flat);
    glm::mat4x3 line = flat;
    line[0] = glm::vec3(0.0f);
    EXPECT_THROW(document.Apply(TransformEdit{Node(), line}, gpu), Error);
    EXPECT_EQ(document.LocalTransform(Node()), flat);
    document.Apply(TransformEdit{Node(), kUp}, gpu);
    EXPECT_EQ(gpu.Transform(instance).matrix, kUp);
}

TEST_F(DocumentTest, LightThatWouldBeFlatKeepsItsPlace) {
    scene::SceneData data;
    data.nodes.resize(1);
    data.nodeOrder = {0};
    data.lights = {scene::Light{.name = "bulb", .node = 0}};
    Document lit("", data);
    gpu.SetScene(std::move(data));
    glm::mat4x3 flat = kUp;
    flat[0] = glm::vec3(0.0f);
    EXPECT_THROW(lit.Apply(TransformEdit{0, flat}, gpu), Error);
    EXPECT_EQ(lit.Scene().lights[0], gpu.Light(0));
    EXPECT_FALSE(lit.CanUndo());
}

}  // namespace raygraph::editor::document_test
