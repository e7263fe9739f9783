// Tests backdrop and ground in the editor's views; render_words_test.cpp has those of a render.
#include <gtest/gtest.h>

#include "base/files.h"
#include "renderer/image/image.h"
#include "renderer/scene/model/ground.h"
#include "tests/editor/editor_test.h"
#include "tests/support/text_files.h"

namespace raygraph::editor {

namespace {

class BackdropTest : public EditorTest {
  protected:
    // Opens the Cornell box, seen from above with its surroundings.
    void Open() {
        editor.Work().panels.hierarchy = editor.Work().panels.inspector = false;
        Play("size 64x99\nview raster\nopen " + test::SourceFile("scenes/cornell.gltf").string() +
             "\nwait\n");
        editor.Work().UseCamera("orbit 30 30");
    }
    // Returns the pixel in the lower left corner.
    glm::ivec4 Corner(const std::string& script) {
        Play("size 64x99\n" + script + "picture " + (folder / "a.png").string() + "\nwait\n");
        const image::Image8 picture = image::DecodeImage8(ReadFile(folder / "a.png"), "a.png");
        const uint8_t* const corner = &picture.rgba[size_t{4} * picture.width * (picture.height - 1)];
        return {corner[0], corner[1], corner[2], corner[3]};
    }
    void ExpectGround() {
        const scene::SceneData& scene = editor.Work().document.Scene();
        const auto last = static_cast<uint32_t>(scene.instances.size());
        ASSERT_TRUE(editor.Work().gpu.HasInstance(last));
        EXPECT_EQ(editor.Work().gpu.Transform(last).matrix,
                  scene::GroundUnder(scene.bounds).instances[0].objectToWorld);
    }
};

TEST_F(BackdropTest, IsBehindTheSceneInPathTracedAndRasterViews) {
    Open();
    EXPECT_EQ(Corner("frames 1\n"), glm::ivec4(0, 0, 0, 255));
    for (const char* view : {"view raster\n", "budget 0\nview path-traced\nsamples 1\n"}) {
        SCOPED_TRACE(view);
        EXPECT_EQ(Corner(std::string("backdrop 1,0,0.21586\n") + view), glm::ivec4(255, 0, 128, 255));
        EXPECT_EQ(Corner(std::string("backdrop transparent\n") + view), glm::ivec4(0));
        EXPECT_EQ(Corner(std::string("backdrop map\n") + view), glm::ivec4(0, 0, 0, 255));
    }
}

TEST_F(BackdropTest, GroundFollowsTheSceneAndIsNoPartOfIt) {
    Open();
    Workspace& work = editor.Work();
    const std::string plain = "size 64x99\n";
    Play(plain + "ground on\nframes 1\nexpect nodes 4\n");
    ExpectGround();
    const glm::ivec4 black(0, 0, 0, 255);
    EXPECT_EQ(Corner("frames 2\n"), black) << "the raster view does not draw it";

    // A copy takes the place that the ground had
    Play(plain + "select tall block\nkey ctrl+d\nframes 1\nexpect nodes 5\n");
    ExpectGround();
    const uint32_t node = *work.selectedNode;
    const float before = work.document.Scene().bounds.min.y;
    glm::mat4x3 lower = work.document.LocalTransform(node);
    lower[3].y -= 2.0f;
    work.Apply(TransformEdit{node, lower});
    Play(plain + "frames 1\n");
    EXPECT_LT(work.document.Scene().bounds.min.y, before);
    ExpectGround();
    Play(plain + "key ctrl+z\nkey ctrl+z\nframes 1\nexpect nodes 4\n");
    ExpectGround();

    Play(plain + "key escape\nmouse 1 68\nkey shift+f\nclick left\nwait\nexpect message in focus: \n" +
         "click left\nwait\nexpect selected nothing\nscene " + (folder / "a.gltf").string() + "\n");
    EXPECT_EQ(test::TextOf(folder / "a.gltf").find("ground"), std::string::npos);
    Play(plain + "ground off\nframes 1\n");
    EXPECT_FALSE(work.gpu.HasInstance(static_cast<uint32_t>(work.document.Scene().instances.size())));
}

}  // namespace
}  // namespace raygraph::editor
