// Tests --at and --clips: what is shown, recorded and resumed.
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <span>

#include "base/text.h"
#include "editor/session/file/content_hash.h"
#include "renderer/image/image.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/environment_variable.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_files.h"

namespace raygraph::program_motion_test {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::RunProgram;
using test::WriteBox;

TEST(ProgramMotion, InfoListsAnimations) {
    const test::TemporaryFolder folder;
    WriteBox(folder);
    const ProgramResult info = RunProgram(folder, "info box.gltf");
    EXPECT_EQ(info.exitCode, 0) << info.messages;
    EXPECT_NE(info.output.find("  animations  2\n    0  \"rise\"  1.0 s\n    1  \"sink\"  1.0 s\n"),
              std::string::npos)
        << info.output;
    EXPECT_EQ(RunProgram(folder, "info @cornell.gltf").output.find("animations"), std::string::npos);
}

// The box at rest needs no keys, and the keys of the other animation are valid.
TEST(ProgramMotion, BrokenKeysAreAnErrorOfTheAnimationThatPlays) {
    const test::TemporaryFolder folder;
    WriteBox(folder);
    json scene = json::parse(std::ifstream(folder / "box.gltf"));
    const size_t output = scene["animations"][0]["samplers"][0]["output"];
    scene["accessors"][output]["count"] = 1;
    std::ofstream(folder / "box.gltf") << scene;
    const std::string line = "box.gltf: animations[0].samplers[0].output: accessors[" +
                             std::to_string(output) + "] has 1 element, must have 2 for 2 keys of LINEAR";
    const ProgramResult info = RunProgram(folder, "info box.gltf");
    EXPECT_EQ(info.exitCode, 0);
    EXPECT_NE(info.messages.find(line + "; the animation cannot be played"), std::string::npos)
        << info.messages;
    for (const char* command : {"render -o a.png", "bench", "graph"})
        for (const char* clips : {"", " --clips rise", " --clips all"}) {
            const ProgramResult refused =
                RunProgram(folder, std::string(command) + " box.gltf --at 1" + clips);
            EXPECT_EQ(refused.exitCode, 4) << command << clips;
            EXPECT_EQ(refused.messages, "raygraph: " + line + "\n");
        }
    EXPECT_EQ(RunProgram(folder, "graph box.gltf --at 1 --clips sink").exitCode, 0);
}

TEST(ProgramMotion, TimesAreRenderedRecordedAndResumed) {
    const test::TemporaryFolder folder;
    WriteBox(folder);
    const auto render = [&](const std::string& options) {
        const ProgramResult result = RunProgram(folder, "render box.gltf --size 16x16 " + options);
        EXPECT_EQ(result.exitCode, 0) << result.messages;
    };
    render("--spp 2 -o rest.exr");
    render("--spp 2 --at 1 -o end.exr");
    render("--spp 2 --at 1 --clips sink -o sunk.exr");
    render("--spp 4 --at 1 -o whole.exr");
    const auto read = [&](const char* name) { return session::ReadRenderFile(folder / name); };
    const session::RenderFile rest = read("rest.exr"), end = read("end.exr");
    EXPECT_NE(end.radiance, rest.radiance);
    EXPECT_NE(read("sunk.exr").radiance, rest.radiance);
    EXPECT_NE(read("sunk.exr").radiance, end.radiance);
    EXPECT_EQ(rest.settings.at("at"), "");
    EXPECT_EQ(end.settings.at("at"), "1");
    EXPECT_EQ(read("sunk.exr").settings.at("clips"), "sink");
    EXPECT_EQ(end.sceneHash, rest.sceneHash) << "the same file, whatever it shows";
    const ProgramResult more = RunProgram(folder, "render box.gltf --resume end.exr --spp 4 -o more.exr");
    EXPECT_EQ(more.exitCode, 0) << more.messages;
    EXPECT_EQ(read("more.exr").radiance, read("whole.exr").radiance);
    const ProgramResult other =
        RunProgram(folder, "render box.gltf --resume end.exr --at 2 --spp 4 -o x.exr");
    EXPECT_NE(other.exitCode, 0);
}

TEST(ProgramMotion, FramesAreThePicturesOfTheirTimes) {
    const test::TemporaryFolder folder;
    WriteBox(folder);
    const ProgramResult frames = RunProgram(
        folder, "render box.gltf --size 16x16 --spp 2 --frames 0.5:1:0.25 -o f.##.exr -o f.##.png");
    EXPECT_EQ(frames.exitCode, 0) << frames.messages;
    EXPECT_NE(frames.output.find("f.02.exr\nf.02.png\n2 samples a pixel"), std::string::npos)
        << frames.output;
    const auto read = [&](const char* name) { return session::ReadRenderFile(folder / name); };
    for (const auto& [name, at] : {std::pair("f.02.exr", "0.5"), {"f.04.exr", "1"}}) {
        const ProgramResult still =
            RunProgram(folder, std::string("render box.gltf --size 16x16 --spp 2 -o still.exr --at ") + at);
        EXPECT_EQ(still.exitCode, 0) << still.messages;
        EXPECT_EQ(read(name).radiance, read("still.exr").radiance) << at;
        EXPECT_EQ(read(name).settings, read("still.exr").settings) << at;
        EXPECT_EQ(read(name).samples, read("still.exr").samples) << at;
    }
    EXPECT_NE(read("f.02.exr").radiance, read("f.04.exr").radiance);
    EXPECT_TRUE(std::filesystem::exists(folder / "f.04.png"));
    EXPECT_FALSE(std::filesystem::exists(folder / "f.05.exr"));
}

// Each frame has one sample, so the current one completes, and the next is not begun.
TEST(ProgramMotion, AnInterruptEndsASequenceAfterTheFrameThatIsBegun) {
    const test::TemporaryFolder folder;
    WriteBox(folder);
    bool isSent = false;
    const ProgramResult result = test::RunProgramOnTerminal(
        folder, "render box.gltf --view albedo --size 16x16 --spp 1 --frames 0:99:0.001 -o f.#####.png",
        [&](pid_t process, const std::string& shown) {
            if (isSent || shown.find("f.00001.png") == std::string::npos) return;
            isSent = true;
            kill(process, SIGINT);
        });
    EXPECT_EQ(result.exitCode, 0) << result.output;
    const size_t files =
        size_t(std::ranges::count_if(std::filesystem::directory_iterator(folder.Path()),
                                     [](const auto& entry) { return entry.path().extension() == ".png"; }));
    EXPECT_GE(files, 2u);
    EXPECT_LT(files, 99000u);
    const std::string left = std::to_string(99001 - files) + " of 99001 pictures were not begun";
    EXPECT_NE(result.output.find(left), std::string::npos)
        << files << " files, " << result.output.substr(result.output.size() - 300);
}

TEST(ProgramMotion, FramesThatCannotBeAreRefusedBeforeAnyIsRendered) {
    const test::TemporaryFolder folder;
    WriteBox(folder);
    const auto refused = [&](const std::string& options, const char* part) {
        const ProgramResult result = RunProgram(folder, "render box.gltf " + options);
        EXPECT_EQ(result.exitCode, 2) << options;
        EXPECT_NE(result.messages.find(part), std::string::npos) << result.messages;
    };
    refused("--frames 0:1:0.5 -o a.png", "\"a.png\" has no single run of # for the numbers of --frames");
    refused("--frames 0:1:0.5 -o a.#.png --report r.json", "\"r.json\" has no single run of #");
    refused("--frames 0:1:0.5 -o a.#.png --at 1", "--frames and --at exclude each other");
    refused("--frames 0:1:0.5 -o a.#.exr --resume a.#.exr", "--resume goes on with one");
    refused("--frames 1:0:0.5 -o a.#.png", "--frames: \"1:0:0.5\" ends before it begins");
    refused("--shutter 0:1 -o a.png", "--shutter: it is around a time, and none is given");
    refused("--at 0 --shutter 1:0 -o a.png", "--shutter: \"1:0\": a shutter closes after it opens");
    refused("--at 0 --shutter 0.5 -o a.png", "--shutter: \"0.5\" is not OPEN:CLOSE");
    refused("--at 0 --shutter 0:1 --view material -o a.png",
            "--shutter: the view material is not averaged over samples");
}

TEST(ProgramMotion, ShutterBlursAndIsResumed) {
    const test::TemporaryFolder folder;
    WriteBox(folder);
    const auto render = [&](const std::string& options) {
        const ProgramResult result =
            RunProgram(folder, "render box.gltf --size 16x16 --background 1,1,1 " + options);
        EXPECT_EQ(result.exitCode, 0) << result.messages;
    };
    render("--spp 4 --at 0 --shutter 0:1 -o whole.exr");
    render("--spp 2 --at 0 --shutter 0:1 -o half.exr");
    render("--resume half.exr --spp 4 -o resumed.exr");
    render("--spp 2 --at 0 --shutter 0:1 --sample-offset 2 -o other.exr");
    render("--spp 4 --at 0 -o sharp.exr");
    const ProgramResult merged = RunProgram(folder, "merge half.exr other.exr -o merged.exr");
    EXPECT_EQ(merged.exitCode, 0) << merged.messages;
    const auto read = [&](const char* name) { return session::ReadRenderFile(folder / name); };
    EXPECT_EQ(read("resumed.exr").radiance, read("whole.exr").radiance);
    EXPECT_EQ(read("merged.exr").radiance, read("whole.exr").radiance);
    EXPECT_NE(read("sharp.exr").radiance, read("whole.exr").radiance);
    EXPECT_EQ(read("whole.exr").settings.at("shutter"), "0:1");
    EXPECT_EQ(read("sharp.exr").settings.at("shutter"), "none");
}

}  // namespace
}  // namespace raygraph::program_motion_test

// Tests several cameras in one run. It needs a device.
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

image::Image8 Png(const TemporaryFolder& folder, const std::string& name) {
    const std::string bytes = TextOf(folder / name);
    return image::DecodeImage8(std::as_bytes(std::span(bytes)), name);
}

TEST(ProgramCamera, SeveralHaveTheBytesThatEachHasByItself) {
    const TemporaryFolder folder;
    const std::string options =
        "render @cornell.gltf --brdf lambert --nee off --size 16x12 --spp 3 --aov depth ";
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
    const std::string options = "render @cornell.gltf --brdf lambert --nee off --size 8x8 --spp 2 ";
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

TEST(ProgramCamera, TurntableAndContactSheetHaveTheSamePictures) {
    const TemporaryFolder folder;
    const std::string options =
        "render @material_row.gltf --view normals --spp 1 --turntable 3 --orbit 20,10 --size 8x6 ";
    RunWell(folder, options + "-o turn.##.png");
    RunWell(folder, options + "--contact-sheet -o sheet.png");
    const image::Image8 sheet = Png(folder, "sheet.png");
    ASSERT_EQ(sheet.width, 16u);
    ASSERT_EQ(sheet.height, 12u);
    std::set<std::string> pictures;
    for (uint32_t i = 0; i < 4; ++i) {
        std::string part;
        for (uint32_t y = 0; y < 6; ++y) {
            const auto row = sheet.rgba.begin() + 4 * (16 * (6 * (i / 2) + y) + 8 * (i % 2));
            part.append(row, row + 4 * 8);
        }
        pictures.insert(part);
        if (i == 3) {
            EXPECT_EQ(part, std::string(part.size(), 0)) << "a place without a picture is transparent";
            break;
        }
        const image::Image8 alone = Png(folder, "turn.0" + std::to_string(i) + ".png");
        EXPECT_EQ(part, std::string(alone.rgba.begin(), alone.rgba.end())) << i;
    }
    EXPECT_EQ(pictures.size(), 4u) << "the pictures differ";
}

TEST(ProgramCamera, ContactSheetShowsSixSidesByDefault) {
    const TemporaryFolder folder;
    RunWell(folder, "render @material_row.gltf --view normals --size 4x3 --contact-sheet -o sheet.png");
    const image::Image8 sheet = Png(folder, "sheet.png");
    EXPECT_EQ(sheet.width, 12u);
    EXPECT_EQ(sheet.height, 6u);
}

TEST(ProgramCamera, OneThatIsMissingIsRenderedAlone) {
    const TemporaryFolder folder;
    const std::string line =
        std::string("render @cornell.gltf --brdf lambert --nee off --size 8x8 --spp 2 --camera 0 --camera ") +
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

}  // namespace
}  // namespace raygraph::program_camera_test

// Tests shards that the program renders: parts of one picture, parts of a sequence.
namespace raygraph::program_shard_test {
namespace {

using test::EnvironmentVariable;
using test::ProgramResult;
using test::RunProgram;
using test::TemporaryFolder;

std::string RunWell(const TemporaryFolder& folder, const std::string& line) {
    const ProgramResult result = RunProgram(folder, line);
    EXPECT_EQ(result.exitCode, 0) << line << "\n" << result.messages;
    return result.output;
}

session::RenderFile Read(const TemporaryFolder& folder, const std::string& name) {
    return session::ReadRenderFile(folder / name);
}

void ExpectSameBits(const session::RenderFile& a, const session::RenderFile& b) {
    EXPECT_EQ(a.samples, b.samples);
    EXPECT_EQ(a.radiance, b.radiance);
    EXPECT_EQ(a.variance, b.variance);
    EXPECT_EQ(a.albedo, b.albedo);
    EXPECT_EQ(a.sums.radiance, b.sums.radiance);
    EXPECT_EQ(a.sums.albedo, b.sums.albedo);
}

constexpr const char* kCornell = "render @cornell.gltf --brdf lambert --nee off --size 16x16 ";

TEST(ProgramShard, ThreeShardsMergeToTheBitsOfOneRun) {
    const TemporaryFolder folder;
    const std::string options = std::string(kCornell) + "--spp 10 --sample-offset 5 ";
    for (const int index : {2, 0, 1})
        RunWell(folder,
                options + Text("--shard {}/3 -o part.####.exr -o part.####.png --report r.#.json", index));
    EXPECT_EQ(Read(folder, "part.0000.exr").samples, (session::SampleRanges{{5, 3}}));
    EXPECT_EQ(Read(folder, "part.0001.exr").samples, (session::SampleRanges{{8, 3}}));
    EXPECT_EQ(Read(folder, "part.0002.exr").samples, (session::SampleRanges{{11, 4}}));
    EXPECT_TRUE(std::filesystem::exists(folder / "part.0002.png"));
    EXPECT_TRUE(std::filesystem::exists(folder / "r.2.json"));
    RunWell(folder, "merge part.0001.exr part.0002.exr part.0000.exr -o merged.exr");
    RunWell(folder, options + "-o whole.exr");
    ExpectSameBits(Read(folder, "merged.exr"), Read(folder, "whole.exr"));
}

TEST(ProgramShard, AutoIsTheTaskOfTheJobArray) {
    const TemporaryFolder folder;
    const EnvironmentVariable first("SLURM_ARRAY_TASK_MIN", "1"), last("SLURM_ARRAY_TASK_MAX", "2"),
        count("SLURM_ARRAY_TASK_COUNT", "2"), step("SLURM_ARRAY_TASK_STEP", "1"),
        task("SLURM_ARRAY_TASK_ID", "2");
    RunWell(folder, std::string(kCornell) + "--spp 5 --shard auto -o part.##.exr");
    EXPECT_EQ(Read(folder, "part.01.exr").samples, (session::SampleRanges{{2, 3}}));
    const EnvironmentVariable other("SLURM_ARRAY_TASK_ID", "one");
    const ProgramResult refused = RunProgram(folder, "render @cornell.gltf --shard auto -o a.exr");
    EXPECT_EQ(refused.exitCode, 2);
    EXPECT_NE(refused.messages.find("--shard: auto: SLURM_ARRAY_TASK_ID: \"one\""), std::string::npos)
        << refused.messages;
}

// The job array as a whole must succeed, so that the job that merges begins.
TEST(ProgramShard, MoreShardsThanSamplesWriteNothingAndSucceed) {
    const TemporaryFolder folder;
    std::string said;
    for (const int index : {0, 1, 2})
        said += RunWell(folder, std::string(kCornell) + Text("--spp 1 --shard {}/3 -o part.#.exr", index));
    EXPECT_NE(said.find("shard 0 of 0 to 2 has no sample to render; nothing is written\n"), std::string::npos)
        << said;
    EXPECT_FALSE(std::filesystem::exists(folder / "part.0.exr"));
    EXPECT_FALSE(std::filesystem::exists(folder / "part.1.exr"));
    RunWell(folder, "merge part.2.exr -o merged.exr");
    RunWell(folder, std::string(kCornell) + "--spp 1 -o whole.exr");
    ExpectSameBits(Read(folder, "merged.exr"), Read(folder, "whole.exr"));
    EXPECT_EQ(RunWell(folder, std::string(kCornell) + "--spp 1 --shard 0/3 -o part.#.exr --quiet"), "");
}

TEST(ProgramShard, AResumedShardGoesOnToItsOwnTotal) {
    const TemporaryFolder folder;
    RunWell(folder, std::string(kCornell) + "--sample-offset 5 --spp 2 -o part.1.exr");
    RunWell(folder, "render @cornell.gltf --spp 10 --shard 1/2 --resume part.#.exr");
    EXPECT_EQ(Read(folder, "part.1.exr").samples, (session::SampleRanges{{5, 5}}));
    RunWell(folder, std::string(kCornell) + "--spp 10 --shard 1/2 -o whole.exr");
    ExpectSameBits(Read(folder, "part.1.exr"), Read(folder, "whole.exr"));
    // The file has none of the samples 0 to 4
    const ProgramResult other =
        RunProgram(folder, "render @cornell.gltf --spp 10 --shard 0/2 --resume part.1.exr -o x.exr");
    EXPECT_EQ(other.exitCode, 2);
    EXPECT_NE(other.messages.find("--shard 0/2: its first sample is 0; part.1.exr was rendered from 5"),
              std::string::npos)
        << other.messages;
}

TEST(ProgramShard, FramesOfAllShardsAreTheSequence) {
    const TemporaryFolder folder;
    const std::string line = std::string(kCornell) + "--spp 1 --frames 0:0.08:0.04 -o f.##.exr ";
    const std::string empty = RunWell(folder, line + "--shard 0/4");
    EXPECT_EQ(empty, "shard 0 of 0 to 3 has no frame to render; nothing is written\n");
    for (const int index : {1, 2, 3}) {
        RunWell(folder, line + Text("--shard {}/4", index));
        EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.Path()), {}), index);
        EXPECT_EQ(Read(folder, Text("f.{:02}.exr", index - 1)).settings.at("at"),
                  Text("{}", 0.04 * (index - 1)));
    }
    EXPECT_EQ(Read(folder, "f.00.exr").samples, (session::SampleRanges{{0, 1}})) << "every picture is whole";
}

// A job that is requeued repeats its command.
TEST(ProgramShard, WithCheckpointsAShardGoesOnOrIsDone) {
    const TemporaryFolder folder;
    const std::string part =
        std::string(kCornell) + "--spp 6 --shard 1/2 --checkpoint 60 --resume part.#.exr -o part.#.exr";
    RunWell(folder, std::string(kCornell) + "--sample-offset 3 --spp 1 -o part.1.exr");
    RunWell(folder, part);
    EXPECT_EQ(Read(folder, "part.1.exr").samples, (session::SampleRanges{{3, 3}}));
    RunWell(folder, part);
    EXPECT_EQ(Read(folder, "part.1.exr").samples, (session::SampleRanges{{3, 3}}));
    const std::string frames =
        std::string(kCornell) +
        "--spp 2 --frames 0:0.12:0.04 --shard 1/2 --checkpoint 60 --resume f.##.exr -o f.##.exr";
    RunWell(folder, frames);
    const session::RenderFile whole = Read(folder, "f.02.exr");
    RunWell(folder, std::string(kCornell) + "--spp 1 --at 0.08 -o f.02.exr");
    RunWell(folder, frames);
    ExpectSameBits(Read(folder, "f.02.exr"), whole);
    EXPECT_FALSE(std::filesystem::exists(folder / "f.01.exr")) << "of the other shard";
}

}  // namespace
}  // namespace raygraph::program_shard_test

// Tests renders on several devices: the tests' own, opened more than once. It needs a device.
namespace raygraph::program_devices_test {
namespace {

using test::ProgramResult;
using test::RunProgram;
using test::TemporaryFolder;
using test::TextOf;

// Returns the first index in the list of `info --devices` that belongs to a suitable device.
std::string SuitableIndex() {
    const ProgramResult listed = RunProgram(TemporaryFolder(), "info --json --devices");
    const auto json = nlohmann::json::parse(listed.output);
    for (const auto& device : json.at("devices"))
        if (device.at("suitable")) return std::to_string(device.at("index").get<int>());
    throw std::runtime_error(listed.output);
}

TEST(ProgramDevices, TwoGiveTheBytesOfOne) {
    const TemporaryFolder folder;
    const std::string index = SuitableIndex(), list = index + "," + index;
    const std::string options = "render @cornell.gltf --size 24x16 --spp 5 --aov depth ";
    const ProgramResult one =
        RunProgram(folder, options + "-o one.exr -o one.png --report one.json --device " + index);
    ASSERT_EQ(one.exitCode, 0) << one.messages;
    const ProgramResult two =
        RunProgram(folder, options + "-o two.exr -o two.png --report two.json --devices " + list);
    ASSERT_EQ(two.exitCode, 0) << two.messages;
    EXPECT_EQ(TextOf(folder / "two.exr"), TextOf(folder / "one.exr"));
    EXPECT_EQ(TextOf(folder / "two.png"), TextOf(folder / "one.png"));
    EXPECT_NE(two.output.find(", 2 devices\n"), std::string::npos) << two.output;
    EXPECT_EQ(one.output.find(" devices"), std::string::npos) << one.output;

    const auto ofOne = nlohmann::json::parse(TextOf(folder / "one.json")),
               ofTwo = nlohmann::json::parse(TextOf(folder / "two.json"));
    const std::string name = ofOne.at("device").at("name");
    EXPECT_EQ(ofOne.at("devices"), nlohmann::json({name}));
    EXPECT_EQ(ofTwo.at("devices"), nlohmann::json({name, name}));
    EXPECT_EQ(ofTwo.at("device"), ofOne.at("device"));
    EXPECT_EQ(ofTwo.at("samples"), 5);
}

TEST(ProgramDevices, AllAreThoseOfTheBestKind) {
    const TemporaryFolder folder;
    const ProgramResult result =
        RunProgram(folder, "render @cornell.gltf --size 8x8 --spp 2 -o a.exr --report a.json --devices all");
    ASSERT_EQ(result.exitCode, 0) << result.messages;
    const auto report = nlohmann::json::parse(TextOf(folder / "a.json"));
    ASSERT_GE(report.at("devices").size(), 1u);
    for (const auto& name : report.at("devices")) EXPECT_EQ(name, report.at("device").at("name"));
}

}  // namespace
}  // namespace raygraph::program_devices_test

// Tests --variant: what is shown, recorded and resumed.
namespace raygraph::program_variant_test {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::RunProgram;

// Writes the Cornell box with variants that paint everything but the lamp: "paint" uses the material `paint`.
void WriteBox(const test::TemporaryFolder& folder, uint32_t paint) {
    json scene = json::parse(std::ifstream(test::SceneFile("cornell.gltf")));
    scene["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "paint"}}, {{"name", "other"}}};
    for (json& mesh : scene["meshes"])
        for (json& primitive : mesh["primitives"])
            if (scene["materials"][primitive["material"].get<size_t>()]["name"] != "lamp")
                primitive["extensions"]["KHR_materials_variants"]["mappings"] = {
                    {{"material", paint}, {"variants", {0}}}, {{"material", 1 - paint}, {"variants", {1}}}};
    std::ofstream(folder / "box.gltf") << scene;
}

TEST(ProgramVariant, InfoListsThemAndMarksTheOneThatIsShown) {
    const test::TemporaryFolder folder;
    WriteBox(folder, 0);
    const ProgramResult plain = RunProgram(folder, "info box.gltf");
    EXPECT_EQ(plain.exitCode, 0) << plain.messages;
    EXPECT_NE(plain.output.find("  variants    2\n    0  \"paint\"\n    1  \"other\"\n"), std::string::npos)
        << plain.output;
    const ProgramResult shown = RunProgram(folder, "info box.gltf --variant other");
    EXPECT_EQ(shown.exitCode, 0) << shown.messages;
    EXPECT_NE(shown.output.find("    0  \"paint\"\n    1  \"other\"  shown\n"), std::string::npos)
        << shown.output;
    EXPECT_EQ(RunProgram(folder, "info @cornell.gltf").output.find("variants"), std::string::npos);
}

TEST(ProgramVariant, OneThatIsNotThereIsFourWithALineThatNamesWhatThereIs) {
    const test::TemporaryFolder folder;
    WriteBox(folder, 0);
    for (const char* command : {"info", "render -o a.png", "bench", "graph"}) {
        const std::string line = std::string(command) + " box.gltf --variant ";
        const ProgramResult unknown = RunProgram(folder, line + "red");
        EXPECT_EQ(unknown.exitCode, 4) << command;
        EXPECT_EQ(
            unknown.messages,
            "raygraph: --variant: there is no variant \"red\"; the scene has 0 \"paint\", 1 \"other\"\n");
        EXPECT_EQ(RunProgram(folder, line + "2").exitCode, 4) << command;
    }
}

TEST(ProgramVariant, IsRenderedAndResumedAsItself) {
    const test::TemporaryFolder folder;
    WriteBox(folder, 0);
    const auto render = [&](const std::string& options) {
        const ProgramResult result = RunProgram(folder, "render box.gltf " + options);
        EXPECT_EQ(result.exitCode, 0) << result.messages;
    };
    render("--brdf lambert --nee off --size 16x16 --spp 2 -o plain.exr");
    render("--brdf lambert --nee off --size 16x16 --spp 2 --variant paint -o paint.exr");
    render("--brdf lambert --nee off --size 16x16 --spp 4 --variant paint -o whole.exr");
    const session::RenderFile plain = session::ReadRenderFile(folder / "plain.exr");
    const session::RenderFile paint = session::ReadRenderFile(folder / "paint.exr");
    EXPECT_NE(plain.radiance, paint.radiance);
    EXPECT_NE(plain.sceneHash, paint.sceneHash);
    EXPECT_EQ(plain.settings.at("variant"), "");
    EXPECT_EQ(paint.settings.at("variant"), "paint");
    EXPECT_EQ(session::FirstMismatch(plain, paint).find("variant: "), 0u);

    render("--resume paint.exr --spp 4 -o more.exr");
    EXPECT_EQ(session::ReadRenderFile(folder / "more.exr").radiance,
              session::ReadRenderFile(folder / "whole.exr").radiance);
    const ProgramResult other =
        RunProgram(folder, "render box.gltf --resume paint.exr --variant other --spp 4 -o more.exr");
    EXPECT_NE(other.exitCode, 0);
    EXPECT_NE(other.messages.find("--variant"), std::string::npos) << other.messages;
    // The variant keeps its name, but has another material
    WriteBox(folder, 1);
    const ProgramResult changed =
        RunProgram(folder, "render box.gltf --resume paint.exr --spp 4 -o more.exr");
    EXPECT_EQ(changed.exitCode, 4);
    EXPECT_NE(changed.messages.find("the content of box.gltf has changed"), std::string::npos)
        << changed.messages;
}

TEST(ProgramVariant, EditOpensInIt) {
    const test::TemporaryFolder folder;
    WriteBox(folder, 0);
    std::ofstream(folder.Path() / "script.txt") << "size 120x100\nwait\nexpect variant other\n";
    const std::string line = "edit box.gltf --light none --headless-script script.txt --variant ";
    const ProgramResult edited = RunProgram(folder, line + "other");
    RAYGRAPH_SKIP_WITHOUT_EDITOR(edited);
    EXPECT_EQ(edited.exitCode, 0) << edited.messages;
}

}  // namespace
}  // namespace raygraph::program_variant_test

// Tests --points and --lines: what is shown, counted, recorded and refused.
namespace raygraph::program_points_test {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::RunProgram;

constexpr const char* kScene = "@points_and_lines.gltf";

TEST(ProgramPoints, InfoCountsThemAndWarnsOfThoseLeftOut) {
    const test::TemporaryFolder folder;
    const ProgramResult plain = RunProgram(folder, std::string("info ") + kScene);
    EXPECT_EQ(plain.exitCode, 0) << plain.messages;
    EXPECT_EQ(plain.output.find("points"), plain.output.find("points_and_lines.gltf")) << plain.output;
    EXPECT_NE(plain.messages.find("2500 points are left out; a radius (--points) shows them as spheres"),
              std::string::npos)
        << plain.messages;
    EXPECT_NE(
        plain.messages.find("432 line segments are left out; a radius (--lines) shows them as capsules"),
        std::string::npos)
        << plain.messages;
    const ProgramResult shown =
        RunProgram(folder, std::string("info ") + kScene + " --points 0.02 --lines 0.5%");
    EXPECT_EQ(shown.exitCode, 0);
    EXPECT_EQ(shown.messages, "");
    EXPECT_NE(shown.output.find("  points      2,500 placed\n  segments    432 placed\n"), std::string::npos)
        << shown.output;
}

TEST(ProgramPoints, ABadFileIsFour) {
    const test::TemporaryFolder folder;
    json scene = json::parse(std::ifstream(test::SceneFile("points_and_lines.gltf")));
    for (json& accessor : scene["accessors"])
        if (accessor["type"] == "SCALAR" && accessor["count"] == 240) accessor["count"] = 241;
    std::ofstream(folder / "bad.gltf") << scene;
    const ProgramResult bad = RunProgram(folder, "info bad.gltf --lines 1");
    EXPECT_EQ(bad.exitCode, 4) << bad.messages;
    EXPECT_EQ(std::count(bad.messages.begin(), bad.messages.end(), '\n'), 1) << bad.messages;
}

TEST(ProgramPoints, RadiiAreSettingsOfARender) {
    const test::TemporaryFolder folder;
    const auto render = [&](const std::string& options) {
        const ProgramResult result = RunProgram(folder, std::string("render ") + kScene + " " + options);
        EXPECT_EQ(result.exitCode, 0) << result.messages;
    };
    render("--brdf lambert --nee off --size 16x16 --spp 2 --points 0.05 --lines 1% -o two.exr");
    render("--brdf lambert --nee off --size 16x16 --spp 4 --points 0.05 --lines 1% -o four.exr");
    const session::RenderFile two = session::ReadRenderFile(folder / "two.exr");
    EXPECT_EQ(two.settings.at("points"), "0.05");
    EXPECT_EQ(two.settings.at("lines"), "1%");
    render("--resume two.exr --spp 4 -o more.exr");
    EXPECT_EQ(session::ReadRenderFile(folder / "more.exr").radiance,
              session::ReadRenderFile(folder / "four.exr").radiance);
    EXPECT_EQ(RunProgram(folder,
                         std::string("render ") + kScene + " --resume two.exr --points 0.1 --spp 4 -o a.exr")
                  .exitCode,
              2);
}

}  // namespace
}  // namespace raygraph::program_points_test
