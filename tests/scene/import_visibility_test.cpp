// KHR_node_visibility: what is hidden, and that it is saved.
#include <gtest/gtest.h>

#include "renderer/scene/gltf/save_gltf.h"
#include "tests/scene/gltf_document.h"
#include "tests/scene/same_scene.h"

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
