// The pictures of a render: frames, cameras, names of files, shards.
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "base/text.h"
#include "editor/cli/arguments.h"
#include "editor/cli/command_files.h"
#include "editor/cli/picture_list.h"
#include "tests/cli/cli_test.h"

// Tests --frames: times, numbers and names.
namespace raygraph::cli::frame_range_test {
namespace {

using test::ExpectError;

TEST(FrameRange, TimesFromTheFirstToTheLast) {
    const FrameRange range = ParseFrames("0.5:2:0.25");
    ASSERT_EQ(range.Count(), 7u);
    EXPECT_EQ(range.TimeOf(0), 0.5);
    EXPECT_EQ(range.TimeOf(6), 2.0);
    EXPECT_EQ(ParseFrames("0:1:0.1").Count(), 11u) << "ten tenths are one, but for rounding";
    EXPECT_EQ(ParseFrames("0:1:0.3").Count(), 4u);
    EXPECT_EQ(ParseFrames("2:2:1").Count(), 1u);
    EXPECT_EQ(ParseFrames("-1:1:1").Count(), 3u);
}

TEST(FrameRange, PartsOfASequenceHaveItsNumbers) {
    const FrameRange whole = ParseFrames("0:9.96:0.04"), part = ParseFrames("4:5.96:0.04");
    for (uint32_t i = 0; i < part.Count(); ++i) {
        EXPECT_EQ(part.NumberOf(i), 100 + i);
        EXPECT_EQ(part.TimeOf(i), whole.TimeOf(100 + i));
    }
}

TEST(FrameRange, WhatIsNoneIsRefused) {
    for (const char* text :
         {"", "1", "0:1", "0:1:", "a:1:1", "0:1:0", "0:1:-1", "1:0:1", "0:1:1:1", "0:1e6:1e-3", "0:nan:1"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseFrames(text); }, "");
    ExpectError(
        ErrorKind::Usage, [] { ParseFrames("2:1:0.5"); }, "\"2:1:0.5\" ends before it begins");
    ExpectError(
        ErrorKind::Usage, [] { ParseFrames("0:1000:0.001"); }, "has more than 100000 frames");
}

TEST(FrameRange, NamesHaveThePlaceOfANumber) {
    EXPECT_TRUE(HasNumberPlaceholder("a/b.####.exr"));
    EXPECT_TRUE(HasNumberPlaceholder("#.png"));
    EXPECT_FALSE(HasNumberPlaceholder("a/b.exr"));
    EXPECT_FALSE(HasNumberPlaceholder("a##/b.exr")) << "in the folder's name";
    EXPECT_FALSE(HasNumberPlaceholder("a#b#.exr"));
    EXPECT_EQ(Numbered("a/b.####.exr", 7), "a/b.0007.exr");
    EXPECT_EQ(Numbered("####.exr", 12345), "12345.exr");
    EXPECT_EQ(Numbered("x##/#", 3), "x##/3");
    EXPECT_EQ(Numbered("", 3), "") << "no file stays none";
    EXPECT_EQ(Numbered("a.####.exr", -2), "a.-002.exr");
}

}  // namespace
}  // namespace raygraph::cli::frame_range_test

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

// Tests --shard: the parts by text and by the variables of launchers.
namespace raygraph::cli::shard_test {

// Prints failed comparisons.
void PrintTo(const Shard& shard, std::ostream* out) {
    *out << shard.index << "/" << shard.count;
}

namespace {

using test::ExpectError;
using Environment = std::map<std::string, std::string>;

Shard Auto(const Environment& environment) {
    return ParseShard("auto", [&](const char* name) {
        const auto variable = environment.find(name);
        return variable == environment.end() ? nullptr : variable->second.c_str();
    });
}

// Returns the variables that Slurm 22.05 sets for `--array=first-last:step`.
Environment ArrayTask(int id, int first, int last, int step, int count) {
    return {{"SLURM_JOB_ID", "9"},
            {"SLURM_PROCID", "0"},
            {"SLURM_ARRAY_JOB_ID", "8"},
            {"SLURM_ARRAY_TASK_ID", std::to_string(id)},
            {"SLURM_ARRAY_TASK_MIN", std::to_string(first)},
            {"SLURM_ARRAY_TASK_MAX", std::to_string(last)},
            {"SLURM_ARRAY_TASK_STEP", std::to_string(step)},
            {"SLURM_ARRAY_TASK_COUNT", std::to_string(count)}};
}

Environment With(Environment environment, const Environment& more) {
    for (const auto& [name, value] : more) environment[name] = value;
    return environment;
}

Environment Step(int process, int count) {
    return {{"SLURM_JOB_ID", "9"},
            {"SLURM_STEP_ID", "0"},
            {"SLURM_PROCID", std::to_string(process)},
            {"SLURM_NTASKS", std::to_string(count)}};
}

void ExpectNoShard(const Environment& environment, const std::string& text) {
    ExpectError(
        ErrorKind::Usage, [&] { Auto(environment); }, "auto: ", text);
}

TEST(Shard, PartsAreDisjointInOrderAndHaveAll) {
    for (const uint32_t total : {0u, 1u, 2u, 10u, 64u, 1000u, 4294967295u})
        for (const uint32_t count : {1u, 2u, 3u, 7u, 64u, 1001u}) {
            uint32_t end = 0;
            for (uint32_t index = 0; index < count; ++index) {
                const ShardPart part = PartOf({index, count}, total);
                EXPECT_EQ(part.begin, end) << index << "/" << count << " of " << total;
                EXPECT_EQ(part.begin, uint64_t{total} * index / count);
                EXPECT_GE(part.end - part.begin, total / count);
                EXPECT_LE(part.end - part.begin, total / count + (total % count != 0));
                end = part.end;
            }
            EXPECT_EQ(end, total) << count;
        }
    constexpr uint32_t kMost = std::numeric_limits<uint32_t>::max();
    EXPECT_EQ(PartOf({kMost - 1, kMost}, kMost).begin, kMost - 1) << "without overflow";
}

TEST(Shard, IsGivenByIndexAndCount) {
    EXPECT_EQ(ParseShard("0/1"), (Shard{0, 1}));
    EXPECT_EQ(ParseShard("15/16"), (Shard{15, 16}));
    for (const char* text : {"", "1", "/", "1/", "/2", "a/2", "1/b", "-1/2", "1/2/3", "1 /2", "AUTO", "0/0"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseShard(text); }, "");
    ExpectError(
        ErrorKind::Usage, [] { ParseShard("16/16"); }, "numbered from 0 to 15");
    ExpectError(
        ErrorKind::Usage, [] { ParseShard("half"); }, "\"half\" is neither I/N nor auto");
}

TEST(Shard, TaskOfAJobArray) {
    EXPECT_EQ(Auto(ArrayTask(0, 0, 15, 1, 16)), (Shard{0, 16}));
    EXPECT_EQ(Auto(ArrayTask(15, 0, 15, 1, 16)), (Shard{15, 16}));
    EXPECT_EQ(Auto(ArrayTask(1, 1, 4, 1, 4)), (Shard{0, 4})) << "indices may begin with 1";
    EXPECT_EQ(Auto(ArrayTask(40, 10, 40, 10, 4)), (Shard{3, 4})) << "and lie apart";
    EXPECT_EQ(Auto(ArrayTask(7, 7, 7, 1, 1)), (Shard{0, 1}));
    // The job script is one process, however many tasks of srun its job has room for
    EXPECT_EQ(Auto(With(ArrayTask(2, 0, 2, 1, 3), {{"SLURM_NTASKS", "4"}})), (Shard{2, 3}));
}

TEST(Shard, ProcessOfSrunOrMpirun) {
    EXPECT_EQ(Auto(Step(3, 4)), (Shard{3, 4}));
    EXPECT_EQ(Auto({{"OMPI_COMM_WORLD_RANK", "1"}, {"OMPI_COMM_WORLD_SIZE", "2"}}), (Shard{1, 2}));
    // mpirun starts the processes of a Slurm job through one step with a task on each node
    EXPECT_EQ(Auto(With(Step(1, 2), {{"OMPI_COMM_WORLD_RANK", "5"}, {"OMPI_COMM_WORLD_SIZE", "8"}})),
              (Shard{5, 8}));
}

TEST(Shard, ProcessesInATaskOfAnArrayDivideItsPart) {
    for (int task = 0; task < 3; ++task)
        for (int process = 0; process < 4; ++process) {
            const Shard expected{static_cast<uint32_t>(4 * task + process), 12};
            EXPECT_EQ(Auto(With(ArrayTask(5 + task, 5, 7, 1, 3), Step(process, 4))), expected);
            EXPECT_EQ(
                Auto(With(ArrayTask(task, 0, 2, 1, 3), {{"OMPI_COMM_WORLD_RANK", std::to_string(process)},
                                                        {"OMPI_COMM_WORLD_SIZE", "4"}})),
                expected);
        }
    ExpectNoShard(With(ArrayTask(0, 0, 65535, 1, 65536), Step(0, 65536)), "65536 times 65536");
}

TEST(Shard, VariablesThatAreMissingOrMalformedAreNamed) {
    ExpectNoShard({}, "SLURM_ARRAY_TASK_ID, SLURM_PROCID and OMPI_COMM_WORLD_RANK");
    ExpectNoShard({{"SLURM_JOB_ID", "9"}, {"SLURM_PROCID", "0"}, {"SLURM_NTASKS", "4"}},
                  "SLURM_ARRAY_TASK_ID is not set, and neither is SLURM_STEP_ID");
    for (const char* name : {"COUNT", "MIN", "MAX", "STEP"}) {
        Environment environment = ArrayTask(0, 0, 15, 1, 16);
        const std::string variable = std::string("SLURM_ARRAY_TASK_") + name;
        environment.erase(variable);
        ExpectNoShard(environment, variable + " is not set");
        environment[variable] = "4x";
        ExpectNoShard(environment, variable + ": \"4x\"");
    }
    ExpectNoShard(With(ArrayTask(0, 0, 1, 1, 2), {{"SLURM_ARRAY_TASK_ID", ""}}), "SLURM_ARRAY_TASK_ID: \"\"");
    ExpectNoShard(With(ArrayTask(0, 0, 1, 1, 2), {{"SLURM_ARRAY_TASK_STEP", "0"}}),
                  "SLURM_ARRAY_TASK_STEP: ");
    ExpectNoShard({{"OMPI_COMM_WORLD_RANK", "1"}}, "OMPI_COMM_WORLD_SIZE is not set");
    ExpectNoShard({{"OMPI_COMM_WORLD_SIZE", "1"}}, "OMPI_COMM_WORLD_RANK is not set");
    ExpectNoShard({{"OMPI_COMM_WORLD_RANK", "2"}, {"OMPI_COMM_WORLD_SIZE", "2"}}, "2 is not below");
    ExpectNoShard({{"SLURM_STEP_ID", "0"}, {"SLURM_PROCID", "1"}}, "SLURM_NTASKS is not set");
    ExpectNoShard({{"SLURM_STEP_ID", "0"}, {"SLURM_NTASKS", "2"}}, "SLURM_PROCID is not set");
}

// The variables of `--array=1,3,7`, and of a range with some tasks repeated, do not determine the part.
TEST(Shard, AnArrayThatIsNoRangeIsRefused) {
    ExpectNoShard(ArrayTask(3, 1, 7, 1, 3), "not the tasks of one range");
    ExpectNoShard(ArrayTask(3, 0, 4, 2, 3), "not the tasks of one range");
    ExpectNoShard(ArrayTask(5, 0, 4, 1, 5), "not the tasks of one range");
    ExpectNoShard(ArrayTask(0, 1, 4, 1, 4), "not the tasks of one range");
}

TEST(Shard, FramesOfAPartHaveTheirTimesAndNumbers) {
    const FrameRange whole = ParseFrames("4:5.96:0.04");
    ASSERT_EQ(whole.Count(), 50u);
    uint32_t done = 0;
    for (const uint32_t index : {0u, 1u, 2u}) {
        const FrameRange part = PartOf(Shard{index, 3}, whole);
        for (uint32_t i = 0; i < part.Count(); ++i, ++done) {
            EXPECT_EQ(part.TimeOf(i), whole.TimeOf(done));
            EXPECT_EQ(part.NumberOf(i), whole.NumberOf(done));
        }
    }
    EXPECT_EQ(done, 50u);
    EXPECT_EQ(PartOf(Shard{0, 2}, ParseFrames("1:1:1")).Count(), 0u);
    EXPECT_EQ(PartOf(Shard{1, 2}, ParseFrames("1:1:1")).Count(), 1u);
}

}  // namespace
}  // namespace raygraph::cli::shard_test
