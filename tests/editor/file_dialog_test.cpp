// Tests which files the dialog lists and how paths are completed, and that a refused answer keeps the dialog.
#include "editor/app/file_dialog.h"

#include <gmock/gmock.h>

#include <fstream>

#include "editor/app/workspace.h"
#include "tests/editor/editor_test.h"
#include "tests/support/environment_variable.h"

namespace raygraph::editor::file_dialog_test {

namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class FileDialogTest : public EditorTest {
  protected:
    FileDialogTest() {
        for (const char* name : {"Fox.GLB", "fog.gltf", "apple.txt", ".hidden.gltf"})
            std::ofstream(folder / name) << "1234";
        std::filesystem::create_directory(folder / "more");
    }
};

}  // namespace

TEST_F(FileDialogTest, ListsFoldersFirstAndOnlyFilesOfItsKinds) {
    const std::vector<std::string_view> kinds{".gltf", ".glb"};
    EXPECT_THAT(ListFolder(folder.Path(), kinds),
                ElementsAre(FolderEntry{"more", true, 0}, FolderEntry{"fog.gltf", false, 4},
                            FolderEntry{"Fox.GLB", false, 4}));
    EXPECT_EQ(ListFolder(folder.Path(), {}).size(), 4u);
    EXPECT_TRUE(ListFolder(folder / "none", {}).empty());
}

TEST_F(FileDialogTest, CompletesNamesAsFarAsTheyAgree) {
    const std::string base = folder.Path().string() + "/";
    EXPECT_EQ(CompletedPath(base + "a"), base + "apple.txt");
    EXPECT_EQ(CompletedPath(base + "mo"), base + "more/");
    EXPECT_EQ(CompletedPath(base + "x"), base + "x");
    std::ofstream(folder / "apples.txt") << "";
    EXPECT_EQ(CompletedPath(base + "ap"), base + "apple");
    const test::EnvironmentVariable home("HOME", folder.Path());
    EXPECT_EQ(CompletedPath("~/mo"), "~/more/");
    EXPECT_EQ(ExpandHome("~/more"), folder / "more");
    EXPECT_EQ(ExpandHome("~fox"), "~fox");
}

TEST_F(FileDialogTest, ARefusedAnswerKeepsTheDialogAndSaysWhy) {
    Play(OpenCornell() + "key ctrl+o\nframes 2\ntext /nowhere/at/all.gltf\nframes 1\nkey enter\nframes 2\n");
    Workspace& work = editor.Work();
    EXPECT_EQ(work.document.File().filename(), "cornell.gltf");
    const uint64_t before = work.log->Revision();
    Play("size 640x400\nkey T\nframes 2\n");
    EXPECT_FALSE(work.panels.statistics) << "the dialog is still open";
    EXPECT_EQ(work.log->Revision(), before);
    Play("size 640x400\nkey escape\nframes 2\nkey T\nframes 2\n");
    EXPECT_TRUE(work.panels.statistics) << "Escape closes it";
}

TEST_F(FileDialogTest, AfterARefusedAnswerOrAFolderTheNameIsTypedOn) {
    const std::string cornell = test::SourceFile("scenes/cornell.gltf").string();
    Play(
        "size 640x400\nview raster\nkey ctrl+o\nframes 2\ntext /nowhere/at/all.gltf\nframes 1\nkey enter\n"
        "frames 2\ntext " +
        (folder / "more").string() + "\nframes 1\nkey enter\nframes 2\ntext " + cornell +
        "\nframes 1\nkey enter\nframes 2\nwait\n");
    EXPECT_EQ(editor.Work().document.File(), cornell);
}

TEST_F(FileDialogTest, SavesUnderTheTypedName) {
    Play(OpenCornell() + "view raster\nkey ctrl+e\nframes 2\nkey ctrl+a\ntext " +
         (folder / "p.png").string() + "\nframes 1\nkey enter\nframes 2\nwait\n");
    EXPECT_TRUE(std::filesystem::exists(folder / "p.png")) << editor.Work().message;
}

TEST_F(FileDialogTest, AMissingFileIsRefusedBeforeEditsAreAskedFor) {
    Play(OpenCornell() +
         "mouse 320 120\nclick left\nwait\nmaterial base 1 0 0\nopen /nowhere/at/all.gltf\n"
         "expect asking no\nexpect message there is no such file\nexpect edits 1\n");
}

}  // namespace raygraph::editor::file_dialog_test
