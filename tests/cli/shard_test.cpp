// Tests --shard: the parts by text and by the variables of launchers.
#include "editor/cli/picture_list.h"

#include <limits>
#include <map>

#include "tests/cli/cli_test.h"

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
