// Tests the view that is stored beside a scene.
#include "editor/app/scene_view.h"

#include <gtest/gtest.h>

#include "renderer/image/image.h"
#include "renderer/scene/model/camera_view.h"
#include "tests/editor/editor_test.h"
#include "tests/support/current_folder.h"
#include "tests/support/text_files.h"

namespace raygraph::editor {

namespace {

namespace fs = std::filesystem;

class SceneViewTest : public EditorTest {
  protected:
    SceneViewTest() {
        fs::create_directory(folder / "set");
        fs::copy_file(test::SourceFile("scenes/cornell.gltf"), Scene());
        image::WriteHdr(folder / "set" / "sky.hdr", {8, 4, std::vector<float>(8 * 4 * 4, 0.5f)});
    }
    fs::path Scene() const { return folder / "set" / "box.gltf"; }
    static std::string Open(const fs::path& file) { return "open " + file.string() + "\nwait\n"; }
};

TEST_F(SceneViewTest, ComesBackWithItsMapFromAnotherFolder) {
    Play("size 320x200\nview surface\n" + Open(Scene()) + Open(folder / "set" / "sky.hdr") +
         "mouse 160 100\ndrag left 37 -21\nfov 51\naperture 0.07\nexposure 0.7\nwhite-point 3700\nbackdrop "
         "blur:12\nground on\nframes 1\n");
    Workspace& work = editor.Work();
    work.gpu.SetEnvironment({.radiance = {0.5f, 1.0f, 2.0f}, .rotation = -0.75f});
    Play("size 320x200\nkey ctrl+s\nexpect message saved the view: \n");
    const SceneView saved = work.ShownView();
    EXPECT_EQ(saved.environment.filename(), "sky.hdr");

    // A scene without a stored view keeps the map, but neither camera nor lens
    const std::string plain = Open(test::SourceFile("scenes/cornell.gltf"));
    Play("size 320x200\n" + plain);
    EXPECT_EQ(work.ShownView().environment, saved.environment);
    EXPECT_EQ(work.ShownView().aperture, 0.0f);
    EXPECT_NE(work.ShownView().camera, saved.camera);

    work.RemoveEnvironmentMap();
    work.SetWhitePoint(6500);
    work.backdrop.reset();
    work.hasGround = false;
    fs::rename(folder / "set", folder / "moved");
    Play("size 320x200\nexposure 0\n" + Open(folder / "moved" / "box.gltf"));
    SceneView back = work.ShownView();
    EXPECT_EQ(back.backdrop, "blur:12");
    EXPECT_TRUE(back.hasGround);
    EXPECT_EQ(back.environment, fs::absolute(folder / "moved" / "sky.hdr"));
    back.environment = saved.environment;
    EXPECT_NEAR(back.rotation, saved.rotation, 1e-4f);
    back.rotation = saved.rotation;
    const scene::CameraView was = scene::ViewFromText(saved.camera, 1.0f),
                            is = scene::ViewFromText(back.camera, 1.0f);
    EXPECT_EQ(is.eye, was.eye);
    EXPECT_LT(glm::distance(is.forward, was.forward) + glm::distance(is.up, was.up), 1e-6f);
    back.camera = saved.camera;
    EXPECT_EQ(back, saved);
}

TEST_F(SceneViewTest, WhatIsGivenTakesPrecedence) {
    WriteView(Scene(), {.environment = folder / "set" / "sky.hdr", .exposureEv = 2.0f, .whitePoint = 4000});
    Play("size 320x200\nview surface\nframes 1\n");
    editor.Work().Open(Scene(), {}, [](SceneView& seen) {
        seen.environment.clear();
        seen.usesScene = false;
        seen.radiance = glm::vec3(0.25f);
        seen.exposureEv = -1.0f;
    });
    Play("size 320x200\nwait\n");
    const SceneView shown = editor.Work().ShownView();
    EXPECT_EQ(shown.environment, "");
    EXPECT_EQ(editor.Work().gpu.Environment().radiance, glm::vec3(0.25f));
    EXPECT_EQ(shown.exposureEv, -1.0f);
    EXPECT_EQ(shown.whitePoint, 4000);
}

// A view is that of its scene alone: it replaces the map of the scene before, and one that is still being loaded.
TEST_F(SceneViewTest, LightOfTheSceneBeforeDoesNotStay) {
    WriteView(Scene(), {.environment = folder / "set" / "sky.hdr", .exposureEv = 2.0f});
    const fs::path dark = folder / "set" / "dark.gltf", lost = folder / "set" / "lost.gltf";
    fs::copy_file(Scene(), dark);
    fs::copy_file(Scene(), lost);
    WriteView(dark, {.usesScene = false, .radiance = glm::vec3(0.0f)});
    WriteView(lost, {.environment = folder / "set" / "gone.hdr", .radiance = glm::vec3(3.0f)});
    Workspace& work = editor.Work();
    Play("size 320x200\nview surface\n" + Open(Scene()));
    EXPECT_EQ(work.EnvironmentFile().filename(), "sky.hdr");
    EXPECT_EQ(work.SettingsToSave().show.tonemap.exposureEv, 0.0f) << "the exposure is the scene's";
    Play("size 320x200\nopen " + (folder / "set" / "sky.hdr").string() + "\n" + Open(dark));
    EXPECT_EQ(work.EnvironmentFile(), "");
    EXPECT_EQ(work.gpu.Environment().radiance, glm::vec3(0.0f));
    Play("size 320x200\n" + Open(lost) + "expect message gone.hdr\n");
    EXPECT_TRUE(work.gpu.Environment().usesScene) << "the scene's light, not the black one before";
    EXPECT_EQ(work.ShownView().environment, fs::absolute(folder / "set" / "gone.hdr")) << "saved again";
    EXPECT_EQ(work.ShownView().radiance, glm::vec3(3.0f));
    EXPECT_EQ(work.ShownView().exposureEv, 0.0f);
    Play("size 320x200\nexposure 3\nkey ctrl+s\n");
    EXPECT_EQ(work.SettingsToSave().show.tonemap.exposureEv, 0.0f) << "it is the scene's once it is stored";
}

TEST_F(SceneViewTest, MapIsFoundByRelativePaths) {
    fs::create_directory(folder / "work");
    fs::copy_file(folder / "set" / "sky.hdr", folder / "work" / "sky.hdr");
    const test::CurrentFolder work(folder / "work");
    std::string message;
    WriteView("../set/box.gltf", {.environment = "sky.hdr"});
    const std::optional<SceneView> view = ReadView("../set/box.gltf", message);
    ASSERT_TRUE(view) << message;
    EXPECT_TRUE(fs::equivalent(view->environment, folder / "work" / "sky.hdr")) << view->environment;
}

TEST_F(SceneViewTest, SceneOpensWithoutAFileThatCannotBeRead) {
    std::string message;
    EXPECT_FALSE(ReadView(Scene(), message));
    EXPECT_EQ(message, "");
    for (const char* text :
         {"{", "[]", R"({"display": {"exposure": "a"}})", R"({"environment": {"radiance": [1, 2]}})"}) {
        SCOPED_TRACE(text);
        test::Put(ViewFileOf(Scene()), text);
        EXPECT_FALSE(ReadView(Scene(), message));
        EXPECT_NE(message.find("box.gltf.view.json: "), std::string::npos) << message;
        EXPECT_NE(message.find("; ignored"), std::string::npos) << message;
    }
    Play("size 320x200\nview surface\n" + Open(Scene()) +
         "expect message box.gltf.view.json\nexpect nodes 4\n");
    test::Put(ViewFileOf(Scene()), R"({"camera": {"view": "upstairs"}})");
    Play("size 320x200\n" + Open(Scene()) + "expect message box.gltf.view.json: \nexpect nodes 4\n");
    test::Put(ViewFileOf(Scene()), R"({"backdrop": {"behind": "fog"}})");
    Play("size 320x200\n" + Open(Scene()) + "expect message fog\nexpect nodes 4\n");
}

}  // namespace
}  // namespace raygraph::editor
