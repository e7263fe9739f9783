// Tests that the editor explains the pixel that is clicked.
#include <gmock/gmock.h>

#include <algorithm>

#include "editor/app/explained_pixel.h"
#include "editor/session/explain/path_text.h"
#include "tests/editor/editor_test.h"

namespace raygraph::editor::explained_pixel_test {

namespace {

using ::testing::HasSubstr;

class ExplainedPixelTest : public EditorTest {};

}  // namespace

TEST_F(ExplainedPixelTest, AClickExplainsTheBrightestSampleAndLeadsToItsObjects) {
    Workspace& work = editor.Work();
    work.panels.hierarchy = work.panels.inspector = false;
    Play("size 320x440\nopen " + test::SourceFile("scenes/cornell.gltf").string() +
         "\nview path-traced\nwait\nsamples 4\nmouse 160 90\nclick left\nwait\n");
    EXPECT_FALSE(work.explained.Shown()) << "the panel is closed";
    Play("size 320x440\nkey escape\nkey I\nframes 2\nmouse 160 90\nclick left\nwait\nframes 2\n");
    ASSERT_TRUE(work.explained.Shown()) << work.message;
    const session::Explanation shown = *work.explained.Shown();
    const session::ExplainedPath path = work.explained.Path();
    EXPECT_GE(shown.values.size(), 4u);
    EXPECT_TRUE(path.isExact);
    EXPECT_EQ(path.sample, session::BrightestOf(shown, 1).front());
    EXPECT_THAT(session::CauseOf(path, shown.names), HasSubstr("lamp"));
    EXPECT_EQ(session::RowOf(path.vertices[0], shown.names).place,
              session::LinesOf(path, 0, shown.names, shown.origin).front().substr(10));

    // The rays of the path join up in the world, from the camera on
    const std::vector<PathLine> lines = LinesOfPath(path, shown.origin, 10.0);
    EXPECT_LT(glm::distance(lines.front().from, work.view.Camera().eye), 1e-4);
    for (size_t i = 1; i < path.vertices.size(); ++i) {
        const auto isRayOf = [](size_t vertex) {
            return [=](const PathLine& line) {
                return line.vertex == vertex &&
                       (line.kind == PathLine::Kind::Ray || line.kind == PathLine::Kind::Escaping);
            };
        };
        const auto before = std::ranges::find_if(lines, isRayOf(i - 1)),
                   next = std::ranges::find_if(lines, isRayOf(i));
        ASSERT_TRUE(before != lines.end() && next != lines.end());
        EXPECT_LT(glm::distance(before->to, next->from), 1e-3);
    }

    // Another sample, until the view changes; the path stays in the world
    const uint32_t other = path.sample == 0 ? 1 : 0;
    work.explained.AskPath(work.view, other);
    FrameInput idle;
    idle.extent = {320, 440};
    while (work.explained.IsPending()) editor.Frame(idle, screen);
    EXPECT_EQ(work.explained.Path().sample, other);
    EXPECT_TRUE(work.explained.Path().isExact);
    Play("size 320x440\nmouse 160 90\nwheel 2\nframes 2\n");
    EXPECT_FALSE(work.explained.IsCurrent(work.view));
    work.explained.AskPath(work.view, path.sample);
    EXPECT_FALSE(work.explained.IsPending());
    EXPECT_TRUE(work.explained.Shown());
    Play(OpenCornell());
    EXPECT_FALSE(work.explained.Shown()) << "another scene has other objects";
}

}  // namespace raygraph::editor::explained_pixel_test
