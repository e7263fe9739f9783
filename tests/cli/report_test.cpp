#include "editor/cli/report.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/cli/cli_test.h"
#include "tests/support/temporary_folder.h"

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
    const nlohmann::json json = nlohmann::json::parse(ToJson({}));
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
