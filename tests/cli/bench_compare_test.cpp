#include "editor/cli/bench_compare.h"

#include <nlohmann/json.hpp>

#include "tests/cli/cli_test.h"

namespace raygraph::cli::bench_compare_test {
namespace {

using Json = nlohmann::ordered_json;

Json Result(const char* scene, double median, double standardError) {
    return {{"scene", scene},
            {"device", "a device"},
            {"settings", {{"size", "64x64"}}},
            {"cost", ToJson(RelativeCost{"cpu seconds", median, standardError})}};
}

BenchChange Compare(const Json& before, const Json& now, double tolerance = 0.05) {
    return CompareBench("stored.json", before.dump() + "\n", now, tolerance).at(0);
}

}  // namespace

TEST(BenchCompare, RatiosHaveTheirMedianAndItsStandardError) {
    // Deviations from 3 are 2, 1, 0, 1 and 7, their median 1: 1.4826 * sqrt(pi / 2) / sqrt(5)
    const RelativeCost cost = RelativeCostOf("gpu timestamps", {1.0, 2.0, 3.0, 4.0, 10.0});
    EXPECT_DOUBLE_EQ(cost.median, 3.0);
    EXPECT_NEAR(cost.standardError, 0.8310, 1e-3);
}

TEST(BenchCompare, OneRoundTellsNothingOfItsNoise) {
    const RelativeCost cost = RelativeCostOf("cpu seconds", {2.0});
    EXPECT_EQ(cost.standardError, std::numeric_limits<double>::infinity());
    Json now = Result("a.gltf", 2.0, 0.0);
    now["cost"] = ToJson(cost);
    // The stored run has null, since JSON has no infinity
    const BenchChange change = Compare(Result("a.gltf", 1.0, 0.0), Json::parse(now.dump()));
    EXPECT_FALSE(change.IsWorse());
    EXPECT_TRUE(change.IsUncertain());
}

TEST(BenchCompare, WorseIsMoreThanToleranceAndNoise) {
    const Json before = Result("scenes/a.gltf", 2.0, 0.0);
    const BenchChange slower = Compare(before, Result("elsewhere/a.gltf", 2.2, 0.0));
    EXPECT_NEAR(slower.change, 0.1, 1e-12);
    EXPECT_TRUE(slower.IsWorse());
    EXPECT_FALSE(Compare(before, Result("a.gltf", 2.08, 0.0)).IsWorse());
    EXPECT_TRUE(Compare(before, Result("a.gltf", 2.08, 0.0), 0.03).IsWorse());
    EXPECT_FALSE(Compare(before, Result("a.gltf", 1.0, 0.0)).IsWorse());
    // Two standard errors of either: 2 * 1.1 * hypot(0.1 / 2, 0.22 / 2.2) = 0.246
    const BenchChange noisy = Compare(Result("a.gltf", 2.0, 0.1), Result("a.gltf", 2.2, 0.22));
    EXPECT_NEAR(noisy.noise, 0.2460, 1e-3);
    EXPECT_FALSE(noisy.IsWorse());
    EXPECT_TRUE(noisy.IsUncertain());
    EXPECT_NE(ToText(noisy, Result("x/a.gltf", 2.2, 0.22)).find("+10.0%, noise 24.6%: uncertain"),
              std::string::npos);
}

TEST(BenchCompare, ViewportsCountWhereBothRunsHaveThem) {
    const auto with = [](double oneSamplePerFrame, double withinBudget, double budget = 120.0) {
        Json result = Result("a.gltf", 2.0, 0.0);
        result["viewport"] = {
            {"budget_ms", budget},
            {"one_a_frame", {{"cost", ToJson(RelativeCost{"cpu seconds", oneSamplePerFrame, 0.0})}}},
            {"within_budget", {{"cost", ToJson(RelativeCost{"cpu seconds", withinBudget, 0.0})}}}};
        return result;
    };
    const auto compare = [](const Json& before, const Json& now) {
        return CompareBench("stored.json", before.dump() + "\n", now, 0.05);
    };
    const std::vector<BenchChange> changes = compare(with(2.0, 3.0), with(2.2, 3.0));
    ASSERT_EQ(changes.size(), 3u);
    EXPECT_FALSE(changes[0].IsWorse());
    EXPECT_TRUE(changes[1].IsWorse());
    EXPECT_FALSE(changes[2].IsWorse());
    EXPECT_TRUE(compare(with(2.0, 3.0), with(2.0, 3.3))[2].IsWorse());
    EXPECT_NE(ToText(changes[1], with(2.2, 3.0)).find("a.gltf, viewport"), std::string::npos);
    EXPECT_EQ(compare(Result("a.gltf", 2.0, 0.0), with(2.2, 3.0)).size(), 1u);
    test::ExpectError(
        ErrorKind::BadInput, [&] { compare(with(2.0, 3.0, 30.0), with(2.0, 3.0)); }, "budget");
}

TEST(BenchCompare, TheLineOfTheSameSceneIsTaken) {
    const std::string stored =
        Result("a.gltf", 1.0, 0.0).dump() + "\n" + Result("b.gltf", 4.0, 0.0).dump() + "\n";
    EXPECT_NEAR(CompareBench("s.json", stored, Result("b.gltf", 3.0, 0.0), 0.0).at(0).change, -0.25, 1e-12);
}

TEST(BenchCompare, WhatCannotBeComparedIsRefused) {
    const Json now = Result("a.gltf", 2.0, 0.0);
    const auto expectRefusal = [&](const std::string& stored, const char* text) {
        test::ExpectError(
            ErrorKind::BadInput, [&] { (void)CompareBench("s.json", stored, now, 0.0); }, text);
    };
    expectRefusal(Result("b.gltf", 2.0, 0.0).dump(), "s.json: a.gltf: no stored run of this scene");
    expectRefusal("nonsense", "s.json: a line that is no result of raygraph bench");
    expectRefusal(R"({"scene": "a.gltf"})", "s.json: a.gltf: stored by a program without costs");
    Json other = now;
    other["device"] = "another";
    expectRefusal(other.dump(), "stored with the device \"another\", this run has \"a device\"");
    other = now;
    other["settings"]["size"] = "32x32";
    expectRefusal(other.dump(), "setting size \"32x32\"");
    other = now;
    other["cost"]["limit_path_version"] = 2;
    expectRefusal(other.dump(), "limit_path_version 2, this run has 1");
    other = now;
    other["settings"]["removed"] = "x";
    EXPECT_EQ(Compare(other, now).change, 0.0) << "an option that this program does not know";
}

}  // namespace raygraph::cli::bench_compare_test
