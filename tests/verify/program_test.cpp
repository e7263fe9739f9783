// `raygraph compare` and `raygraph verify` as a user runs them.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "renderer/image/exr.h"
#include "tests/cli/program_runner.h"

namespace raygraph::verify_program_test {

namespace {

using test::ProgramResult;
using test::RunProgram;

nlohmann::json Json(const std::filesystem::path& file) {
    std::ifstream stream(file);
    return nlohmann::json::parse(stream, nullptr, false);
}

std::string TextOf(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

TEST(ProgramVerify, RightPicture_IsDoneAndAWrongOneIsNot) {
    const test::TemporaryFolder folder;
    const test::EnvironmentVariable cache("XDG_CACHE_HOME", (folder / "cache").string());
    const std::string render = "render @cornell.gltf --size 32x24 --spp 64 --quiet -o ";
    ASSERT_EQ(RunProgram(folder, render + "right.exr").exitCode, 0);
    ASSERT_EQ(RunProgram(folder, render + "direct.exr --max-depth 1").exitCode, 0);
    const ProgramResult right =
        RunProgram(folder, "verify @cornell.gltf right.exr --spp 64 --json right.json --html page.html");
    EXPECT_EQ(right.exitCode, 0) << right.output << right.messages;
    EXPECT_NE(right.output.find("right.exr: right (64 samples of the reference, 64 new)"), std::string::npos)
        << right.output;
    EXPECT_TRUE(Json(folder / "right.json").at("right").get<bool>());
    const std::string page = TextOf(folder / "page.html");
    EXPECT_NE(page.find("data:image/png;base64,iVBORw0KGgo"), std::string::npos);
    EXPECT_EQ(page.find("src=\"http"), std::string::npos) << "the page needs nothing else";

    // The reference is that of before
    const ProgramResult wrong =
        RunProgram(folder, "verify @cornell.gltf direct.exr right.exr --spp 64 --json wrong.json");
    EXPECT_EQ(wrong.exitCode, 7) << wrong.output << wrong.messages;
    const nlohmann::json report = Json(folder / "wrong.json");
    EXPECT_FALSE(report.at("right").get<bool>());
    ASSERT_EQ(report.at("pictures").size(), 2u);
    const nlohmann::json& first = report["pictures"][0];
    EXPECT_EQ(first.at("new_samples"), 0);
    EXPECT_FALSE(first.at("right").get<bool>());
    EXPECT_EQ(first.at("hypotheses").at(0).at("name"), "indirect") << first["hypotheses"].dump(1);
    EXPECT_NEAR(first["hypotheses"][0].at("amount").get<double>(), -1.0, 0.1);
    EXPECT_TRUE(report["pictures"][1].at("right").get<bool>());
    EXPECT_NE(wrong.output.find("the picture lacks indirect light"), std::string::npos) << wrong.output;
}

TEST(ProgramCompare, WritesNumbersAndPictures) {
    const test::TemporaryFolder folder;
    image::WriteHdr(folder / "a.hdr", {2, 2, std::vector<float>(16, 0.5f)});
    image::WriteHdr(folder / "b.hdr", {2, 2, std::vector<float>(16, 1.0f)});
    const ProgramResult result = RunProgram(folder, "compare a.hdr b.hdr --json c.json -o d.png -o d.exr");
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_NE(result.output.find("energy  R +100.00 %, G +100.00 %, B +100.00 %"), std::string::npos)
        << result.output;
    EXPECT_NEAR(Json(folder / "c.json").at("relmse").get<double>(), 0.25 / 0.26, 1e-6);
    const image::ExrImage difference = image::ReadExr(folder / "d.exr");
    EXPECT_EQ(difference.FloatChannel("R")->front(), 0.5f);
    EXPECT_EQ(difference.FloatChannel("stops")->front(), 1.0f);
    EXPECT_GT(difference.FloatChannel("flip")->front(), 0.1f);
    EXPECT_TRUE(std::filesystem::exists(folder / "d.png"));

    image::WriteHdr(folder / "small.hdr", {1, 2, std::vector<float>(8, 0.5f)});
    std::ofstream(folder / "text.exr") << "text";
    const ProgramResult sizes = RunProgram(folder, "compare a.hdr small.hdr");
    EXPECT_EQ(sizes.exitCode, 4);
    EXPECT_EQ(sizes.messages, "raygraph: small.hdr has 1x2 pixels, and a.hdr has 2x2\n");
    const ProgramResult text = RunProgram(folder, "compare a.hdr text.exr");
    EXPECT_EQ(text.exitCode, 4);
    EXPECT_EQ(text.messages, "raygraph: text.exr: neither a PNG, a Radiance HDR nor an OpenEXR\n");
    EXPECT_EQ(RunProgram(folder, "compare a.hdr b.hdr --transfer pq").exitCode, 2);
    EXPECT_EQ(RunProgram(folder, "compare a.hdr").exitCode, 2);
}

}  // namespace raygraph::verify_program_test
