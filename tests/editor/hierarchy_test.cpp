// Tests edits of the hierarchy, and that files get them.
#include <gtest/gtest.h>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "base/error.h"
#include "editor/app/document.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/editor/editor_test.h"
#include "tests/editor/moving_scene.h"
#include "tests/support/error_of.h"

namespace raygraph::editor::hierarchy_test {

namespace {

std::string TextOf(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

class HierarchyEditTest : public testing::VulkanTest {
  protected:
    HierarchyEditTest() { Open(moving::Document()); }
    void Open(const test::GltfDocument& source) {
        const std::filesystem::path file = folder.Write("scene.gltf", source.Text());
        scene::SceneData data = scene::LoadGltf(file);
        scene::DeformInstances(data);
        document = Document(file, data);
        gpu.SetScene(std::move(data));
    }
    // Saves the document and returns the text of the file.
    std::string Saved() {
        const std::filesystem::path copy = folder.Path() / (std::to_string(saves++) + ".gltf");
        document.Save(copy);
        return TextOf(copy);
    }
    std::string Refusal(auto&& edit) { return testing::ErrorTextOf(edit, ErrorKind::Usage); }
    void Repeat(void (Document::*step)(GpuScene&), int times) {
        while (times-- > 0) (document.*step)(gpu);
    }

    test::SceneFolder folder;
    int saves = 0;
    Renderer renderer{Device()};
    GpuScene gpu{renderer};
    Document document;
};

}  // namespace

TEST_F(HierarchyEditTest, EditsAreSavedAndUndoGivesTheFileBack) {
    using namespace moving;
    const std::string before = Saved();
    const std::vector<uint32_t> copies = document.Duplicate(std::vector<uint32_t>{Slider, Rider}, gpu);
    ASSERT_EQ(copies, std::vector<uint32_t>{6}) << "what is below goes with it";
    const uint32_t instance = document.InstancesUnder(6).front();
    EXPECT_TRUE(gpu.IsVisible(instance));
    EXPECT_EQ(gpu.Transform(instance).matrix[3], glm::vec3(0.25f, 1, 0));
    document.Apply(TransformEdit{6, glm::mat4x3({1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 5})}, gpu);
    EXPECT_EQ(gpu.Transform(instance).matrix[3], glm::vec3(0, 1, 5));
    document.Apply(NameEdit{Rider, "passenger"}, gpu);
    document.Reparent(std::vector<uint32_t>{Eye}, Slider, Rider, gpu);
    EXPECT_EQ(document.Children()[Slider], (std::vector<uint32_t>{Eye, Rider}));
    EXPECT_EQ(document.WorldTransform(Eye)[3], glm::vec3(0, 0, 8));
    EXPECT_EQ(document.LocalTransform(Eye)[3], glm::vec3(-0.25f, 0, 8));
    const Document::Removed removed =
        document.Remove(std::vector<uint32_t>{Skinned, FirstJoint, SecondJoint}, gpu);
    EXPECT_EQ(removed.nodes, 3u);
    EXPECT_EQ(removed.channels, 1u);
    EXPECT_FALSE(gpu.IsVisible(0));

    const std::string after = Saved();
    const scene::SceneData loaded = scene::LoadGltf(document.File());
    std::vector<std::string> names;
    for (const uint32_t node : loaded.nodeOrder) names.push_back(loaded.nodes[node].name);
    EXPECT_EQ(names, (std::vector<std::string>{"slider", "eye", "passenger", "slider.001", "rider.001"}));
    EXPECT_EQ(loaded.nodes.size(), 5u);
    EXPECT_TRUE(loaded.skins.empty());
    EXPECT_EQ(loaded.cameras.at(0).cameraToWorld[3], glm::vec3(0, 0, 8));
    EXPECT_EQ(loaded.instances.at(1).objectToWorld[3], glm::vec3(0, 1, 5));
    ASSERT_EQ(loaded.animations.size(), 3u) << "all but that of the joint";
    EXPECT_EQ(loaded.nodes[loaded.animations[1].channels.at(0).target.object].name, "eye");

    Repeat(&Document::Undo, 5);
    EXPECT_FALSE(gpu.IsVisible(instance));
    EXPECT_TRUE(gpu.IsVisible(0));
    EXPECT_FALSE(document.CanUndo());
    EXPECT_EQ(Saved(), before);
    Repeat(&Document::Redo, 5);
    EXPECT_TRUE(gpu.IsVisible(instance));
    EXPECT_EQ(Saved(), after);
}

TEST_F(HierarchyEditTest, RefusedEditsChangeNothing) {
    using namespace moving;
    const std::string before = Saved();
    EXPECT_EQ(Refusal([&] { document.Remove(std::vector<uint32_t>{SecondJoint}, gpu); }),
              "'second' is a joint of the skin of 'skinned', which would stay");
    EXPECT_EQ(Refusal([&] { document.Duplicate(std::vector<uint32_t>{Skinned}, gpu); }),
              "'skinned' is deformed by a skin or morph targets: it cannot be duplicated here");
    EXPECT_EQ(Refusal([&] { document.Reparent(std::vector<uint32_t>{Slider}, Rider, scene::kNone, gpu); }),
              "'slider' cannot be put below 'rider', which is below it");
    EXPECT_EQ(Refusal([&] { document.Reparent(std::vector<uint32_t>{Slider}, Slider, scene::kNone, gpu); }),
              "'slider' cannot be put below itself");
    EXPECT_FALSE(document.CanUndo());
    EXPECT_EQ(Saved(), before);
}

// The second scene has the joints, too, and another node with their skin.
TEST_F(HierarchyEditTest, WhatAnotherSceneNeedsStays) {
    using namespace moving;
    test::GltfDocument source = moving::Document();
    const size_t twin = source.Add("nodes", {{"name", "twin"}, {"mesh", 0}, {"skin", 0}});
    source.json["scenes"].push_back({{"nodes", {FirstJoint, SecondJoint, twin}}});
    Open(source);
    const std::string before = Saved();
    EXPECT_EQ(Refusal([&] {
                  document.Remove(std::vector<uint32_t>{Skinned, FirstJoint, SecondJoint}, gpu);
              }),
              "'first' is a joint of the skin of 'twin', which is in another scene of the file");
    EXPECT_EQ(
        Refusal([&] { document.Reparent(std::vector<uint32_t>{FirstJoint}, Slider, scene::kNone, gpu); }),
        "'first' is in another scene of the file, too, which would lose it");
    EXPECT_EQ(Saved(), before);
    document.Reparent(std::vector<uint32_t>{FirstJoint}, SecondJoint, scene::kNone, gpu);
    EXPECT_EQ(test::Json::parse(Saved())["scenes"][1]["nodes"], test::Json({size_t{SecondJoint}, twin}));
    EXPECT_EQ(Refusal([&] {
                  document.Reparent(std::vector<uint32_t>{FirstJoint}, scene::kNone, scene::kNone, gpu);
              }),
              "'first' is in another scene of the file, too, which would lose it");
}

// Other indices would then name other nodes.
TEST_F(HierarchyEditTest, AnUnknownExtensionKeepsTheIndicesOfNodes) {
    test::GltfDocument source = moving::Document();
    source.json["extensionsUsed"].push_back("VENDOR_names_nodes");
    source.json["extensions"]["VENDOR_names_nodes"]["node"] = moving::Eye;
    Open(source);
    document.Remove(std::vector<uint32_t>{moving::Slider}, gpu);
    const test::Json saved = test::Json::parse(Saved());
    EXPECT_EQ(saved["nodes"][moving::Eye]["name"], "eye");
    EXPECT_EQ(saved["nodes"][moving::Slider], test::Json::object());
    EXPECT_EQ(saved["scenes"][0]["nodes"], test::Json({0, 1, 2, moving::Eye}));
    EXPECT_EQ(saved["animations"], source.json["animations"]);
}

// The items of the menu at the pointer are 20 pixels high.
// A scale of 0 has no inverse; what is removed does not count as anywhere else.
TEST_F(HierarchyEditTest, CollapsedNodesComeBackAndWhatIsRemovedIsOutOfTheBounds) {
    test::GltfDocument source = moving::Document();
    source.json["nodes"][moving::Rider]["scale"] = {0, 0, 0};
    Open(source);
    const glm::vec3 least = document.Scene().bounds.min, most = document.Scene().bounds.max;
    document.Remove(std::vector<uint32_t>{moving::Slider}, gpu);
    document.Remove(std::vector<uint32_t>{moving::Skinned, moving::FirstJoint, moving::SecondJoint}, gpu);
    EXPECT_TRUE(document.Scene().bounds.IsEmpty());
    Repeat(&Document::Undo, 2);
    EXPECT_TRUE(document.IsPresent(moving::Rider));
    EXPECT_EQ(document.Scene().bounds.min, least);
    EXPECT_EQ(document.Scene().bounds.max, most);
}

TEST_F(EditorTest, WhatIsDeletedCannotBeSelected) {
    Play(OpenCornell() + "select tall block\n");
    Workspace& work = editor.Work();
    const uint32_t node = work.selectedNode.value();
    Play("key delete\n");
    work.Select(node);
    EXPECT_FALSE(work.selectedNode);
    work.DuplicateSelection();
    EXPECT_EQ(work.document.EditCount(), 1u);
}

TEST_F(EditorTest, WhatIsAddedIsSavedAndUndone) {
    const std::string before = (folder.Path() / "before.gltf").string();
    const std::string after = (folder.Path() / "after.gltf").string();
    const std::string undone = (folder.Path() / "undone.gltf").string();
    std::string script = OpenCornell() + "scene " + before + "\n";
    for (const int y : {128, 148, 168, 193, 213})
        script += "mouse 300 100\nkey shift+a\nmouse 330 " + std::to_string(y) + "\nclick left\n";
    Play(script + "expect edits 5\nexpect selected Camera\nscene " + after + "\n");
    Workspace& work = editor.Work();
    const std::vector<scene::Light>& shown = work.document.Scene().lights;
    ASSERT_EQ(shown.size(), 3u);
    EXPECT_TRUE(work.gpu.IsLightVisible(2));
    EXPECT_EQ(work.gpu.Light(1), shown[1]);
    const scene::SceneData saved = scene::LoadGltf(after);
    ASSERT_EQ(saved.lights.size(), 3u);
    for (size_t i = 0; i < 3; ++i) {
        EXPECT_EQ(saved.lights[i].type, shown[i].type);
        EXPECT_EQ(saved.lights[i].name, shown[i].name);
        EXPECT_EQ(saved.lights[i].intensity, shown[i].intensity);
        EXPECT_EQ(saved.lights[i].lightToWorld, shown[i].lightToWorld);
    }
    EXPECT_EQ(saved.nodes[7].name, "Empty");
    const scene::CameraView view = scene::ViewOf(saved.cameras.at(1), work.camera.View().aspect);
    EXPECT_EQ(view.eye, work.camera.View().eye);
    EXPECT_LT(glm::length(view.forward - work.camera.View().forward), 1e-6f);
    EXPECT_EQ(view.yFov, work.camera.View().yFov);
    // All lights are halfway to the pivot, in the middle of the picture; the last one is drawn last
    Play("size 640x400\nkey escape\nmouse 320 196\nclick left\nexpect selected Directional light\n");
    work.panels.icons = false;
    Play("size 640x400\nkey escape\nmouse 320 196\nclick left\nwait\n");
    EXPECT_NE(work.document.NameOf(work.selectedNode.value_or(0)), "Directional light");
    Play("size 640x400\nkey ctrl+z\nkey ctrl+z\nkey ctrl+z\nkey ctrl+z\nkey ctrl+z\nexpect nodes 4\nscene " +
         undone + "\n");
    EXPECT_FALSE(work.gpu.IsLightVisible(0));
    EXPECT_EQ(TextOf(undone), TextOf(before));
}

// Rows of the panel are 20 pixels high; the first one is at 92, the field of the search at 65.
TEST_F(EditorTest, KeysAndDragsEditTheHierarchy) {
    Play(OpenCornell() +
         "select tall block\nkey ctrl+d\nexpect selected tall block.001\nexpect nodes 5\n"
         "key f2\ntext copy\nkey enter\nexpect selected copy\nexpect edits 2\n"
         "mouse 60 152\ndrag left 10 -40\nexpect message 'copy' is below 'short block'\n"
         "mouse 60 112\ndrag left 10 20\nexpect message 'short block' cannot be put below 'copy'\n"
         "mouse 60 132\ndrag left 0 200\nexpect message 'copy' is a root\nexpect edits 4\n"
         "select short block\nkey delete\nexpect message deleted 1 node\nexpect selected nothing\n"
         "expect nodes 4\nkey ctrl+z\nexpect selected short block\nkey ctrl+z\nkey ctrl+z\nkey ctrl+z\n"
         "key ctrl+z\nexpect edits 0\nexpect nodes 4\nexpect selected short block\n");
}

TEST_F(EditorTest, ClicksAndKeysSelectRows) {
    Play(OpenCornell() +
         "mouse 60 112\nclick left\nexpect selected short block\n"
         "mouse 60 152\nclick ctrl+left\nexpect selected short block, camera\n"
         "mouse 60 92\nclick shift+left\nexpect selected camera, tall block, short block, room\n"
         "mouse 60 132\nclick ctrl+left\nexpect selected camera, short block, room\n"
         "mouse 60 112\npress left\nexpect selected camera, short block, room\n"
         "release left\nexpect selected short block\n"
         "key down\nexpect selected tall block\nkey shift+up\nkey shift+up\n"
         "expect selected tall block, short block, room\nkey end\nexpect selected camera\n"
         "key down\nexpect selected camera\nkey home\nexpect selected room\nkey up\nexpect selected room\n"
         // Several are dragged at once
         "mouse 60 132\nclick ctrl+left\nmouse 60 92\ndrag left 10 20\n"
         "expect message 2 nodes are below 'short block'\nexpect edits 1\nexpect selected room, tall "
         "block\nframes 1\n");
    Workspace& work = editor.Work();
    const auto rows = [&] { return work.hierarchy.Rows().size(); };
    EXPECT_EQ(rows(), 4u);
    Play("size 640x400\nkey left\nexpect selected short block\nkey left\n");
    EXPECT_EQ(rows(), 2u) << "it is closed";
    Play("size 640x400\nkey right\nkey right\nexpect selected room\n");
    EXPECT_EQ(rows(), 4u);
    const glm::dvec3 eye = work.camera.View().eye;
    Play("size 640x400\nmouse 60 132\nclick left\nclick left\nexpect selected tall block\n");
    EXPECT_NE(work.camera.View().eye, eye) << "a double click frames";
    Play("size 640x400\nmouse 320 200\nclick left\nwait\nkey home\n");
    EXPECT_EQ(work.camera.View().eye, eye) << "without the focus, Home is the camera's";
}

TEST_F(EditorTest, SearchListsMatchesAndTakesTheKeys) {
    Play(OpenCornell() + "select tall block\nmouse 60 65\nclick left\ntext BLOCK\nkey down\nkey delete\n" +
         "expect selected tall block\nexpect edits 0\n");
    const Hierarchy& hierarchy = editor.Work().hierarchy;
    EXPECT_EQ(hierarchy.Rows().size(), 2u);
    Play("size 640x400\nmouse 60 92\nclick left\nkey f2\ntext stone\nkey enter\nexpect edits 1\n");
    EXPECT_EQ(hierarchy.Rows().size(), 1u) << "the name is another one";
    Play("size 640x400\nkey escape\nexpect selected stone\n");
    EXPECT_EQ(hierarchy.Rows().size(), 4u);
    Play("size 640x400\nmouse 60 65\nclick left\ntext camera\nkey escape\nframes 1\n");
    EXPECT_EQ(hierarchy.Rows().size(), 4u) << "in the field, too";
    EXPECT_EQ(editor.Work().HierarchyFilter(), "");
}

TEST_F(EditorTest, EyesHideTheirRowAndTheKeyHidesTheSelection) {
    Play(OpenCornell() + "select short block, tall block\nmouse 145 92\nclick left\nexpect edits 1\n" +
         "expect selected short block, tall block\n");
    const auto visible = [&] {
        std::string names;
        for (const uint32_t node : editor.Work().document.Scene().nodeOrder)
            if (editor.Work().document.IsVisible(node)) names += editor.Work().document.NameOf(node) + ' ';
        return names;
    };
    EXPECT_EQ(visible(), "short block tall block camera ");
    Play("size 640x400\nkey H\nexpect edits 2\n");
    EXPECT_EQ(visible(), "camera ");
    Play("size 640x400\nmouse 145 92\nclick left\nkey ctrl+z\nkey ctrl+z\n");
    EXPECT_EQ(visible(), "short block tall block camera ");
}

}  // namespace raygraph::editor::hierarchy_test
