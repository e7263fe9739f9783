// Plays what somebody does who opens a model for the first time: looks, edits, lights, saves, and renders it.
#include <gtest/gtest.h>
#include <imgui.h>

#include "base/files.h"
#include "editor/app/scene_view.h"
#include "renderer/image/image.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/editor/editor_test.h"
#include "tests/support/own_cache.h"
#include "tests/support/text_files.h"

namespace raygraph::editor {

namespace {

#ifdef RAYGRAPH_BUILT_PROGRAM

class FirstHourTest : public EditorTest {
  protected:
    FirstHourTest() : EditorTest({.render = {RAYGRAPH_BUILT_PROGRAM, "render"}}) {}
};

TEST_F(FirstHourTest, FromAModelToItsPicture) {
    const std::filesystem::path model = folder / "model.gltf", picture = folder / "picture.png";
    std::filesystem::copy_file(test::SourceFile("scenes/cornell.gltf"), model);
    image::WriteHdr(folder / "sky.hdr", {8, 4, std::vector<float>(8 * 4 * 4, 0.5f)});
    test::Put(folder / "bad.glb", "no model");
    const auto open = [&](const std::string& name) {
        return "open " + (folder / name).string() + "\nwait\n";
    };
    Play("size 1000x620\nview surface\nframes 1\n" + open("bad.glb") + "expect message bad.glb: \n" +
         open("model.gltf") + "expect nodes 4\n" + open("sky.hdr"));
    // Looks at it from all sides
    Play(
        "size 1000x620\nkey 1\nkey 3\nkey 7\nkey 5\nkey 5\nkey f\n"
        "select tall block, short block\nkey h\nkey ctrl+z\nkey f\nkey escape\n");
    // Edits it
    Play(
        "size 1000x620\nkey delete\nexpect message nothing is selected\nexpect nodes 4\n"
        "select tall block\nkey ctrl+d\nkey f2\ntext tower\nkey enter\nexpect selected tower\n"
        "expect nodes 5\nexpect edits 2\n"
        "key delete\nexpect nodes 4\nkey ctrl+z\nexpect nodes 5\nexpect selected tower\n");
    // Saves it with its look, and renders it
    Play(
        "size 1000x620\nexposure 0.5\nwhite-point 5600\naperture 0.01\nkey ctrl+s\nexpect message saved \n"
        "key ctrl+shift+e\nrender 32x24 2 " +
        picture.string() + "\nkey enter\nwait\nexpect message rendered \nkey escape\nkey escape\n");
    const image::Image8 rendered = image::DecodeImage8(ReadFile(picture), "picture.png");
    EXPECT_EQ(rendered.width, 32u);
    EXPECT_EQ(rendered.height, 24u);

    const scene::SceneData saved = scene::LoadGltf(model);
    EXPECT_EQ(std::ranges::count(saved.nodes, std::string("tower"), &scene::Node::name), 1);
    std::string message;
    const std::optional<SceneView> view = ReadView(model, message);
    ASSERT_TRUE(view) << message;
    EXPECT_EQ(view->environment.filename(), "sky.hdr");
    EXPECT_EQ(view->whitePoint, 5600);
    Play("close\nexpect leaving yes\n");
}

#endif

}  // namespace
}  // namespace raygraph::editor
