// The editor played from scripts, without a window.
#include "editor/app/script.h"

#include <fstream>
#include <span>
#include <string>

#include "base/error.h"
#include "renderer/image/image.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::editor {

namespace {

class ScriptTest : public testing::VulkanTest {
  protected:
    void Play(const std::string& text) {
        const std::filesystem::path file = folder.Path() / "script.txt";
        std::ofstream(file) << text;
        Script(file).Play(editor, screen);
    }
    // The message of the error that playing ends with.
    std::string Failure(const std::string& text) {
        try {
            Play(text);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    }
    std::string OpenCornell() const {
        return std::string("size 640x400\nopen ") + RAYGRAPH_SOURCE_DIR "/scenes/cornell.gltf\nwait\n";
    }

    test::TemporaryFolder folder;
    Editor editor{Device()};
    PictureScreen screen;
};

}  // namespace

TEST_F(ScriptTest, OpensEmptyAndLeavesABrokenFileAside) {
    Play("size 320x200\nframes 2\n");
    const std::filesystem::path broken = folder.Path() / "broken.gltf";
    std::ofstream(broken) << "{ \"asset\": 3 }";
    Play(OpenCornell());
    const size_t nodes = editor.Work().document.Scene().nodes.size();
    EXPECT_GT(nodes, 0u);
    Play("open " + broken.string() + "\nwait\nexpect message broken.gltf\n");
    EXPECT_EQ(editor.Work().document.Scene().nodes.size(), nodes) << "the scene that was there stays";
}

TEST_F(ScriptTest, TogglesPicksEditsAndUndoes) {
    Play(OpenCornell() +
         "view raster\nframes 3\nkey R\nexpect view path-traced\nkey R\nexpect view raster\n"
         "mouse 320 120\nclick left\nwait\n");
    ASSERT_TRUE(editor.Work().selectedMaterial) << "the back wall is there";
    const uint32_t material = *editor.Work().selectedMaterial;
    const glm::vec4 color = editor.Work().document.Scene().materials[material].baseColorFactor;
    Play("material base 1 0 0\nexpect edits 1\nkey ctrl+z\nexpect edits 0\n");
    EXPECT_EQ(editor.Work().document.Scene().materials[material].baseColorFactor, color);
    Play("key ctrl+y\nexpect edits 1\n");
}

TEST_F(ScriptTest, DragTurnsTheCameraAndSizesMayBeAny) {
    Play(OpenCornell() + "view raster\n");
    const glm::vec3 eye = editor.Work().camera.View().eye;
    Play("size 640x400\nmouse 320 200\ndrag left 60 0\n");
    EXPECT_NE(editor.Work().camera.View().eye, eye);
    EXPECT_FALSE(editor.Work().selectedNode) << "a drag is no click";
    Play("size 1x1\nsize 37x911\nsize 0x0\nsize 700x20\nsize 640x400\nframes 2\n");
}

TEST_F(ScriptTest, SavesTheWindow) {
    const std::filesystem::path file = folder.Path() / "window.png";
    Play(OpenCornell() + "view raster\nkey F1\nkey G\nkey T\nframes 4\nwindow " + file.string() + "\n");
    std::ifstream stream(file, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(stream), {});
    const image::Image8 picture = image::DecodeImage8(std::as_bytes(std::span(bytes)), "window.png");
    EXPECT_EQ(picture.width, 640u);
    EXPECT_EQ(picture.height, 400u);
    size_t bright = 0;
    for (size_t i = 0; i < picture.rgba.size(); i += 4) bright += picture.rgba[i] > 150;
    EXPECT_GT(bright, 200u) << "text and picture";
}

TEST_F(ScriptTest, FailuresNameTheLine) {
    EXPECT_NE(Failure("frames 1\n\nsmile\n").find("script.txt:3: smile"), std::string::npos);
    EXPECT_NE(Failure("expect view raster\n").find("it is 'path-traced'"), std::string::npos);
    EXPECT_NE(Failure("key Nokey\n").find("Nokey"), std::string::npos);
    EXPECT_NE(Failure("size big\n").find("script.txt:1"), std::string::npos);
}

TEST_F(ScriptTest, KeysWhileFlyingOnlyFly) {
    Play(OpenCornell() +
         "view raster\nmouse 320 200\npress right\nkey ctrl+q\nkey R\nexpect view raster\n"
         "release right\nkey R\nexpect view path-traced\n");
}

TEST_F(ScriptTest, ReloadSaysThatThereAreNoSources) {
    Play("key F5\nexpect message --shaders\n");
}

}  // namespace raygraph::editor
