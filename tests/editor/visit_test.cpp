// Tests a whole visit to the editor: everything that a user does, and more often than a user would.
#include <array>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include "base/files.h"
#include "editor/session/file/content_hash.h"
#include "renderer/image/image.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/editor/editor_test.h"

namespace raygraph::editor::visit_test {

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
    // Counts the colors in a picture's first columns
    const auto colors = [](const image::Image8& picture, uint32_t columns) {
        std::set<std::array<uint8_t, 3>> seen;
        for (size_t i = 0; i < picture.rgba.size(); i += 4)
            if (i / 4 % picture.width < columns)
                seen.insert({picture.rgba[i], picture.rgba[i + 1], picture.rgba[i + 2]});
        return seen.size();
    };
    const auto read = [&](const char* name) { return image::DecodeImage8(ReadFile(file(name)), name); };
    const image::Image8 picture = read("picture.png"), window = read("window.png");
    EXPECT_EQ(window.width, 400u);
    EXPECT_EQ(window.height, 260u);
    const glm::ivec2 origin = editor.PictureOrigin();
    EXPECT_EQ(int(picture.width), 400 - 2 * origin.x) << "panels of one width on both sides";
    EXPECT_LT(int(picture.height), 260 - origin.y) << "and a status line";
    EXPECT_GT(colors(picture, picture.width), 100u) << "a room";
    const size_t panelColors = colors(window, static_cast<uint32_t>(origin.x));
    EXPECT_GT(panelColors, 5u) << "a panel on its left, with text";
    EXPECT_GT(colors(window, window.width), 2 * panelColors) << "and the picture beside it";
    // The undone edit has left nothing, neither here nor in the file
    const scene::SceneData original = scene::LoadGltf(test::SourceFile("scenes/cornell.gltf"));
    EXPECT_EQ(session::HashOf(scene::LoadGltf(file("scene.glb"))), session::HashOf(original));
    const Document& document = editor.Work().document;
    EXPECT_EQ(document.File(), file("scene.glb"));
    EXPECT_FALSE(document.IsEdited());
    EXPECT_EQ(document.Scene().nodes.size(), original.nodes.size());
    for (size_t i = 0; i < original.materials.size(); ++i)
        EXPECT_EQ(document.Scene().materials.at(i).baseColorFactor, original.materials[i].baseColorFactor);
}

}  // namespace raygraph::editor::visit_test
