// A whole visit to the editor: everything that a user does in turn, and more often than a user would.
#include <fstream>
#include <sstream>
#include <string>

#include "tests/editor/editor_test.h"

namespace raygraph::editor {

class VisitTest : public EditorTest {};

TEST_F(VisitTest, OpensOrbitsTogglesEditsUndoesPicksSavesResizesAndForgivesABrokenFile) {
    const std::string broken = (folder.Path() / "broken.glb").string();
    std::ofstream(broken) << "glTF and no more";
    const auto file = [&](const char* name) { return (folder.Path() / name).string(); };
    std::ostringstream script;
    script
        << "size 400x260\nopen " << test::SourceFile("scenes/cornell.gltf").string() << "\nwait\n"
        << "mouse 200 100\ndrag left 40 10\ndrag middle 5 5\nwheel 1\nframes 2\n"
        << "key R\nframes 2\nkey R\nframes 2\nkey W\nframes 2\nview relative error\nframes 3\nkey W\nkey W\n"
        << "mouse 200 90\nclick left\nwait\nmaterial base 0.1 0.9 0.2\nexpect edits 1\nkey ctrl+z\nexpect "
           "edits 0\n"
        << "key T\nframes 2\nkey G\nframes 2\nkey F1\nframes 2\nkey F1\nkey T\nkey G\n"
        << "picture " << file("picture.png") << "\nscene " << file("scene.glb") << "\nwindow "
        << file("window.png") << "\n";
    for (int i = 0; i < 200; ++i) script << "size " << 1 + i * 73 % 400 << "x" << 1 + i * 51 % 260 << "\n";
    script << "size 400x260\nopen " << broken
           << "\nwait\nexpect message broken.glb\nview path-traced\nsamples 2\nexpect edits 0\n";
    Play(script.str());
    for (const char* name : {"picture.png", "scene.glb", "window.png"})
        EXPECT_GT(std::filesystem::file_size(file(name)), 100u) << name;
    EXPECT_FALSE(editor.Work().document.Scene().nodes.empty());
}

}  // namespace raygraph::editor
