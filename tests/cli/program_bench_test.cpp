// Tests `raygraph bench` by the built program. It needs a device.
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_bench_test {
namespace {

using test::ProgramResult;
using test::RunProgram;

nlohmann::json JsonOf(const std::filesystem::path& path) {
    std::ifstream file(path);
    return nlohmann::json::parse(file);
}

}  // namespace

TEST(ProgramBench, TimesAViewportAgainstARender) {
    const test::TemporaryFolder folder;
    const std::string line = "bench @cornell.gltf --viewport --size 32x18 --frames 2 --rounds 3";
    const ProgramResult result = RunProgram(folder, line + " --json b.json");
    ASSERT_EQ(result.exitCode, 0) << result.messages;
    const nlohmann::json json = JsonOf(folder / "b.json"), viewport = json.at("viewport");
    EXPECT_EQ(viewport.at("budget_ms"), 120.0);
    EXPECT_DOUBLE_EQ(viewport.at("render").at("relative"), 1.0);
    EXPECT_DOUBLE_EQ(viewport.at("one_a_frame").at("samples_per_frame"), 1.0);
    for (const char* kind : {"render", "one_a_frame", "within_budget"}) {
        const nlohmann::json& cost = viewport.at(kind);
        EXPECT_GT(cost.at("cpu_s_per_sample"), 0.0) << kind;
        EXPECT_GT(cost.at("gpu_ms_per_sample"), 0.0) << kind;
        EXPECT_NEAR(cost.at("cost").at("median").get<double>(),
                    cost.at("relative").get<double>() * json.at("cost").at("median").get<double>(), 1e-6)
            << kind;
    }
    nlohmann::json faster = json;
    faster["viewport"]["one_a_frame"]["cost"]["median"] = 1e-3;
    faster["viewport"]["one_a_frame"]["cost"]["standard_error"] = 0.0;
    std::ofstream(folder / "faster.json") << faster.dump() << "\n";
    const ProgramResult slower = RunProgram(folder, line + " --compare faster.json --tolerance 20");
    EXPECT_EQ(slower.exitCode, 6) << slower.messages;
    EXPECT_NE(slower.messages.find("cornell.gltf, viewport"), std::string::npos) << slower.messages;
}

TEST(ProgramBench, PrintsOneLineOfJsonWithTheEfficiency) {
    const test::TemporaryFolder folder;
    const ProgramResult result =
        RunProgram(folder, "bench @cornell.gltf --size 64x36 --frames 2 --rounds 2 --json b.json");
    ASSERT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_EQ(result.output.find('\n') + 1, result.output.size());
    const nlohmann::json json = nlohmann::json::parse(result.output);
    EXPECT_EQ(json, JsonOf(folder / "b.json"));
    EXPECT_EQ(json.at("settings").at("max-depth"), "16");
    EXPECT_EQ(json.at("frames"), 4);
    const double trace = json.at("trace").at("mrays_per_s"), path = json.at("limit_path").at("mrays_per_s");
    EXPECT_GT(trace, 0.0);
    EXPECT_NEAR(json.at("trace_efficiency").get<double>(), trace / path, 1e-6);
    const nlohmann::json& own = json.at("limit_path_own");
    EXPECT_NEAR(json.at("trace_efficiency_own").get<double>(), trace / own.at("mrays_per_s").get<double>(),
                1e-6);
    constexpr double kAtEdges = 23.0;  // bound on the paths, of 2,304, whose ray count depends on rounding
    EXPECT_NEAR(own.at("rays_per_sample").get<double>(),
                json.at("limit_path").at("rays_per_sample").get<double>(), kAtEdges / (64.0 * 36.0));
    EXPECT_DOUBLE_EQ(json.at("limit").at("rays_per_sample"), 1.0);
    EXPECT_GT(json.at("trace").at("rays_per_sample").get<double>(), 1.0);
    EXPECT_GT(json.at("msamples_per_cpu_s").get<double>(), 0.0);
    const nlohmann::json& recursion = json.at("recursion");
    const double loop = recursion.at("loop_ms");
    EXPECT_GT(loop, 0.0);
    if (recursion.at("recursive_ms").is_null()) {
        EXPECT_TRUE(recursion.at("loop_speedup").is_null());
        EXPECT_NE(result.messages.find("recursive not measured"), std::string::npos) << result.messages;
    } else {
        EXPECT_NEAR(recursion.at("loop_speedup"), recursion.at("recursive_ms").get<double>() / loop, 1e-6);
        EXPECT_NE(result.messages.find("recursion: loop "), std::string::npos) << result.messages;
    }
    const nlohmann::json& medians = json.at("gpu_ms_median");
    const char* tracing = medians.contains("Trace") ? "Trace" : "WaveFirst";  // depends on the form
    for (const char* pass : {tracing, "Accumulate", "Tonemap", "Limit", "LimitPath", "LambertLoop"})
        EXPECT_GT(medians.at(pass).get<double>(), 0.0) << pass;

    // Compares with a stored run at a quarter of the cost, and with one at four times the cost
    const auto compare = [&](double factor) {
        nlohmann::json stored = json;
        stored["cost"]["median"] = factor * json.at("cost").at("median").get<double>();
        stored["cost"]["standard_error"] = 0.0;
        std::ofstream(folder / "stored.json") << stored.dump() << "\n";
        return RunProgram(
            folder,
            "bench @cornell.gltf --size 64x36 --frames 2 --rounds 3 --compare stored.json --tolerance 0.5");
    };
    const ProgramResult slower = compare(0.25);
    EXPECT_EQ(slower.exitCode, 6) << slower.messages;
    EXPECT_NE(slower.messages.find(": worse"), std::string::npos) << slower.messages;
    EXPECT_EQ(compare(4.0).exitCode, 0);
}

}  // namespace raygraph::program_bench_test
