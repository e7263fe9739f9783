// Tests messages and exit statuses of requests that the program refuses. It needs no device.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "base/text.h"
#include "editor/cli/completion.h"
#include "renderer/image/image.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/environment_variable.h"
#include "tests/support/own_cache.h"
#include "tests/support/source_file.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_files.h"

namespace raygraph::program_usage_test {
namespace {

using test::ProgramResult;
using test::RunProgram;

// Requests that are refused: the exit status, the command and what its only line has to contain.
constexpr const char* kRefusals = R"(
2 |  | --help
2 | render @cornell.gltf --bogus | --bogus
2 | render @cornell.gltf --size 0x4 | --size | 0x4
2 | render @cornell.gltf -o a.tiff | a.tiff
2 | render @cornell.gltf -o a.png --aov albedo | --aov | .exr
2 | render @cornell.gltf -o a.png --view raster --error 0.1 | --view raster | --error
2 | render @cornell.gltf -o a.exr --view raster --light-group a=light | --view raster | --light-group
2 | render @cornell.gltf -o a.png --view raster --max-depth 1 | --view raster | --max-depth
2 | render @cornell.gltf -o a.png --shadows maps | --shadows | --view raster
2 | render @cornell.gltf -o a.exr --view albedo --aov direct | --aov direct | path-traced
2 | render @cornell.gltf -o a.png --light-group a=light | --light-group | .exr
2 | render @cornell.gltf -o a.exr --view albedo --light-group a=light | --light-group
2 | render @cornell.gltf -o a.exr --light-group lamp=candle | --light-group lamp=candle: no material, light or node
2 | render @cornell.gltf -o a.png --view depth --spp 4 | depth | --spp
2 | render @cornell.gltf -o a.png --view normals --exposure 1 | normals | --exposure
2 | render @cornell.gltf -o a.png --view normals --tonemap agx | normals | --tonemap
2 | render @cornell.gltf -o a.png --view normals --nee off | normals | --nee
2 | render @cornell.gltf -o a.png --view normals --light none | there is no light for --light
2 | render @cornell.gltf -o a.png --view raster --mis off | raster | --mis
2 | render @cornell.gltf -o a.png --view raster --aperture 1 | raster | --aperture
2 | render @cornell.gltf -o a.png --view albedo --background 1,1,1 | albedo | --background
2 | render @cornell.gltf -o a.png --view albedo --env sky.hdr | albedo | --env
2 | render @cornell.gltf -o a.png --view raster --transparent on | --transparent
2 | render @cornell.gltf --sample-offset 4294967295 --spp 2 -o a.exr | --sample-offset
2 | render @cornell.gltf -o a.png --camera 'no such camera' | no such camera
3 | render @cornell.gltf -o a.png --device 'no such device' | no such device
2 | render @cornell.gltf --resume part.exr --spp 20 -o a.png | part.exr | albedo,normal,depth,instance,material

An option that has an effect here, so that only the scene is missing:
4 | render none.gltf --view raster --brdf lambert --multiscatter off | none.gltf
4 | render none.gltf --view raster --background 1,1,1 --shadows maps | none.gltf
4 | render none.gltf --view ray-cost --nee off --max-depth 2 --background 1,1,1 | none.gltf
4 | render none.gltf --view normals --spp 4 --sampler pcg --seed 2 | none.gltf
4 | render none.gltf --quiet --progress none | none.gltf

Input that is missing or broken:
4 | render none.gltf -o a.exr | none.gltf
4 | render broken.gltf -o a.exr | broken.gltf
4 | render @cornell.gltf --env sky.hdr -o a.exr | sky.hdr
4 | render @cornell.gltf --env none.hdr -o a.exr | none.hdr
4 | render @cornell.gltf --resume none.exr --spp 2 | none.exr
4 | render @cornell.gltf --settings-from none.exr | none.exr
4 | info broken.gltf | broken.gltf
4 | bench none.gltf | none.gltf
4 | graph none.gltf | none.gltf
4 | merge a.exr b.exr -o c.exr | a.exr
4 | denoise a.exr -o c.exr | a.exr
4 | denoise broken.gltf -o c.exr | broken.gltf

An output that cannot be written, before anything is read:
1 | render none.gltf -o missing/a.png | missing
1 | render none.gltf -o a.png --report missing/r.json | missing
1 | merge a.exr b.exr -o missing/c.exr | missing
1 | denoise a.exr -o missing/c.exr | missing
1 | bench none.gltf --json missing/b.json | missing

Crops, white points and light:
2 | render @cornell.gltf --size 30x21 --crop 18,5,13,9 | --crop: a region of 13x9 pixels from 18, 5 on, in a picture of 30x21
2 | render @cornell.gltf --size 30x21 --crop 0,20,1,2 | in a picture of 30x21
2 | render @cornell.gltf --crop 1,2,3,4,5 | is not X,Y,W,H
2 | render @cornell.gltf --crop 1,2,0,4 | is not X,Y,W,H
2 | render @cornell.gltf --crop -1,2,3,4 | is not X,Y,W,H
2 | render @cornell.gltf --crop 0,0,4,4 --view raster | drawn as a whole
2 | render @cornell.gltf --crop 0,0,4,4 --view overdraw | drawn as a whole
2 | render @cornell.gltf --white-point 999 | --white-point
2 | render @cornell.gltf --white-point 25001 | --white-point
2 | render @cornell.gltf --white-point warm | --white-point
2 | render @cornell.gltf --white-point '' | --white-point
2 | render @cornell.gltf --white-point 3200 -o a.exr | --white-point is of a .png
2 | render @cornell.gltf --white-point auto --view albedo | no light
4 | render @furnace_sphere.gltf --quiet --white-point auto --background 0,0,0 | has no light to take the color of
2 | render @cornell.gltf --light studio --background 0,0,0 | --background and --light studio exclude each other
2 | render @cornell.gltf --light studio --env sky.hdr | --env and --light studio exclude each other
2 | edit @cornell.gltf --light studio --env sky.hdr | --env and --light studio exclude each other
2 | render @cornell.gltf --background 0,0,0 --env-tint 1,1,1 | --env-tint is of a map or the studio, which --background replaces
2 | render @cornell.gltf --light none --env-tint 1,1,1 | --env-tint is of a map: it needs --env or --light studio; cornell.gltf has none
2 | render @cornell.gltf --light lamp | lamp
2 | graph @cornell.gltf --light lamp | lamp

Checkpoints, shards, several cameras and devices:
2 | render @cornell.gltf --checkpoint 1 -o a.png | --checkpoint saves renders that can be resumed
2 | render @cornell.gltf --checkpoint 1 -o a.exr --exr-type half | leaves out their sums
2 | render @cornell.gltf --checkpoint 0 -o a.exr | --checkpoint: "0"
2 | render @cornell.gltf --frames 0:1:1 --resume f.#.exr -o f.#.exr | only with --checkpoint
2 | render @cornell.gltf --time 1 --checkpoint 1 --resume f.exr -o f.exr | is never complete
2 | render @cornell.gltf --frames 0:1:1 --checkpoint 1 --resume f.exr -o f.#.exr | "f.exr" has no single run of #
4 | render @cornell.gltf --resume a.exr -o a.exr --spp 8 | a.exr
2 | render @cornell.gltf --shard 0/2 --time 5 -o a.exr | --time knows none beforehand; give --spp
2 | render @cornell.gltf --shard 0/2 --error 0.1 --spp 8 -o a.exr | --error knows none beforehand; give --spp
2 | render @cornell.gltf --shard 0/2 -o a.png | there is no -o OUT.####.exr
2 | render @cornell.gltf --shard 0/2 | there is no -o OUT.####.exr
2 | render @cornell.gltf --shard 0/2 --view depth -o a.exr | --view depth is not averaged
2 | render @cornell.gltf --shard 0/2 -o a.#.b.#.exr | more than one run of #
2 | render @cornell.gltf --shard 0/2 --resume a.exr -o b.exr | --resume with --shard needs --spp
2 | render @cornell.gltf --shard 1/2 --spp 4 --sample-offset 4294967294 -o a.exr | beyond the last, 4294967295
2 | render @cornell.gltf --shard 2/2 -o a.exr | --shard: "2/2"
2 | render @cornell.gltf --camera 0 --camera 1 -o a.exr | "a.exr" has no {camera}
2 | render @cornell.gltf --camera 0 --camera 1 -o {camera}.exr --report r.json | "r.json" has no {camera}
2 | render @cornell.gltf --camera 0 --camera 1 | "render.png" has no {camera}
2 | render @cornell.gltf --camera 0 --camera 0 -o {camera}.exr | 0.exr is to be written twice
2 | render @cornell.gltf --camera 0 --camera no_such -o {camera}.exr | --camera: there is no camera "no_such"
2 | render @cornell.gltf --camera 0 --camera '0 1' -o {camera}.exr | --camera: 
2 | render @cornell.gltf --camera 0 --camera 1 -o {camera}.exr --resume {camera}.exr | only with --checkpoint
2 | render @cornell.gltf --view-from above | --view-from: "above" is not one of front, back, right, left, top, bottom or side
2 | render @cornell.gltf --orbit 30 | --orbit: "30" is not AZ,EL
2 | render @cornell.gltf --orbit 30,91 | --orbit: "30,91" is not AZ,EL
2 | render @cornell.gltf --orbit 30,20 --view-from top | --camera, --view-from and --orbit exclude each other
2 | explain @cornell.gltf --pixel 1,1 --camera 0 --view-from top | --camera, --view-from and --orbit exclude each other
2 | render @cornell.gltf --turntable 0 | --turntable: "0"
2 | render @cornell.gltf --turntable 4 -o a.png | "a.png" has no single run of # for the numbers of --turntable
2 | render @cornell.gltf --turntable 4 --camera 0 | --orbit or --view-from gives its start
2 | render @cornell.gltf --turntable 4 --frames 0:1:1 | --turntable and --frames exclude each other
2 | render @cornell.gltf --contact-sheet -o a.exr | --contact-sheet: a.exr has no place for several pictures; give a .png
2 | render @cornell.gltf --contact-sheet --report r.json | --report is of a picture
2 | render @cornell.gltf -o a.exr --devices 0 --device 0 | --device excludes --devices
2 | render @cornell.gltf -o a.exr --devices x | --devices: "x" is not a whole number
2 | render @cornell.gltf -o a.exr --devices 0, | --devices: 
3 | render @cornell.gltf -o a.exr --devices 4000 | no suitable Vulkan device for '4000': 0 '

Animations, points, roots, logs and progress:
4 | render -o a.png box.gltf --at 1 --clips fly | --clips: there is no animation "fly"; the scene has 0 "rise", 1 "sink"
4 | bench box.gltf --at 1 --clips fly | --clips: there is no animation "fly"; the scene has 0 "rise", 1 "sink"
4 | graph box.gltf --at 1 --clips fly | --clips: there is no animation "fly"; the scene has 0 "rise", 1 "sink"
2 | render -o a.png box.gltf --clips rise | --clips: animations play at a time, and none is given
2 | bench box.gltf --clips rise | --clips: animations play at a time, and none is given
2 | graph box.gltf --clips rise | --clips: animations play at a time, and none is given
2 | graph box.gltf --at soon | --at
2 | render -o a.png @points_and_lines.gltf --points 0 | --points: "0" is not a radius
2 | info @points_and_lines.gltf --points 0 | --points: "0" is not a radius
2 | bench @points_and_lines.gltf --points 0 | --points: "0" is not a radius
2 | graph @points_and_lines.gltf --points 0 | --points: "0" is not a radius
2 | info --devices --lines 1 | --lines
2 | info --devices --root . | --root is of a scene file, and --devices lists none
2 | edit --variant red | --variant
2 | info --devices --variant red | --variant
4 | info @cornell.gltf --variant red | --variant: there is no variant "red"; the scene has no variants
4 | info @cornell.gltf --root gone | --root: "gone": No such file or directory
4 | graph @cornell.gltf --root gone | --root: "gone": No such file or directory
4 | render @cornell.gltf --root broken.gltf | --root: "broken.gltf": it is not a folder
4 | bench @cornell.gltf --root broken.gltf | --root: "broken.gltf": it is not a folder
1 | info @cornell.gltf --log none/a.log | none
2 | info broken.gltf --log broken.gltf | to be read and to be written
2 | info @cornell.gltf --log '' | --log
2 | info @cornell.gltf --quiet -v | --quiet
2 | render none.gltf --quiet --progress plain | --quiet and --progress plain exclude each other
2 | bench none.gltf --quiet --progress json | --quiet and --progress json exclude each other
)";

// Nothing is printed on stdout, one line that begins with the program's name on stderr, and no file changes.
TEST(Program, RefusalIsOneLineAndLeavesTheFolderAsItWas) {
    const test::TemporaryFolder folder;
    test::WriteBox(folder);
    test::Put(folder / "broken.gltf", R"({"asset": {"version": "2.0"}, "scene": 3})");
    test::Put(folder / "sky.hdr", "no picture");
    session::WriteRenderFile(folder / "part.exr", test::MakeRender(0, 16));
    const auto contents = [&] {
        std::map<std::string, std::string> files;
        for (const auto& file : std::filesystem::directory_iterator(folder.Path()))
            files[file.path().filename()] = file.is_regular_file() ? test::TextOf(file.path()) : "";
        return files;
    };
    const auto before = contents();
    std::istringstream lines(kRefusals);
    size_t count = 0;
    for (std::string line; std::getline(lines, line);) {
        if (line.find(" | ") == std::string::npos) continue;
        SCOPED_TRACE(line);
        std::vector<std::string> fields;
        for (size_t at = 0; at != std::string::npos;) {
            const size_t end = line.find(" |", at);
            fields.push_back(line.substr(at, end == std::string::npos ? end : end - at));
            at = end == std::string::npos ? end : std::min(end + 3, line.size());
        }
        const ProgramResult result = RunProgram(folder, fields.at(1));
        EXPECT_EQ(std::to_string(result.exitCode), fields[0]) << result.messages;
        EXPECT_EQ(result.output, "");
        EXPECT_TRUE(result.messages.starts_with("raygraph: ")) << result.messages;
        EXPECT_EQ(std::ranges::count(result.messages, '\n'), 1) << result.messages;
        for (size_t i = 2; i < fields.size(); ++i)
            EXPECT_NE(result.messages.find(fields[i]), std::string::npos) << result.messages << fields[i];
        ++count;
    }
    EXPECT_GT(count, 100u);
    EXPECT_EQ(contents(), before);
}

TEST(Program, HelpAndVersionGoToStdout) {
    for (const char* option : {"--help", "--version"}) {
        const ProgramResult result = RunProgram(test::TemporaryFolder(), option);
        EXPECT_EQ(result.exitCode, 0);
        EXPECT_NE(result.output.find("raygraph"), std::string::npos);
        EXPECT_EQ(result.messages, "");
    }
}

TEST(Program, MergeNeedsNoDevice) {
    const test::TemporaryFolder folder;
    session::WriteRenderFile(folder / "a.exr", test::MakeRender(0, 16));
    session::WriteRenderFile(folder / "b.exr", test::MakeRender(16, 48, 1.0f));
    session::WriteRenderFile(folder / "c.exr", test::MakeRender(63, 4));
    const ProgramResult merged = RunProgram(folder, "merge a.exr b.exr -o m.exr");
    EXPECT_EQ(merged.exitCode, 0) << merged.messages;
    EXPECT_NE(merged.output.find("64 samples"), std::string::npos) << merged.output;
    EXPECT_EQ(merged.messages, "");
    const std::string told = RunProgram(folder, "merge a.exr b.exr -o m.exr -v").messages;
    for (const char* text : {" a.exr: 16 samples of ", " b.exr: 48 samples of ", " m.exr: 64 samples of "})
        EXPECT_NE(told.find(text), std::string::npos) << told << "lacks" << text;
    EXPECT_EQ(session::ReadRenderFile(folder / "m.exr").samples, (session::SampleRanges{{0, 64}}));

    const ProgramResult refused = RunProgram(folder, "merge m.exr c.exr -o n.exr");
    EXPECT_EQ(refused.exitCode, 4);
    EXPECT_EQ(refused.messages.find("raygraph: m.exr and c.exr "), 0u) << refused.messages;
    EXPECT_FALSE(std::filesystem::exists(folder / "n.exr"));
}

TEST(Program, InfoOfASceneNeedsNoDevice) {
    const ProgramResult result = RunProgram(test::TemporaryFolder(), "info @cornell.gltf");
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    for (const char* text : {"cornell.gltf", "triangles", "cameras", "materials", "emits"})
        EXPECT_NE(result.output.find(text), std::string::npos) << result.output << "lacks " << text;
}

}  // namespace
}  // namespace raygraph::program_usage_test

// Tests the messages of every command as its user sees them. It needs a device.
namespace raygraph::program_message_test {
namespace {

using test::EnvironmentVariable;
using test::ProgramResult;
using test::RunProgram;
using test::SceneFile;
using test::TextOf;

void ExpectHas(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text << "\n  lacks " << part;
}

void ExpectLacks(const std::string& text, const std::string& part) {
    EXPECT_EQ(text.find(part), std::string::npos) << text << "\n  has " << part;
}

// The place of the folder for pipeline caches has a file, so that the device warns.
class ProgramMessages : public ::testing::Test {
  protected:
    ProgramMessages() {
        std::ofstream(folder.Path() / "raygraph") << "no folder";
        nlohmann::json scene = nlohmann::json::parse(std::ifstream(SceneFile("cornell.gltf")));
        scene["extensionsUsed"] = {"EXT_unheard_of"};
        std::ofstream(folder / "warned.gltf") << scene;
    }

    test::TemporaryFolder folder;
    test::OwnCache cache{folder.Path()};
    const std::string deviceWarning = "raygraph: warning: pipeline cache is not saved: ";
    const std::string sceneWarning = "raygraph: warning: warned.gltf: extensionsUsed[0]: ";
};

TEST_F(ProgramMessages, WarningsOfSceneAndDeviceArriveFromRenderGraphAndBench) {
    for (const std::string line :
         {"render warned.gltf --size 16x16 --spp 1 -o a.png", "graph warned.gltf --first",
          "bench warned.gltf --size 16x16 --frames 1 --rounds 1"}) {
        const ProgramResult result = RunProgram(folder, line);
        EXPECT_EQ(result.exitCode, 0) << result.messages;
        ExpectHas(result.messages, deviceWarning);
        ExpectHas(result.messages, sceneWarning);
        ExpectLacks(result.messages, "raygraph: info: ");
    }
    EXPECT_EQ(RunProgram(folder, "graph warned.gltf --first --quiet").messages, "");
}

TEST_F(ProgramMessages, WarningsArriveFromEdit) {
    std::ofstream(folder.Path() / "script.txt")
        << "size 120x100\nopen " << (folder / "warned.gltf").string() << "\nwait\nopen "
        << (folder / "none.gltf").string() << "\nwait\n";
    const ProgramResult result = RunProgram(folder, "edit --headless-script script.txt");
    RAYGRAPH_SKIP_WITHOUT_EDITOR(result);
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    ExpectHas(result.messages, deviceWarning);
    ExpectHas(result.messages, sceneWarning);
    ExpectHas(result.messages, "none.gltf");
}

TEST_F(ProgramMessages, MoreIsSaidOnRequest) {
    const std::string line = "render @cornell.gltf --size 16x16 --spp 1 -o a.png";
    const auto messages = [&](const char* option) {
        const ProgramResult result = RunProgram(folder, line + option);
        EXPECT_EQ(result.exitCode, 0) << result.messages;
        return result.messages;
    };
    const std::string some = messages(" -v"), all = messages(" -vv");
    ExpectHas(some, "raygraph: info: [scene] cornell.gltf: ");
    ExpectHas(some, "raygraph: info: [device] device 'raygraph': ");
    ExpectHas(some, "uploaded in ");
    ExpectLacks(some, "raygraph: debug: ");
    ExpectHas(all, "raygraph: info: [scene] cornell.gltf: ");
    ExpectHas(all, "[shaders] pipeline of pathtrace/");
    ExpectHas(all, "raygraph: debug: [geometry] ");

    const EnvironmentVariable levels("RAYGRAPH_LOG", "error,geometry=debug");
    const ProgramResult chosen = RunProgram(folder, line);
    ExpectHas(chosen.messages, "raygraph: debug: [geometry] ");
    ExpectLacks(chosen.messages, "warning");
    ExpectLacks(chosen.messages, "[scene]");
}

TEST_F(ProgramMessages, EachImageOfASceneIsTimedOnRequest) {
    const ProgramResult result = RunProgram(folder, "info @texture_orientation.gltf -vv");
    ExpectHas(result.messages, "raygraph: debug: [scene] texture_orientation.gltf: images[0]");
    ExpectHas(result.messages, " PNG of ");
    ExpectLacks(RunProgram(folder, "info @texture_orientation.gltf -v").messages, " PNG of ");
}

TEST_F(ProgramMessages, GoIntoAFileAsWell) {
    const ProgramResult first = RunProgram(folder, "info warned.gltf --log a.log");
    EXPECT_EQ(first.exitCode, 0) << first.messages;
    ExpectHas(first.messages, sceneWarning);
    const std::string once = TextOf(folder.Path() / "a.log");
    ExpectHas(once, "warning scene      warned.gltf: extensionsUsed[0]: ");
    ExpectHas(once, "info    scene      warned.gltf: ");
    EXPECT_EQ(RunProgram(folder, "info none.gltf --log a.log").exitCode, 4);
    const std::string twice = TextOf(folder.Path() / "a.log");
    EXPECT_TRUE(twice.starts_with(once)) << "it is added to";
    ExpectHas(twice, "error   program    ");
    ExpectHas(twice, "none.gltf");
}

// A log is appended to as soon as it is opened, so it must be refused before.
TEST_F(ProgramMessages, LogIsNoFileThatTheCommandReadsOrWrites) {
    std::ofstream(folder / "kept") << "as it was";
    const auto expectRefused = [&](const std::string& line, const std::string& part) {
        const ProgramResult result = RunProgram(folder, line + " --log kept");
        EXPECT_EQ(result.exitCode, 2) << result.messages;
        ExpectHas(result.messages, part);
        EXPECT_EQ(TextOf(folder / "kept"), "as it was") << line;
    };
    expectRefused("render warned.gltf --env kept", "to be read and to be written");
    expectRefused("render warned.gltf --resume kept -o b.exr", "to be read and to be written");
    expectRefused("render warned.gltf --report kept", "written twice");
    expectRefused("bench warned.gltf --compare kept", "to be read and to be written");
    expectRefused("bench warned.gltf --json kept", "written twice");
    expectRefused("merge a.exr kept -o b.exr", "to be read and to be written");
    expectRefused("edit --headless-script kept", "to be read and to be written");

    std::ofstream(folder / "a.png") << "a picture";
    const ProgramResult picture = RunProgram(folder, "render warned.gltf -o a.png --log a.png");
    EXPECT_EQ(picture.exitCode, 2) << picture.messages;
    EXPECT_EQ(TextOf(folder / "a.png"), "a picture");
}

TEST_F(ProgramMessages, LogMayBeADevice) {
    const ProgramResult result =
        RunProgram(folder, "render warned.gltf -o a.png --size 8x8 --spp 1 --log /dev/null");
    EXPECT_EQ(result.exitCode, 0) << result.messages;
}

}  // namespace
}  // namespace raygraph::program_message_test

// Tests the completion of shells with the programs that read them.
namespace raygraph::program_completion_test {
namespace {

using test::RunProgram;
using test::TemporaryFolder;

// Runs a line of sh in the folder, and returns its output, stderr included.
std::string Shell(const TemporaryFolder& folder, const std::string& line) {
    const std::string whole = Text("cd '{}' && {{ {}; }} 2>&1", folder.Path().string(), line);
    std::FILE* pipe = popen(whole.c_str(), "r");
    std::string text;
    for (int c = 0; (c = std::fgetc(pipe)) != EOF;) text += static_cast<char>(c);
    pclose(pipe);
    return text;
}

bool Has(const char* program) {
    return !Shell(TemporaryFolder(), Text("command -v {}", program)).empty();
}

// Writes the output of `raygraph LINE` to a file in the folder.
void Store(const TemporaryFolder& folder, const char* line, const char* file) {
    const test::ProgramResult result = RunProgram(folder, line);
    ASSERT_EQ(result.exitCode, 0) << result.messages;
    std::ofstream(folder / file) << result.output;
}

// Returns all names that the --help of each command lists; "" is the program's own.
std::map<std::string, std::vector<std::string>> NamesInHelp() {
    std::map<std::string, std::vector<std::string>> names;
    const TemporaryFolder folder;
    std::vector<std::string> commands{""};
    const std::string overview = RunProgram(folder, "--help").output;
    std::istringstream list(overview.substr(overview.find("Commands:")));
    for (std::string line; std::getline(list, line) && !line.empty();)
        if (line.starts_with("  ") && line[2] != ' ')
            commands.push_back(line.substr(2, line.find(' ', 2) - 2));
    EXPECT_GE(commands.size(), 8u) << overview;
    commands.push_back("graph run");
    const std::regex name("--?[a-z][a-z-]*");
    for (const std::string& command : commands) {
        std::istringstream help(
            RunProgram(folder, command + (command.empty() ? " --help" : " --help-all")).output);
        for (std::string line; std::getline(help, line);) {
            if (!line.starts_with("  -")) continue;
            const std::string first = line.substr(2, line.find(' ', 2) - 2);  // "-o,--output"
            for (std::sregex_iterator i(first.begin(), first.end(), name), end; i != end; ++i)
                names[command].push_back(i->str());
        }
    }
    return names;
}

TEST(Completion, BashCompletesCommandsOptionsAndWhatTheyTake) {
    const TemporaryFolder folder;
    Store(folder, "completion bash", "c.bash");
    for (const char* file : {"my scene.gltf", "sky.hdr", "a.exr", "notes.txt"}) std::ofstream(folder / file);
    std::filesystem::create_directory(folder / "shaders");
    std::ofstream(folder / "try.bash") << R"(source ./c.bash
complete -p raygraph
try() {
    COMP_WORDS=("$@") COMP_CWORD=$(($# - 1)) COMPREPLY=()
    _raygraph
    printf '%s\n' "${COMPREPLY[@]}" | sort | tr '\n' '|'
    echo
}
)";
    EXPECT_EQ(Shell(folder, "bash -n c.bash"), "");
    EXPECT_EQ(Shell(folder, "bash -c 'source ./try.bash'"), "complete -F _raygraph raygraph\n");
    const auto completed = [&](const char* words) {
        std::string text = Shell(folder, Text("bash -c '. ./try.bash; try {}' | tail -n 1", words));
        while (text.ends_with('\n') || text.ends_with('|')) text.pop_back();
        return text;
    };
    EXPECT_EQ(completed("raygraph ren"), "render");
    EXPECT_EQ(completed("raygraph me"), "merge");
    EXPECT_EQ(completed("raygraph render --sam"), "--sample-offset|--sampler");
    EXPECT_EQ(completed("raygraph merge --sam"), "");
    EXPECT_EQ(completed("raygraph denoise \"\""), "a.exr|shaders");
    EXPECT_EQ(completed("raygraph denoise a.exr --to"), "--tonemap");
    EXPECT_EQ(completed("raygraph render --view ra"), "raster|ray-cost");
    EXPECT_EQ(completed("raygraph render --view = ra"), "raster|ray-cost") << "--view=ra, as bash has it";
    EXPECT_EQ(completed("raygraph render --progress \"\""), "auto|json|none|plain");
    EXPECT_EQ(completed("raygraph render --nee o"), "off|on");
    EXPECT_EQ(completed("raygraph render --aov albedo,no"), "albedo,normal");
    EXPECT_EQ(completed("raygraph render --size \"\""), "");
    EXPECT_EQ(completed("raygraph render \"\""), "my scene.gltf|shaders");
    EXPECT_EQ(completed("raygraph render a.gltf --env \"\""), "a.exr|shaders|sky.hdr");
    EXPECT_EQ(completed("raygraph render --resume \"\""), "a.exr|shaders");
    EXPECT_EQ(completed("raygraph render --log n"), "notes.txt");
    EXPECT_EQ(completed("raygraph edit --shaders \"\""), "shaders");
    EXPECT_EQ(completed("raygraph completion z"), "zsh");
    EXPECT_EQ(completed("raygraph graph \"\""), "my scene.gltf|run|shaders");
    EXPECT_EQ(completed("raygraph graph --fi"), "--first");
    EXPECT_EQ(completed("raygraph graph run --fi"), "");
    EXPECT_EQ(completed("raygraph graph run --fr"), "--frames");
    EXPECT_EQ(completed("raygraph graph run --output \"\""), "shaders");
}

TEST(Completion, EveryShellKnowsEveryOptionOfHelp) {
    const TemporaryFolder folder;
    const std::string bash = RunProgram(folder, "completion bash").output;
    const std::string zsh = RunProgram(folder, "completion zsh").output;
    const std::string fish = RunProgram(folder, "completion fish").output;
    const auto expect = [](const std::string& script, const std::string& text) {
        EXPECT_NE(script.find(text), std::string::npos) << "lacks " << text;
    };
    for (const auto& [command, names] : NamesInHelp()) {
        EXPECT_FALSE(names.empty()) << command;
        // Search only the command's part of the script
        const bool isWithin = command.find(' ') != command.npos;
        const std::string pattern = isWithin ? '"' + command + '"' : command;
        const size_t inBash = bash.find("\n        " + (command.empty() ? "''" : pattern) + ")");
        const size_t inZsh = command.empty() ? 0 : zsh.find("\n            " + pattern + ") _arguments");
        ASSERT_TRUE(inBash != std::string::npos && inZsh != std::string::npos) << command;
        const std::string ofBash = bash.substr(inBash, bash.find(";;\n", inBash) - inBash) + " ";
        const std::string ofZsh = zsh.substr(inZsh, zsh.find(";;\n", inZsh) - inZsh);
        for (const std::string& name : names) {
            EXPECT_TRUE(std::regex_search(ofBash, std::regex("[ ']" + name + "[ ']"))) << command << name;
            EXPECT_NE(ofZsh.find(name + "["), std::string::npos) << command << name;
            const std::string last = command.substr(command.rfind(' ') + 1);
            const std::string condition =
                command.empty() ? "__fish_use_subcommand"
                                : "__fish_seen_subcommand_from " + last +
                                      (command == "graph" ? "; and not __fish_seen_subcommand_from run" : "");
            const std::string option =
                name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
            EXPECT_TRUE(
                std::regex_search(fish, std::regex("-n '" + condition + "'[^\n]*" + option + "[ \n]")))
                << command << name;
        }
    }
    expect(zsh, "'--sampler[Random numbers]:SAMPLER:(sobol pcg tea)'");
    expect(zsh, "'--max-depth[Bias\\: end paths after N bounces");
    expect(zsh, "'1:FILE:_files -g \"*.(gltf|glb)\"'");
    expect(zsh, "'*:FILES:_files -g \"*.exr\"'");
    expect(fish, " -l sampler -x -a 'sobol pcg tea' -d 'Random numbers'");
}

TEST(Completion, ZshReadsItsScript) {
    if (!Has("zsh")) GTEST_SKIP() << "there is no zsh";
    const TemporaryFolder folder;
    Store(folder, "completion zsh", "_raygraph");
    EXPECT_EQ(Shell(folder, "zsh -n _raygraph"), "");
}

TEST(Completion, FishReadsItsScriptAndCompletes) {
    if (!Has("fish")) GTEST_SKIP() << "there is no fish";
    const TemporaryFolder folder;
    Store(folder, "completion fish", "c.fish");
    EXPECT_EQ(Shell(folder, "fish --no-execute c.fish"), "");
    EXPECT_EQ(
        Shell(folder, "fish --no-config -c 'source ./c.fish; complete -C \"raygraph render --view ra\"'"),
        "raster\tWhat the picture shows\nray-cost\tWhat the picture shows\n");
    EXPECT_EQ(Shell(folder, "fish --no-config -c 'source ./c.fish; complete -C \"raygraph graph --fi\"'"),
              "--first\tShow the first frame, which uploads and builds the scene, not a later one\n");
    EXPECT_EQ(Shell(folder, "fish --no-config -c 'source ./c.fish; complete -C \"raygraph graph run --f\"'"),
              "--frames\tNumber of frames (that of the description)\n");
}

TEST(Environment, ChoosesTheDeviceWhereNoOptionDoes) {
    const TemporaryFolder folder;
    const std::string line = "graph @small_light.gltf --size 16x16";
    const test::EnvironmentVariable chosen("RAYGRAPH_DEVICE", "no such device");
    const test::ProgramResult refused = RunProgram(folder, line);
    EXPECT_EQ(refused.exitCode, 3);
    EXPECT_EQ(refused.messages.find("raygraph: RAYGRAPH_DEVICE: "), 0u) << refused.messages;
    EXPECT_NE(refused.messages.find("'no such device'"), std::string::npos) << refused.messages;
    const test::ProgramResult other = RunProgram(folder, line + " --device 'another one'");
    EXPECT_EQ(other.exitCode, 3);
    EXPECT_EQ(other.messages.find("RAYGRAPH_DEVICE"), std::string::npos) << other.messages;

    // The name of the device that is used if none is chosen
    const test::EnvironmentVariable none("RAYGRAPH_DEVICE", "");
    const std::string render = "render @small_light.gltf --size 8x8 --spp 1 --quiet -o ";
    ASSERT_EQ(RunProgram(folder, render + "a.exr").exitCode, 0);
    const std::string name = session::ReadRenderFile(folder / "a.exr").device;
    const test::EnvironmentVariable named("RAYGRAPH_DEVICE", name);
    ASSERT_EQ(RunProgram(folder, render + "b.exr").exitCode, 0);
    EXPECT_EQ(session::ReadRenderFile(folder / "b.exr").device, name);
}

}  // namespace
}  // namespace raygraph::program_completion_test

// Tests a flawed file of each extension as a user meets it: one line, and exit code 4.
namespace raygraph::program_hostile_test {
namespace {

using Json = nlohmann::json;

// Makes a triangle with a material, a texture and an image, to which all extensions apply.
Json Scene() {
    return Json::parse(R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "extensions": {}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0, "extensions": {}}]}],
        "materials": [{"emissiveTexture": {"index": 0, "extensions": {}}, "extensions": {}}],
        "textures": [{"source": 0, "extensions": {}}],
        "images": [{"uri": "data:,%89PNG"}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
        "bufferViews": [{"buffer": 0, "byteLength": 36, "extensions": {}}],
        "buffers": [{"byteLength": 36, "uri": "data:,)" +
                       std::string(36, '0') + R"("}], "extensions": {}})");
}

struct Row {
    const char* where;  // JSON pointer of the flaw
    const char* value;
    const char* message;  // follows "bad.gltf: "
};

const Row kRows[] = {
    {"/materials/0/extensions/KHR_materials_sheen", R"({"sheenColorFactor": [1, 1]})",
     "materials[0].extensions.KHR_materials_sheen.sheenColorFactor: has 2 elements, must have 3"},
    {"/materials/0/extensions/KHR_materials_dispersion", R"({"dispersion": "strong"})",
     "materials[0].extensions.KHR_materials_dispersion.dispersion: is \"strong\", must be a number"},
    {"/materials/0/extensions/KHR_materials_volume_scatter", R"({"multiscatterColorFactor": 1})",
     "materials[0].extensions.KHR_materials_volume_scatter.multiscatterColorFactor: is 1, must be an array"},
    {"/materials/0/extensions/KHR_materials_diffuse_transmission",
     R"({"diffuseTransmissionTexture": {"index": 7}})",
     "materials[0].extensions.KHR_materials_diffuse_transmission.diffuseTransmissionTexture.index: is 7, but "
     "there is 1 texture"},
    {"/materials/0/extensions/KHR_materials_iridescence", R"({"iridescenceTexture": {}})",
     "materials[0].extensions.KHR_materials_iridescence.iridescenceTexture.index: is absent, must be a whole "
     "number of at least 0"},
    {"/materials/0/extensions/KHR_materials_anisotropy", "[]",
     "materials[0].extensions.KHR_materials_anisotropy: is an array, must be an object"},
    {"/materials/0/extensions/KHR_materials_clearcoat",
     R"({"clearcoatNormalTexture": {"index": 0, "scale": []}})",
     "materials[0].extensions.KHR_materials_clearcoat.clearcoatNormalTexture.scale: is an array, must be a "
     "number"},
    {"/materials/0/extensions/KHR_materials_pbrSpecularGlossiness", R"({"diffuseFactor": [1, 1, 1]})",
     "materials[0].extensions.KHR_materials_pbrSpecularGlossiness.diffuseFactor: has 3 elements, must have "
     "4"},
    {"/materials/0/emissiveTexture/extensions/KHR_texture_transform", R"({"offset": 3})",
     "materials[0].emissiveTexture.extensions.KHR_texture_transform.offset: is 3, must be an array"},
    {"/extensions/KHR_materials_variants", R"({"variants": {}})",
     "extensions.KHR_materials_variants.variants: is an object, must be an array"},
    {"/meshes/0/primitives/0/extensions/KHR_materials_variants",
     R"({"mappings": [{"variants": [0], "material": 0}]})",
     "meshes[0].primitives[0].extensions.KHR_materials_variants.mappings[0].variants[0]: is 0, but there are "
     "0 "
     "variants"},
    {"/nodes/0/extensions/KHR_node_visibility", R"({"visible": 0})",
     "nodes[0].extensions.KHR_node_visibility.visible: is 0, must be true or false"},
    {"/nodes/0/extensions/EXT_mesh_gpu_instancing", R"({"attributes": {"ROTATION": 0}})",
     "nodes[0].extensions.EXT_mesh_gpu_instancing.attributes.ROTATION: "},
    {"/bufferViews/0/extensions/EXT_meshopt_compression",
     R"({"buffer": 0, "byteLength": 36, "byteStride": 12, "count": 3, "mode": "ATTRIBUTES"})",
     "bufferViews[0].extensions.EXT_meshopt_compression: 36 bytes are no ATTRIBUTES of 3 elements of 12 "
     "bytes"},
    {"/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression",
     R"({"bufferView": 0, "attributes": {"POSITION": 0}})",
     "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression: its bytes are not those of Draco"},
    {"/accessors/0/componentType", "5125",  // KHR_mesh_quantization has at most 16 bits
     "meshes[0].primitives[0].attributes.POSITION: accessors[0] must be VEC3 of float, byte or short"},
    {"/images/0/uri", R"("data:,RIFF%10%00%00%00WEBPVP8L")", "images[0]: "},
    {"/images/0/uri", R"("data:,DDS %7C%00%00%00")", "images[0]: "},
    {"/images/0/uri", R"("data:,%ABKTX 20%BB%0D%0A%1A%0A%00%00%00%00")", "images[0]: "},
    {"/images/0/uri", R"("data:,%FF%D8%FF%E0%00%10")", "images[0]: "},
};

TEST(ProgramHostileFiles, EachIsRefusedWithOneLine) {
    const test::TemporaryFolder folder;
    for (const Row& row : kRows) {
        Json scene = Scene();
        scene[Json::json_pointer(row.where)] = Json::parse(row.value);
        std::ofstream(folder / "bad.gltf") << scene;
        const test::ProgramResult result = test::RunProgram(folder, "info bad.gltf");
        EXPECT_EQ(result.exitCode, 4) << row.where;
        EXPECT_EQ(result.output, "") << row.where;
        const std::string start = "raygraph: ";
        EXPECT_TRUE(result.messages.starts_with(start)) << result.messages;
        EXPECT_EQ(result.messages.find('\n') + 1, result.messages.size()) << result.messages;
        EXPECT_NE(result.messages.find(std::string("bad.gltf: ") + row.message), std::string::npos)
            << row.where << ": " << result.messages << "  lacks " << row.message;
    }
}

// Every command that loads a scene takes --root, a further folder that it may read from.
TEST(ProgramHostileFiles, RootAllowsFilesBelowAnotherFolder) {
    const test::TemporaryFolder folder;
    std::filesystem::create_directories(folder / "scenes");
    std::filesystem::create_directories(folder / "textures");
    image::WritePng(folder / "textures/w.png", {1, 1, {255, 255, 255, 255}});
    Json scene = Scene();
    scene["images"][0]["uri"] = "../textures/w.png";
    std::ofstream(folder / "scenes/a.gltf") << scene;
    const char* const commands[] = {
        "info scenes/a.gltf",
        "graph scenes/a.gltf --size 8x8",
        "render scenes/a.gltf --size 8x8 --spp 1 --background 1,1,1 -o a.exr",
        "bench scenes/a.gltf --size 8x8 --frames 1 --rounds 1 --max-depth 2",
    };
    for (const char* command : commands) {
        const test::ProgramResult refused = test::RunProgram(folder, command);
        EXPECT_EQ(refused.exitCode, 4) << command;
        EXPECT_EQ(refused.messages,
                  "raygraph: a.gltf: images[0].uri: \"../textures/w.png\": leads out of the "
                  "scene's folder; --root FOLDER allows what is below another folder\n");
        const test::ProgramResult read = test::RunProgram(folder, std::string(command) + " --root .");
        EXPECT_EQ(read.exitCode, 0) << command << ": " << read.messages;
        if (std::string(command).starts_with("bench")) {
            EXPECT_NE(read.output.find(R"("light":"none")"), std::string::npos) << "in its own light alone";
        }
    }
    // The editor stays open and reports it.
    std::ofstream(folder / "script") << "wait\n";
    const std::string edit = "edit scenes/a.gltf --headless-script script";
    const test::ProgramResult refused = test::RunProgram(folder, edit);
    RAYGRAPH_SKIP_WITHOUT_EDITOR(refused);
    EXPECT_NE(refused.messages.find("leads out of the scene's folder"), std::string::npos)
        << refused.messages;
    const test::ProgramResult read = test::RunProgram(folder, edit + " --root .");
    EXPECT_EQ(read.exitCode, 0);
    EXPECT_EQ(read.messages, "");
}

TEST(ProgramHostileFiles, NamesDoNotActOnTheTerminal) {
    const char* const lines[] = {
        "render \x1b[2J.gltf -o a.png",
        "render @cornell.gltf --spp 1 --size 8x8 --env \x1b[2J.hdr -o a.png",
        "render @cornell.gltf --spp 1 --size 8x8 --root \x1b[2J -o a.png",
        "render @cornell.gltf --spp 1 --size 8x8 --settings-from \x1b[2J.exr -o a.png",
        "render @cornell.gltf --spp 2 --size 8x8 --resume \x1b[2J.exr -o a.exr",
        "render @cornell.gltf --spp 1 --size 8x8 -o \x1b[2J/a.png",
        "info \x1b[2J.glb",
        "merge \x1b[2J.exr b.exr -o c.exr",
        "bench --compare \x1b[2J b",
    };
    for (const char* line : lines) {
        const test::ProgramResult result = test::RunProgram(test::TemporaryFolder(), line);
        EXPECT_NE(result.exitCode, 0) << line;
        EXPECT_EQ(result.messages.find('\x1b'), std::string::npos) << line;
        EXPECT_NE(result.messages.find("?[2J"), std::string::npos) << result.messages;
        EXPECT_EQ(std::ranges::count(result.messages, '\n'), 1) << result.messages;
    }
}

}  // namespace
}  // namespace raygraph::program_hostile_test
