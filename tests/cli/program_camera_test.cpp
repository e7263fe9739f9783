// Tests several cameras in one run. It needs a device.

#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_files.h"

namespace raygraph::program_camera_test {
namespace {

using test::ProgramResult;
using test::RunProgram;
using test::TemporaryFolder;
using test::TextOf;

constexpr const char* kAbove = "'0 1 3.2 0 1 0 0 1 0 30'";

void RunWell(const TemporaryFolder& folder, const std::string& line) {
    const ProgramResult result = RunProgram(folder, line);
    EXPECT_EQ(result.exitCode, 0) << line << "\n" << result.messages;
}

TEST(ProgramCamera, SeveralHaveTheBytesThatEachHasByItself) {
    const TemporaryFolder folder;
    const std::string options = "render @cornell.gltf --size 16x12 --spp 3 --aov depth ";
    RunWell(folder, options + "--camera camera --camera " + kAbove +
                        " -o of_{camera}.exr -o of_{camera}.png --report of_{camera}.json");
    RunWell(folder, options + "--camera camera -o a.exr -o a.png");
    RunWell(folder, options + "--camera " + kAbove + " -o b.exr -o b.png");
    for (const char* kind : {".exr", ".png"}) {
        EXPECT_EQ(TextOf(folder / (std::string("of_camera") + kind)),
                  TextOf(folder / (std::string("a") + kind)));
        EXPECT_EQ(TextOf(folder / (std::string("of_1") + kind)), TextOf(folder / (std::string("b") + kind)));
    }
    EXPECT_NE(TextOf(folder / "a.png"), TextOf(folder / "b.png"));
    EXPECT_TRUE(std::filesystem::exists(folder / "of_camera.json"));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.Path()), {}), 10);
}

TEST(ProgramCamera, EachIsRenderedInEachFrame) {
    const TemporaryFolder folder;
    const std::string options = "render @cornell.gltf --size 8x8 --spp 2 ";
    const std::string line = options + "--frames 0:0.04:0.04 --camera 0 --camera " + kAbove +
                             " -o {camera}.##.exr --checkpoint 60 --resume {camera}.##.exr --progress json";
    const ProgramResult result = RunProgram(folder, line);
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_NE(result.messages.find(R"("picture":"frame 2 of 2, camera 1 of 2")"), std::string::npos)
        << result.messages;
    RunWell(folder, options + "--at 0.04 --camera " + kAbove + " -o whole.exr");
    EXPECT_EQ(TextOf(folder / "1.01.exr"), TextOf(folder / "whole.exr"));
    RunWell(folder, options + "--at 0.04 --camera 0 -o whole.exr");
    EXPECT_EQ(TextOf(folder / "0.01.exr"), TextOf(folder / "whole.exr"));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.Path()), {}), 5);
    // All four pictures exist, so the same command has nothing to do
    const ProgramResult again = RunProgram(folder, line);
    EXPECT_EQ(again.exitCode, 0);
    EXPECT_EQ(again.output,
              "0.00.exr is complete: 2 samples a pixel\n1.00.exr is complete: 2 samples a pixel\n"
              "0.01.exr is complete: 2 samples a pixel\n1.01.exr is complete: 2 samples a pixel\n");
}

TEST(ProgramCamera, OneThatIsMissingIsRenderedAlone) {
    const TemporaryFolder folder;
    const std::string line = std::string("render @cornell.gltf --size 8x8 --spp 2 --camera 0 --camera ") +
                             kAbove + " -o {camera}.exr --checkpoint 60 --resume {camera}.exr";
    RunWell(folder, line);
    const std::string first = TextOf(folder / "0.exr"), second = TextOf(folder / "1.exr");
    EXPECT_NE(second, first);
    for (const char* missing : {"0.exr", "1.exr"}) {
        std::filesystem::remove(folder / missing);
        RunWell(folder, line);
        EXPECT_EQ(TextOf(folder / "0.exr"), first) << "without " << missing;
        EXPECT_EQ(TextOf(folder / "1.exr"), second) << "without " << missing;
    }
}

TEST(ProgramCamera, PicturesThatCannotAllBeAreNotBegun) {
    const TemporaryFolder folder;
    const auto expectRefused = [&](const std::string& options, const std::string& text) {
        const ProgramResult result =
            RunProgram(folder, "render @cornell.gltf --size 8x8 --spp 1 --camera 0 " + options);
        EXPECT_EQ(result.exitCode, 2) << options;
        EXPECT_NE(result.messages.find(text), std::string::npos) << options << "\n" << result.messages;
        EXPECT_EQ(std::ranges::count(result.messages, '\n'), 1) << result.messages;
        EXPECT_TRUE(std::filesystem::is_empty(folder.Path())) << options;
    };
    expectRefused("--camera 1 -o a.exr", "\"a.exr\" has no {camera}");
    expectRefused("--camera 1 -o {camera}.exr --report r.json", "\"r.json\" has no {camera}");
    expectRefused("--camera 1", "\"render.png\" has no {camera}");
    expectRefused("--camera 0 -o {camera}.exr", "0.exr is to be written twice");
    expectRefused("--camera no_such -o {camera}.exr", "--camera: there is no camera \"no_such\"");
    expectRefused("--camera 7 -o {camera}.exr", "--camera: ");
    expectRefused("--camera '0 1' -o {camera}.exr", "--camera: ");
    expectRefused("--camera 1 -o {camera}.exr --resume {camera}.exr", "only with --checkpoint");
}

}  // namespace
}  // namespace raygraph::program_camera_test
