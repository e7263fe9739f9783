// Tests unsaved edits, and the actions that might lose them.
#include <fstream>
#include <string>

#include "base/files.h"
#include "editor/app/edit.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/editor/editor_test.h"
#include "tests/support/error_of.h"

namespace raygraph::editor::unsaved_test {

namespace {

constexpr glm::vec4 kBlue{0.25f, 0.5f, 1.0f, 1.0f};

class UnsavedTest : public EditorTest {
  protected:
    void Edit() {
        Workspace& work = editor.Work();
        scene::Material material = work.document.Scene().materials[0];
        material.baseColorFactor = kBlue;
        work.Apply(MaterialEdit{0, material});
        work.document.Settle();
    }
};

}  // namespace

TEST_F(UnsavedTest, AsksBeforeEditsAreLost) {
    const std::string file = (folder.Path() / "saved.gltf").string();
    const std::string other = test::SourceFile("scenes/furnace_sphere.gltf").string();
    Play(OpenCornell() + "view raster\nmouse 320 120\nclick left\nwait\nscene " + file + "\n");
    const uint32_t material = *editor.Work().selectedMaterial;
    const std::string edit = "material base 0.25 0.5 1\n";
    // Escape keeps everything, whatever was about to lose the edits
    Play(edit);
    for (const std::string& loss :
         {std::string("close\n"), std::string("key ctrl+q\n"), "open " + other + "\nwait\n"})
        Play("size 640x400\n" + loss +
             "expect asking yes\nexpect leaving no\nkey escape\nexpect asking no\n");
    Play("wait\nexpect leaving no\nexpect edits 1\nopen " + (folder.Path() / "sky.hdr").string() +
         "\nexpect asking no\nwait\n");
    EXPECT_EQ(editor.Work().document.File(), file);
    EXPECT_NE(scene::LoadGltf(file).materials[material].baseColorFactor.x, 0.25f);
    // If the file cannot be written, everything is kept, too
    std::ofstream(file, std::ios::app) << " ";
    Play(
        "size 640x400\nkey ctrl+q\nkey s\nexpect asking no\nexpect leaving no\nexpect edits 1\n"
        "expect message has changed\n");
    // Discards the edits
    Play("size 640x400\nopen " + other +
         "\nexpect asking yes\nkey d\nwait\nexpect asking no\nexpect edits 0\n");
    EXPECT_EQ(editor.Work().document.File(), other);
    // Saves the edits
    Play(OpenCornell() + "mouse 320 120\nclick left\nwait\nscene " + file + ".gltf\n" + edit +
         "close\nkey s\nexpect leaving yes\n");
    EXPECT_EQ(scene::LoadGltf(file + ".gltf").materials[material].baseColorFactor.x, 0.25f);
    EXPECT_FALSE(editor.Work().document.IsEdited());
}

// No edit existed when the other scene was opened.
TEST_F(UnsavedTest, AsksAboutEditsThatWereMadeWhileAnotherSceneWasLoaded) {
    const std::filesystem::path cornell = test::SourceFile("scenes/cornell.gltf");
    const std::filesystem::path other = test::SourceFile("scenes/furnace_sphere.gltf");
    Play(OpenCornell() + "view raster\n");
    Workspace& work = editor.Work();
    editor.Open(other);
    Edit();
    Play("size 640x400\nwait\nframes 2\nexpect asking yes\nexpect edits 1\nkey escape\n");
    EXPECT_EQ(work.document.File(), cornell);
    Play("size 640x400\nwait\nframes 2\nexpect asking no\nexpect edits 1\nkey ctrl+z\n");
    // The other question is answered first
    editor.Open(other);
    Edit();
    Play("size 640x400\nwait\nkey escape\nclose\nexpect asking yes\n");
    work.Open(other);
    Play("size 640x400\nwait\nframes 2\nexpect asking yes\nkey escape\nframes 2\nexpect asking yes\n");
    EXPECT_EQ(work.document.File(), cornell);
    Play("size 640x400\nkey d\nframes 2\nexpect asking no\nexpect edits 0\n");
    EXPECT_EQ(work.document.File(), other);
}

TEST_F(UnsavedTest, NothingIsAskedWhereNothingIsLost) {
    Play("size 320x200\nclose\nexpect asking no\nexpect leaving yes\n");
}

// The device fails, as it might in a window.
TEST_F(UnsavedTest, IsSavedBesideTheSceneWhenTheEditorEndsByAnError) {
    class Lost final : public Screen {
      public:
        std::optional<TextureId> Begin(Renderer&, rhi::Extent2D) override {
            throw Error(ErrorKind::DeviceLost, "the device is lost in Trace", -4);
        }
        void End(Renderer&, TextureId) override {}
    } lost;
    const auto end = [&] {
        return testing::ErrorOf([&] {
            FrameInput input;
            input.extent = {320, 200};
            RunFrames(editor, lost, {.poll = [&](double) { return input; }, .setTitle = [](auto&) {}});
        });
    };
    std::filesystem::copy(test::SourceFile("scenes/cornell.gltf"), folder / "a.gltf");
    const auto original = ReadFile(folder / "a.gltf");
    Play("size 320x200\nopen " + (folder / "a.gltf").string() + "\nwait\n");
    EXPECT_STREQ(end().what(), "the device is lost in Trace") << "there is nothing to save";
    for (const char* name : {"a-recovered.gltf", "a-recovered-2.gltf"}) {
        Edit();
        const Error error = end();
        const std::filesystem::path saved = folder / name;
        EXPECT_EQ(error.what(), "the device is lost in Trace; unsaved edits are in " + saved.string());
        EXPECT_EQ(error.Kind(), ErrorKind::DeviceLost);
        EXPECT_EQ(error.Result(), -4);
        ASSERT_TRUE(std::filesystem::exists(saved));
        EXPECT_EQ(scene::LoadGltf(saved).materials[0].baseColorFactor, kBlue);
    }
    EXPECT_EQ(ReadFile(folder / "a.gltf"), original);
    std::filesystem::remove(folder / "a.gltf");
    EXPECT_NE(std::string(end().what()).find("; unsaved edits are lost: "), std::string::npos);
}

}  // namespace raygraph::editor::unsaved_test
