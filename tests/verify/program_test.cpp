// `raygraph compare` and `raygraph verify` as a user runs them.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "renderer/image/exr.h"
#include "tests/cli/program_runner.h"
#include "tests/support/own_cache.h"
#include "tests/support/text_files.h"

namespace raygraph::verify_program_test {

namespace {

using test::ProgramResult;
using test::RunProgram;

nlohmann::json Json(const std::filesystem::path& file) {
    std::ifstream stream(file);
    return nlohmann::json::parse(stream, nullptr, false);
}

}  // namespace

TEST(ProgramVerify, RightPicture_IsDoneAndAWrongOneIsNot) {
    const test::TemporaryFolder folder;
    const test::OwnCache cache(folder / "cache");
    const std::string render = "render @cornell.gltf --size 32x24 --spp 64 --quiet -o ";
    ASSERT_EQ(RunProgram(folder, render + "right.exr").exitCode, 0);
    ASSERT_EQ(RunProgram(folder, render + "direct.exr --max-depth 1").exitCode, 0);
    const ProgramResult right =
        RunProgram(folder, "verify @cornell.gltf right.exr --spp 64 --json right.json --html page.html");
    EXPECT_EQ(right.exitCode, 0) << right.output << right.messages;
    EXPECT_NE(right.output.find("right.exr: right (64 samples of the reference, 64 new)"), std::string::npos)
        << right.output;
    EXPECT_TRUE(Json(folder / "right.json").at("right").get<bool>());
    const std::string page = test::TextOf(folder / "page.html");
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
    // From the cache comes the verdict that the run gave which rendered the reference, with its numbers
    nlohmann::json cold = Json(folder / "right.json").at("pictures").at(0);
    EXPECT_EQ(cold.at("new_samples"), 64);
    cold["new_samples"] = 0;
    EXPECT_EQ(report["pictures"][1], cold);
    EXPECT_NE(wrong.output.find("the picture lacks indirect light"), std::string::npos) << wrong.output;

    // The command for the worst pixel is complete: it runs from any folder, and is of the reference
    const nlohmann::json& worst = first.at("worst_pixels").at(0);
    const std::string command = worst.at("explain");
    ASSERT_TRUE(command.starts_with("raygraph explain ")) << command;
    const test::TemporaryFolder elsewhere;
    const ProgramResult explained = RunProgram(elsewhere, command.substr(9) + " --json");
    ASSERT_EQ(explained.exitCode, 0) << command << explained.messages;
    const nlohmann::json pixel = nlohmann::json::parse(explained.output);
    EXPECT_EQ(pixel.at("pixel"), (nlohmann::json{worst.at("x"), worst.at("y")}));
    for (size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(pixel.at("mean").at(c).get<double>(), worst.at("reference").at(c).get<double>(), 1e-6);
}

TEST(ProgramVerify, List_HasTolerancesRegionsAndAcceptedDifferences) {
    const test::TemporaryFolder folder;
    const std::string render = "render @cornell.gltf --size 16x16 --quiet -o ";
    ASSERT_EQ(RunProgram(folder, render + "albedo.exr --view albedo --spp 64").exitCode, 0);
    ASSERT_EQ(RunProgram(folder, render + "depth.exr --view depth --spp 1").exitCode, 0);
    const auto verify = [&](const std::string& more, const std::string& options = "") {
        std::ofstream(folder / "verify.json")
            << R"({"cases": [{"scene": ")" << test::SceneFile("cornell.gltf")
            << R"(", "against": "albedo", "spp": 64, "pictures": ["albedo.exr"]}, {"scene": ")"
            << test::SceneFile("cornell.gltf")
            << R"(", "against": "albedo", "spp": 64, "pictures": ["depth.exr"])" << more << "}]}";
        return RunProgram(folder, "verify verify.json --no-cache --jobs 2 --json report.json" + options);
    };
    EXPECT_EQ(verify("").exitCode, 7);
    const nlohmann::json report = Json(folder / "report.json");
    EXPECT_EQ(report.at("pictures").at(0).at("new_samples").get<int>() +
                  report["pictures"].at(1).at("new_samples").get<int>(),
              64)
        << "of one reference, which both share";
    EXPECT_TRUE(report.at("pictures").at(0).at("right").get<bool>());
    EXPECT_FALSE(report["pictures"].at(1).at("right").get<bool>());
    const std::string wide =
        R"(, "tolerance": {"relative": 1e5, "energy": 1e5, "parts": 1e5, "flip": 1, "ssim": 2})";
    EXPECT_EQ(verify(wide).exitCode, 0);
    const ProgramResult ignored = verify(R"(, "regions": ["object:*=ignore"])");
    EXPECT_EQ(ignored.exitCode, 4) << ignored.messages;
    EXPECT_NE(ignored.messages.find("no pixel counts"), std::string::npos) << ignored.messages;
    // A picture that cannot be read keeps no other from its verdict
    std::ofstream(folder / "text.exr") << "text";
    const ProgramResult unreadable = verify(R"(, "pictures": ["text.exr", "depth.exr"])");
    EXPECT_EQ(unreadable.exitCode, 4);
    const nlohmann::json errors = Json(folder / "report.json");
    EXPECT_FALSE(errors.at("right").get<bool>());
    ASSERT_EQ(errors.at("errors").size(), 1u) << errors.dump(1);
    EXPECT_EQ(errors["errors"][0].at("picture"), "text.exr");
    EXPECT_EQ(errors.at("pictures").size(), 2u);
    // An accepted difference counts as right, for this reference
    EXPECT_EQ(verify("", " --update").exitCode, 0);
    EXPECT_TRUE(std::filesystem::exists(folder / "accepted" / "cornell.depth.exr"));
    const ProgramResult accepted = verify("");
    EXPECT_EQ(accepted.exitCode, 0);
    EXPECT_NE(accepted.output.find("right, with the accepted difference"), std::string::npos)
        << accepted.output;
    const ProgramResult stale = verify(R"(, "settings": {"seed": 5})");
    EXPECT_EQ(stale.exitCode, 4);
    EXPECT_NE(stale.messages.find("was accepted for another scene"), std::string::npos) << stale.messages;
    for (const auto& [more, why] :
         {std::pair(R"(, "gamma": 2)", "verify.json: cases[1].gamma: there is no such key"),
          std::pair(R"(, "spp": "many")", "cases[1].spp: its value has the wrong type"),
          std::pair(R"(, "spp": -4)", "cases[1].spp: it is not from 2 to 16777216"),
          std::pair("\n\n, spp", "verify.json: line 3: it is no JSON"),
          std::pair(R"(, "pictures": ["a/b.exr", "a.b.exr"])", "have one accepted difference"),
          std::pair(R"(, "regions": ["x"])", "is neither object:PATTERN=X")}) {
        const ProgramResult refused = verify(more);
        EXPECT_EQ(refused.exitCode, std::string_view(why).starts_with("have") ? 2 : 4);
        EXPECT_NE(refused.messages.find(why), std::string::npos) << refused.messages;
    }
}

TEST(ProgramVerify, ViewsOfThisProgram_AreRight) {
    const test::TemporaryFolder folder;
    nlohmann::json cases;
    for (const std::string view : {"normals", "albedo", "roughness"}) {
        ASSERT_EQ(RunProgram(folder, "render @cornell.gltf --size 24x20 --quiet --spp 64 --view " + view +
                                         " -o " + view + ".exr -o " + view + ".png")
                      .exitCode,
                  0);
        cases.push_back({{"scene", test::SceneFile("cornell.gltf")},
                         {"against", view},
                         {"transfer", view == "roughness" ? "linear" : "srgb"},
                         {"pictures", {view + ".exr", view + ".png"}}});
    }
    std::ofstream(folder / "verify.json") << nlohmann::json{{"cases", cases}};
    const ProgramResult right = RunProgram(folder, "verify verify.json --no-cache");
    EXPECT_EQ(right.exitCode, 0) << right.output << right.messages;
    // Other views paint their values
    const ProgramResult painted =
        RunProgram(folder, "verify @cornell.gltf normals.png albedo.exr --against depth --no-cache");
    EXPECT_EQ(painted.exitCode, 4);
    EXPECT_NE(painted.messages.find("normals.png: a .png shows depth in colors for people"),
              std::string::npos)
        << painted.messages;
    // What a list says is not said again
    const ProgramResult twice = RunProgram(folder, "verify verify.json --tolerance 0.5");
    EXPECT_EQ(twice.exitCode, 2);
    EXPECT_NE(twice.messages.find("--tolerance cannot be used with a list; set it in verify.json"),
              std::string::npos)
        << twice.messages;
}

TEST(ProgramVerify, TransposedMask_IsRefusedBeforeAnythingIsRendered) {
    const test::TemporaryFolder folder;
    image::WriteHdr(folder / "picture.hdr", {6, 4, std::vector<float>(96, 0.5f)});
    image::WriteHdr(folder / "mask.hdr", {4, 6, std::vector<float>(96, 1.0f)});
    const ProgramResult refused =
        RunProgram(folder, "verify @cornell.gltf picture.hdr --mask mask.hdr --no-cache");
    EXPECT_EQ(refused.exitCode, 4);
    EXPECT_EQ(refused.messages, "raygraph: picture.hdr: its mask has 4x6 pixels, and it has 6x4\n");
    EXPECT_EQ(refused.output, "");
}

TEST(ProgramVerify, CroppedPicture_IsComparedWithTheCrop) {
    const test::TemporaryFolder folder;
    const test::OwnCache cache(folder / "cache");
    const std::string view = "@cornell.gltf --size 32x24 --crop 8,4,16,12 ";
    ASSERT_EQ(RunProgram(folder, "render " + view + "--spp 64 --quiet -o crop.exr").exitCode, 0);
    ASSERT_EQ(RunProgram(folder, "render @cornell.gltf --size 32x24 --spp 64 --quiet -o whole.exr").exitCode,
              0);
    const ProgramResult right = RunProgram(
        folder, "verify " + view.substr(0, 14) + "crop.exr whole.exr --size 32x24 --crop 8,4,16,12");
    EXPECT_EQ(right.exitCode, 0) << right.output << right.messages;
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
