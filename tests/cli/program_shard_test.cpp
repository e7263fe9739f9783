// Tests shards that the program renders: parts of one picture, parts of a sequence.
#include "base/text.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/environment_variable.h"
#include "tests/support/temporary_folder.h"

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

constexpr const char* kCornell = "render @cornell.gltf --size 16x16 ";

TEST(ProgramShard, ThreeShardsMergeToTheBitsOfOneRun) {
    const TemporaryFolder folder;
    const std::string options = std::string(kCornell) + "--spp 10 --aov albedo --sample-offset 5 ";
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

TEST(ProgramShard, WhatCannotBeDividedIsRefused) {
    const TemporaryFolder folder;
    const auto expectRefused = [&](const std::string& options, const std::string& text) {
        const ProgramResult result = RunProgram(folder, "render @cornell.gltf " + options);
        EXPECT_EQ(result.exitCode, 2) << options;
        EXPECT_NE(result.messages.find(text), std::string::npos) << options << "\n" << result.messages;
        EXPECT_EQ(std::ranges::count(result.messages, '\n'), 1) << result.messages;
        EXPECT_TRUE(std::filesystem::is_empty(folder.Path()));
    };
    expectRefused("--shard 0/2 --time 5 -o a.exr", "--time knows none beforehand; give --spp");
    expectRefused("--shard 0/2 --error 0.1 --spp 8 -o a.exr", "--error knows none beforehand; give --spp");
    expectRefused("--shard 0/2 -o a.png", "there is no -o OUT.####.exr");
    expectRefused("--shard 0/2", "there is no -o OUT.####.exr");
    expectRefused("--shard 0/2 --view depth -o a.exr", "--view depth is not averaged");
    expectRefused("--shard 0/2 -o a.#.b.#.exr", "more than one run of #");
    expectRefused("--shard 0/2 --resume a.exr -o b.exr", "--resume with --shard needs --spp");
    expectRefused("--shard 1/2 --spp 4 --sample-offset 4294967294 -o a.exr", "beyond the last, 4294967295");
    expectRefused("--shard 2/2 -o a.exr", "--shard: \"2/2\"");
    const EnvironmentVariable task("SLURM_ARRAY_TASK_ID", "one");
    expectRefused("--shard auto -o a.exr", "--shard: auto: SLURM_ARRAY_TASK_ID: \"one\"");
}

}  // namespace
}  // namespace raygraph::program_shard_test
