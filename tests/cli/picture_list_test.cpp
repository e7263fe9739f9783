#include "editor/cli/picture_list.h"

#include "editor/cli/arguments.h"
#include "editor/cli/command_files.h"
#include "tests/cli/cli_test.h"

namespace raygraph::cli::picture_list_test {
namespace {

TEST(PictureList, NamesHaveNumberAndCameraInTheirPlaces) {
    EXPECT_EQ(Named("a/#b/{camera}.##.{camera}.exr", {7, "top"}), "a/#b/top.07.top.exr");
    EXPECT_EQ(Named("{camera}.exr", {{}, "top"}), "top.exr");
    EXPECT_EQ(Named("{camera}/x.##.exr", {7, {}}), "{camera}/x.07.exr") << "only in the last part";
    EXPECT_EQ(Named("{camera}.##.exr", {}), "{camera}.##.exr");
    EXPECT_EQ(Named("{camera}.exr", {{}, "{camera}"}), "{camera}.exr") << "what is put in is no place";
    EXPECT_TRUE(HasCameraPlaceholder("a/x{camera}y.exr"));
    EXPECT_FALSE(HasCameraPlaceholder("{camera}/x.exr"));
    EXPECT_FALSE(HasCameraPlaceholder("{Camera}.exr"));
}

TEST(PictureList, CameraInANameIsANameOrANumber) {
    EXPECT_EQ(CameraFileName("top-left_2", 5), "top-left_2");
    EXPECT_EQ(CameraFileName("3", 5), "3");
    EXPECT_EQ(CameraFileName("../a/b.c", 5), "___a_b_c") << "leaves no folder";
    EXPECT_EQ(CameraFileName("{camera}#", 5), "_camera__");
    EXPECT_EQ(CameraFileName("0 1 3.2 0 1 0 0 1 0 30", 5), "5");
    EXPECT_EQ(CameraFileName("0,1,3.2,0,1,0,0,1,0,30", 5), "5");
    EXPECT_EQ(CameraFileName("", 5), "5");
}

TEST(PictureList, OfNeitherFramesNorCamerasThereIsOnePicture) {
    const auto pictures = PicturesToRender({});
    ASSERT_EQ(pictures.size(), 1u);
    EXPECT_FALSE(pictures[0].at || pictures[0].camera || pictures[0].name.number || pictures[0].name.camera);
    EXPECT_EQ(pictures[0].label, "");
}

TEST(PictureList, FrameByFrameAndInEachCameraByCamera) {
    RenderArguments arguments;
    arguments.frames = FrameRange{1.0, 1.5, 0.5};
    arguments.cameras = {"top", "0 1 5 0 0 0 0 1 0 40"};
    arguments.outputs = {ParseOutput("{camera}.#.exr"), ParseOutput("{camera}.#.png")};
    arguments.resume = "{camera}.#.exr";
    const auto pictures = PicturesToRender(arguments);
    ASSERT_EQ(pictures.size(), 4u);
    EXPECT_EQ(pictures[1].label, "frame 1 of 2, camera 2 of 2");
    EXPECT_EQ(pictures[2].label, "frame 2 of 2, camera 1 of 2");
    EXPECT_EQ(pictures[1].at, 1.0);
    EXPECT_EQ(pictures[2].at, 1.5);
    EXPECT_EQ(pictures[2].camera, "top");
    EXPECT_EQ(pictures[3].camera, arguments.cameras[1]) << "as given, not as in names";
    EXPECT_EQ(Named("{camera}.#", pictures[3].name), "1.3");

    const CommandFiles files = FilesOf(arguments);
    EXPECT_EQ(files.outputs,
              (std::vector<std::filesystem::path>{"top.2.exr", "top.2.png", "1.2.exr", "1.2.png", "top.3.exr",
                                                  "top.3.png", "1.3.exr", "1.3.png"}));
    EXPECT_EQ(files.updated.size(), 4u);

    arguments.cameras.clear();
    EXPECT_EQ(PicturesToRender(arguments)[1].label, "frame 2 of 2");
    arguments.frames.reset();
    arguments.cameras = {"0", "1"};
    EXPECT_EQ(PicturesToRender(arguments)[1].label, "camera 2 of 2");
}

}  // namespace
}  // namespace raygraph::cli::picture_list_test
