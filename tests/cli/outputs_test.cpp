#include <fcntl.h>
#include <linux/fs.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <chrono>
#include <fstream>
#include <new>
#include <nlohmann/json.hpp>

#include "base/files.h"
#include "editor/cli/bench_compare.h"
#include "editor/cli/outputs.h"
#include "editor/cli/rendering.h"
#include "editor/cli/report.h"
#include "tests/cli/cli_test.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/text_files.h"

namespace raygraph::cli::outputs_test {
namespace {

using test::FileCount;

using Paths = std::vector<std::filesystem::path>;

TEST(Outputs, CheckingLeavesNoTrace) {
    const test::TemporaryFolder folder;
    const std::filesystem::path old = folder.Path() / "old.png";
    std::ofstream(old) << "old";
    CheckOutputs(Paths{folder.Path() / "new.png", old}, {});
    EXPECT_EQ(FileCount(folder.Path()), 1u);
    EXPECT_EQ(std::filesystem::file_size(old), 3u);
}

TEST(Outputs, ANameThatIsTooLongIsRefusedBeforeTheWork) {
    const test::TemporaryFolder folder;
    // A name that is too long beside a valid one: a sequence may have a long number or camera in its names
    std::string name = ".png";
    name.insert(0, 300, 'a');
    const Paths paths{folder.Path() / "a.png", folder.Path() / name};
    test::ExpectError(
        ErrorKind::Io, [&] { CheckOutputs(paths, {}); }, "cannot write: File name too long");
}

// Covers /dev/stdout, and the pipes that a shell makes of >(program).
TEST(Outputs, DevicesAndPipesAreTakenWithoutTouchingThem) {
    const test::TemporaryFolder folder;
    const std::filesystem::path pipe = folder.Path() / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_TRUE(CheckOutputs(Paths{"/dev/null", pipe}, {}).empty());
}

TEST(Outputs, OneThatCannotBeWrittenKeepsNoOther) {
    std::vector<std::string> said;
    OutputWriter outputs([&](const std::filesystem::path& file, std::string_view why) {
        said.push_back(file.string() + ": " + std::string(why));
    });
    outputs.Add("a", [] {});
    outputs.Add("b", [] { throw Error(ErrorKind::Io, "the disk is full"); });
    outputs.Add("c", [] { throw std::bad_alloc(); });
    outputs.Add("d", [] { throw IncompleteFile(ErrorKind::Io, "the disk is broken"); });
    outputs.Add("e", [] {});
    outputs.WriteAll();
    EXPECT_EQ(outputs.Written(), (Paths{"a", "e"}));
    EXPECT_EQ(said,
              (std::vector<std::string>{"b: the disk is full", "c: out of memory", "d: the disk is broken"}));
    EXPECT_EQ(outputs.Result(), ExitCode::Failure) << "that of the first";
    for (const char* name : {"a", "b", "c", "d", "e"}) {
        EXPECT_EQ(outputs.HasWritten(name), *name == 'a' || *name == 'e') << name;
        EXPECT_EQ(outputs.IsTorn(name), *name == 'd') << name;
    }
}

// The reader of a stream may never come.
TEST(Outputs, DevicesAndPipesAreWrittenAfterAllFiles) {
    const test::TemporaryFolder folder;
    const std::filesystem::path pipe = folder / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    OutputWriter outputs([](const std::filesystem::path&, std::string_view) {});
    for (const std::filesystem::path& file : Paths{pipe, "a", "/dev/null", "b"}) outputs.Add(file, [] {});
    outputs.WriteAll();
    EXPECT_EQ(outputs.Written(), (Paths{"a", "b", pipe, "/dev/null"}));
}

// A file that is written in place, a stream and a link tell nothing about whether their folder takes new
// files.
TEST(Outputs, ANewFileIsRefusedWhateverCouldBeWrittenBesideIt) {
    const test::TemporaryFolder folder, elsewhere;
    const std::filesystem::path mounted = folder / "mounted.png", pipe = folder / "pipe",
                                link = folder / "link";
    std::ofstream(mounted) << "old";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    std::filesystem::create_symlink(elsewhere / "a.png", link);
    // The immutable folder takes no new files; the link's folder does.
    const int descriptor = open(folder.Path().c_str(), O_RDONLY | O_DIRECTORY);
    int flags = FS_IMMUTABLE_FL;
    const bool isFixed = ioctl(descriptor, FS_IOC_SETFLAGS, &flags) == 0;
    for (const std::filesystem::path& first : isFixed ? Paths{mounted, pipe, link} : Paths{}) {
        SCOPED_TRACE(first);
        const Paths paths{first, folder / "b.png"};
        test::ExpectError(
            ErrorKind::Io, [&] { CheckOutputs(paths, {}); }, "b.png: cannot create a file in its folder");
    }
    flags = 0;
    ioctl(descriptor, FS_IOC_SETFLAGS, &flags);
    close(descriptor);
    if (!isFixed) GTEST_SKIP() << "a file cannot be made immutable here";
}

TEST(Outputs, AMissingFolderIsNamed) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.Path() / "none" / "a.png";
    test::ExpectError(
        ErrorKind::Io, [&] { CheckOutputs(Paths{path}, {}); }, path.string(),
        "does not exist; create it first");
}

TEST(Outputs, AFolderIsNoOutput) {
    const test::TemporaryFolder folder;
    std::filesystem::create_directory(folder.Path() / "a.png");
    test::ExpectError(
        ErrorKind::Io, [&] { CheckOutputs(Paths{folder.Path() / "a.png"}, {}); }, "a.png");
}

TEST(Outputs, AFolderThatIsClosedToUsIsRefused) {
    if (geteuid() == 0) GTEST_SKIP() << "nothing is closed to root";
    const test::TemporaryFolder folder;
    std::filesystem::permissions(folder.Path(),
                                 std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
    test::ExpectError(
        ErrorKind::Io, [&] { CheckOutputs(Paths{folder.Path() / "a.png"}, {}); }, "a.png");
}

TEST(Outputs, OneFileUnderTwoNamesIsRefused) {
    const test::TemporaryFolder folder;
    test::ExpectError(
        ErrorKind::Usage,
        [&] {
            CheckOutputs(Paths{folder.Path() / "a.png", folder.Path() / "." / "a.png"}, {});
        },
        "twice");
}

TEST(Outputs, AnInputIsNotOverwritten) {
    const test::TemporaryFolder folder;
    const std::filesystem::path sky = folder.Path() / "sky.hdr";
    std::ofstream(sky) << "x";
    std::filesystem::create_symlink(sky, folder.Path() / "link.hdr");
    test::ExpectError(
        ErrorKind::Usage, [&] { CheckOutputs(Paths{folder.Path() / "link.hdr"}, Paths{sky}); }, "link.hdr",
        "read");
}

// Returns the paths "f.0.png", "f.1.png" and so on in the folder.
Paths Sequence(const std::filesystem::path& folder, int count) {
    Paths paths;
    for (int i = 0; i < count; ++i) paths.push_back(folder / ("f." + std::to_string(i) + ".png"));
    return paths;
}

// This holds whatever is wrong with the name: the ones before it in the folder are valid.
TEST(Outputs, OneOfASequenceIsRefusedAsItWouldBeAlone) {
    const test::TemporaryFolder folder;
    const Paths paths = Sequence(folder.Path(), 20);
    const std::filesystem::path input = folder.Path() / "scene.gltf";
    std::ofstream(input) << "x";
    std::ofstream(paths[3]) << "old";
    EXPECT_EQ(testing::ErrorTextOf([&] { CheckOutputs(paths, Paths{input}); }), "accepted");
    const auto refused = [&](ErrorKind kind, const std::string& what) {
        test::ExpectError(
            kind, [&] { CheckOutputs(paths, Paths{input}); }, what);
        std::filesystem::remove(paths[7]);
    };
    std::filesystem::create_symlink(paths[3], paths[7]);
    refused(ErrorKind::Usage, "f.7.png is to be written twice");
    std::filesystem::create_symlink(input, paths[7]);
    refused(ErrorKind::Usage, "f.7.png is to be read and to be written");
    std::filesystem::create_symlink(folder.Path() / "none" / "f.png", paths[7]);
    refused(ErrorKind::Io, "cannot create a file in its folder");
    std::filesystem::create_directory(paths[7]);
    refused(ErrorKind::Io, "f.7.png: cannot write: it is a folder");
    EXPECT_EQ(FileCount(folder.Path()), 2u);
}

TEST(Outputs, OneFolderUnderTwoNamesIsOne) {
    const test::TemporaryFolder folder;
    std::filesystem::create_directory(folder.Path() / "a");
    std::filesystem::create_directory_symlink("a", folder.Path() / "b");
    Paths paths = Sequence(folder.Path() / "a", 3);
    paths.push_back(folder.Path() / "b" / "f.1.png");
    test::ExpectError(
        ErrorKind::Usage, [&] { CheckOutputs(paths, {}); }, "b/f.1.png is to be written twice");
    test::ExpectError(
        ErrorKind::Usage, [&] { CheckLogFile(paths.back(), Paths{paths[1]}, {}); },
        "b/f.1.png is to be written twice");
    EXPECT_EQ(FileCount(folder.Path() / "a"), 0u);
}

// Creating and removing a file for each name would take ten times as long.
TEST(Outputs, ALongSequenceIsCheckedInAFractionOfASecond) {
    const test::TemporaryFolder folder;
    const Paths paths = Sequence(folder.Path(), 100'000);
    const auto start = std::chrono::steady_clock::now();
    CheckOutputs(paths, {});
    CheckLogFile(folder.Path() / "log", paths, {});
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    RecordProperty("seconds", std::to_string(taken.count()));
    EXPECT_LT(taken.count(), 5.0);
}

}  // namespace
}  // namespace raygraph::cli::outputs_test

namespace raygraph::cli::report_test {
namespace {

std::vector<std::string> Keys(const nlohmann::json& json) {
    std::vector<std::string> keys;
    for (const auto& [key, value] : json.items()) keys.push_back(key);
    return keys;
}

using Names = std::vector<std::string>;

TEST(Report, SettingsNameTheEnvironmentWhereThereIsOne) {
    session::RenderFile render = test::MakeRender(0, 4);
    const SettingTexts texts = SettingsForReport({}, render, 4);
    EXPECT_EQ(texts.at("env"), "sky.hdr");
    EXPECT_EQ(texts.at("spp"), "4");
    EXPECT_EQ(texts.at("sample-offset"), "0");
    render.environmentFile.clear();
    EXPECT_FALSE(SettingsForReport({}, render, {}).contains("env"));
    EXPECT_FALSE(SettingsForReport({}, render, {}).contains("spp"));
}

TEST(Report, SchemaOneHasTheseMembers) {
    Report report;
    report.passes = {{"Trace", 1.5, 30.0, 20}};
    const nlohmann::json json = nlohmann::json::parse(ToJson(report));
    EXPECT_EQ(json.at("schema"), 2);
    EXPECT_EQ(Keys(json.at("scene")),
              (Names{"file", "instances", "lights", "materials", "points_placed", "segments_placed",
                     "textures", "triangles_placed", "triangles_unique"}));
    EXPECT_EQ(Keys(json.at("device")), (Names{"driver", "name", "type"}));
    EXPECT_EQ(Keys(json.at("timings_ms")),
              (Names{"blas_build", "compaction", "first_sample", "load", "pipelines", "render", "upload"}));
    EXPECT_EQ(Keys(json.at("passes").at(0)), (Names{"count", "gpu_ms_median", "gpu_ms_total", "name"}));
    EXPECT_EQ(Keys(json.at("acceleration")),
              (Names{"blas_count", "bytes_built", "bytes_compacted", "tlas_bytes"}));
    EXPECT_EQ(Keys(json.at("memory")),
              (Names{"budget_of_driver", "device_fallback_bytes", "device_peak_bytes", "heaps",
                     "host_peak_bytes", "reduced_textures", "texture_budget_bytes", "texture_bytes"}));
    EXPECT_EQ(Keys(json.at("throughput")), (Names{"mrays_per_s", "msamples_per_s", "rays_per_sample"}));
    EXPECT_EQ(Keys(json.at("image")), (Names{"mean", "nonfinite_samples", "relative_error"}));
    EXPECT_TRUE(json.contains("settings"));
    EXPECT_TRUE(json.at("removed").empty());
    report.removed[session::Bias::MaxDepth] = {.samples = 4, .mean = 0.5, .share = 0.25};
    const nlohmann::json removed = nlohmann::json::parse(ToJson(report)).at("removed").at("max_depth");
    EXPECT_EQ(Keys(removed),
              (Names{"luminance", "samples", "share", "share_standard_error", "standard_error"}));
    EXPECT_EQ(removed.at("luminance"), 0.5);
    EXPECT_TRUE(removed.at("standard_error").is_null());
}

TEST(Report, NumbersAreInTheirUnits) {
    Report report;
    report.throughput = {2.5e6, 4.0};
    report.image.relativeError = 0.125;
    report.settings.emplace("seed", "3");
    const nlohmann::json json = nlohmann::json::parse(ToJson(report));
    EXPECT_DOUBLE_EQ(json.at("throughput").at("msamples_per_s"), 2.5);
    EXPECT_DOUBLE_EQ(json.at("throughput").at("mrays_per_s"), 10.0);
    EXPECT_DOUBLE_EQ(json.at("image").at("relative_error"), 0.125);
    EXPECT_EQ(json.at("settings").at("seed"), "3");
}

TEST(Report, ListsTheHeapsOfTheDevice) {
    Report report;
    report.memory.heaps = {{true, 8u << 20, 7u << 20, 5u << 20}, {false, 16u << 20, 15u << 20, 1u << 20}};
    const nlohmann::json heaps = nlohmann::json::parse(ToJson(report)).at("memory").at("heaps");
    ASSERT_EQ(heaps.size(), 2u);
    EXPECT_EQ(Keys(heaps[0]), (Names{"budget_bytes", "of_device", "size_bytes", "used_bytes"}));
    EXPECT_EQ(heaps[0].at("of_device"), true);
    EXPECT_EQ(heaps[0].at("budget_bytes"), 7u << 20);
    EXPECT_EQ(heaps[1].at("of_device"), false);
    EXPECT_EQ(heaps[1].at("used_bytes"), 1u << 20);
}

TEST(Report, WhatIsNotKnownIsNull) {
    const nlohmann::json json = nlohmann::json::parse(ToJson(Report{}));
    EXPECT_TRUE(json.at("throughput").at("msamples_per_s").is_null());
    EXPECT_TRUE(json.at("throughput").at("mrays_per_s").is_null());
    EXPECT_TRUE(json.at("throughput").at("rays_per_sample").is_null());
    EXPECT_TRUE(json.at("image").at("relative_error").is_null());
}

TEST(Report, SaysWhyCompactionIsOff) {
    Report report;
    report.acceleration.compactionDisabledReason = std::string("ratio 1.000");
    const nlohmann::json json = nlohmann::json::parse(ToJson(report));
    EXPECT_EQ(json.at("acceleration").at("why_compaction_off"), "ratio 1.000");
}

TEST(Report, NamesThatAreNoUtf8AreStillJson) {
    Report report;
    report.scene.file = std::string("\xff\xfe.gltf");
    EXPECT_NO_THROW(std::ignore = nlohmann::json::parse(ToJson(report)));
}

TEST(Report, ATextFileIsReplacedWhole) {
    const test::TemporaryFolder folder;
    WriteTextFile(folder / "r.json", "a longer text");
    WriteTextFile(folder / "r.json", "short");
    std::ifstream file(folder / "r.json");
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "short");
}

}  // namespace
}  // namespace raygraph::cli::report_test

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

// Tests what the first process of a render sends to the others.
namespace raygraph::cli::render_job_test {
namespace {

TEST(RenderJob, TextSaysAllOfIt) {
    RenderJob job;
    job.settings.size = {20, 14};
    job.settings.paths.seed = 5;
    job.settings.camera = "a \"front\" camera";
    job.settings.lightGroups = {{"lamps", {"l\xE4mp*"}}};  // not UTF-8: a pattern may have any bytes
    job.aovs = {Aov::Albedo, Aov::Depth};
    job.firstSample = 7;
    job.samplesWanted = 100;
    RenderJob told = JobFrom(JobText(job));
    EXPECT_EQ(Texts(told.settings), Texts(job.settings));
    EXPECT_EQ(told.aovs, job.aovs);
    EXPECT_EQ(told.firstSample, 7u);
    EXPECT_EQ(told.samplesWanted, 100u);
    job.samplesWanted.reset();
    told = JobFrom(JobText(job));
    EXPECT_FALSE(told.samplesWanted) << "until the time is up";
}

TEST(RenderJob, ATextThatIsNoneIsBadInput) {
    for (const char* text : {"", "{}", "[1]", "job"})
        test::ExpectError(
            ErrorKind::BadInput, [&] { JobFrom(text); }, "the render that is asked for cannot be read");
}

}  // namespace
}  // namespace raygraph::cli::render_job_test
