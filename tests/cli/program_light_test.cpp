// Tests of --light, and of the studio in renders of the program. They need a device.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/text.h"
#include "renderer/image/exr.h"
#include "renderer/image/image.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_light_test {
namespace {

using test::ProgramResult;
using test::RunProgram;

// Writes a scene of one white triangle; with `hasEmission`, it has a second one of a hundredth of its size
// that emits.
void WriteTriangle(const test::TemporaryFolder& folder, const char* name, bool hasEmission) {
    nlohmann::json scene = nlohmann::json::parse(R"({"asset": {"version": "2.0"}, "scene": 0,
 "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
 "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                "min": [-1, -1, 0], "max": [1, 1, 0]}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}],
 "buffers": [{"byteLength": 36, "uri":
  "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA"}]})");
    if (hasEmission) {
        scene["materials"] = nlohmann::json::parse(R"([{"emissiveFactor": [1, 1, 1]}])");
        scene["meshes"].push_back(scene["meshes"][0]);
        scene["meshes"][1]["primitives"][0]["material"] = 0;
        scene["nodes"].push_back({{"mesh", 1}, {"scale", {0.1, 0.1, 0.1}}, {"translation", {0, 0, 0.01}}});
        scene["scenes"][0]["nodes"].push_back(1);
    }
    std::ofstream(folder / name) << scene;
}

session::RenderFile Render(const test::TemporaryFolder& folder, const std::string& options,
                           const char* file = "a.exr") {
    const ProgramResult result = RunProgram(folder, "render " + options + " -o " + file);
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_EQ(result.messages, "") << options;
    return session::ReadRenderFile(folder / file);
}

TEST(ProgramLight, AModelWithoutLightIsShownInTheStudioAndSaysSo) {
    const test::TemporaryFolder folder;
    WriteTriangle(folder, "model.gltf", false);
    const std::string line = "render model.gltf --size 8x8 --spp 1 -o a.exr ";
    const ProgramResult lit = RunProgram(folder, line + "--report report.json");
    EXPECT_EQ(lit.exitCode, 0) << lit.messages;
    EXPECT_NE(lit.output.find(", lit by the studio, on "), std::string::npos) << lit.output;
    const session::RenderFile render = session::ReadRenderFile(folder / "a.exr");
    EXPECT_EQ(render.settings.at("light"), "studio");
    for (size_t i = 0; i < render.radiance.size(); i += 4) EXPECT_GT(render.radiance[i], 0.0f);
    const nlohmann::json report = nlohmann::json::parse(std::ifstream(folder / "report.json"));
    EXPECT_EQ(report["settings"]["light"], "studio");
    EXPECT_EQ(image::ReadExr(folder / "a.exr").attributes.count("raygraph.setting.light"), 1u);
    const ProgramResult dark = RunProgram(folder, line + "--light none");
    EXPECT_EQ(dark.output.find("studio"), std::string::npos);
    EXPECT_NE(dark.messages.find("the picture will be black; give --light studio"), std::string::npos)
        << dark.messages;
    EXPECT_EQ(session::ReadRenderFile(folder / "a.exr").settings.at("light"), "none");
    EXPECT_EQ(session::ReadRenderFile(folder / "a.exr").radiance[0], 0.0f);
    // The studio is rotated, tinted and hidden like an environment map
    const session::RenderFile tinted =
        Render(folder, "model.gltf --size 8x8 --spp 1 --env-tint 2,1,0 --env-rotation 0");
    EXPECT_FLOAT_EQ(tinted.radiance[0], 2.0f * render.radiance[0]);
    EXPECT_EQ(tinted.radiance[2], 0.0f);
    const session::RenderFile transparent = Render(folder, "model.gltf --size 8x8 --spp 1 --transparent on");
    EXPECT_EQ(transparent.radiance[0], 0.0f);
    EXPECT_GT(test::SumOf(transparent.radiance), 0.0);
}

TEST(ProgramLight, PartsOfAPictureAndOfItsSamplesAreInOneLight) {
    const test::TemporaryFolder folder;
    WriteTriangle(folder, "model.gltf", true);
    const std::string line = "model.gltf --size 32x32 --quiet ";
    const session::RenderFile whole = Render(folder, line + "--spp 3", "whole.exr");
    // The first part shows nothing but the lamp, the second none of it
    for (const auto& [x, y] : {std::pair(15, 16), std::pair(0, 0)}) {
        const session::RenderFile part =
            Render(folder, line + "--spp 3 --crop " + std::to_string(x) + "," + std::to_string(y) + ",1,1");
        EXPECT_EQ(part.settings.at("light"), "studio");
        EXPECT_EQ(std::memcmp(part.radiance.data(), &whole.radiance[4 * (32 * y + x)], 16), 0);
    }
    Render(folder, line + "--spp 1", "first.exr");
    EXPECT_EQ(Render(folder, "model.gltf --resume first.exr --spp 3 --quiet").radiance, whole.radiance);
    const ProgramResult refused =
        RunProgram(folder, "render model.gltf --resume first.exr --spp 3 --light none");
    EXPECT_EQ(refused.exitCode, 2);
    EXPECT_NE(refused.messages.find("first.exr was rendered with studio"), std::string::npos)
        << refused.messages;
}

TEST(ProgramLight, AllCamerasOfASequenceSeeOneLight) {
    const test::TemporaryFolder folder;
    WriteTriangle(folder, "model.gltf", true);
    // The first camera sees nothing but the lamp, the second not even that
    const std::string cameras = " --camera '0 0 1 0 0 0 0 1 0 1' --camera '0 0 1 0 0 2 0 1 0 40'";
    const ProgramResult result =
        RunProgram(folder, "render model.gltf --size 4x4 --spp 1 --quiet -o a.{camera}.exr" + cameras);
    ASSERT_EQ(result.exitCode, 0) << result.messages;
    for (const char* name : {"a.0.exr", "a.1.exr"})
        EXPECT_EQ(session::ReadRenderFile(folder / name).settings.at("light"), "studio") << name;
}

TEST(ProgramLight, WhatWasDecidedForOneSceneIsNoSettingOfAnother) {
    const test::TemporaryFolder folder;
    WriteTriangle(folder, "model.gltf", false);
    Render(folder, "@cornell.gltf --size 4x4 --spp 1 --quiet", "box.exr");
    EXPECT_EQ(Render(folder, "model.gltf --settings-from box.exr --spp 1 --quiet").settings.at("light"),
              "studio");
    Render(folder, "@cornell.gltf --size 4x4 --spp 1 --quiet --light studio", "both.exr");
    EXPECT_EQ(Render(folder, "@cornell.gltf --settings-from both.exr --spp 1 --quiet").settings.at("light"),
              "studio");
    EXPECT_EQ(Render(folder, "@cornell.gltf --settings-from both.exr --background 1,1,1 --spp 1 --quiet")
                  .settings.at("light"),
              "none");
}

TEST(ProgramLight, GraphTakesItLikeOtherOptionsOfThePicture) {
    const test::TemporaryFolder folder;
    WriteTriangle(folder, "model.gltf", false);
    const ProgramResult result = RunProgram(folder, "graph model.gltf --size 8x8 --light studio");
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_NE(result.output.find("environmentMap"), std::string::npos) << result.output;
}

}  // namespace
}  // namespace raygraph::program_light_test

// Tests light groups as the program renders and stores them. It needs a device.
namespace raygraph::program_light_group_test {
namespace {

using session::RenderFile;
using session::Texels;
using test::RunProgram;
using test::SumOf;

RenderFile Render(const test::TemporaryFolder& folder, const char* output, const std::string& options) {
    const test::ProgramResult result =
        RunProgram(folder, Text("render --size 20x12 -o {} {}", output, options));
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    return session::ReadRenderFile(folder / output);
}

void ExpectGroupsSumToTheBeauty(const RenderFile& render) {
    for (size_t i = 0; i < render.radiance.size(); ++i) {
        if (i % 4 == 3) continue;
        double sum = 0.0;
        for (const Texels& group : render.lightGroups) sum += group.at(i);
        ASSERT_NEAR(sum, render.radiance[i], 1e-5 * std::max(1e-3, sum)) << "texel " << i;
    }
}

TEST(ProgramLightGroup, GroupsSumToTheBeautyAndLeaveItsBits) {
    const test::TemporaryFolder folder;
    const std::string light = "@many_lights.gltf --spp 3 --background 0.02,0.03,0.05";
    const RenderFile render =
        Render(folder, "a.exr", light + " --light-group 'low=light [0-3]' --light-group shards=shards");
    ASSERT_EQ(render.lightGroups.size(), 4u);  // the rest, the points and the environment are groups, too
    for (const Texels& group : render.lightGroups) EXPECT_GT(SumOf(group), 0.0);
    ExpectGroupsSumToTheBeauty(render);
    const RenderFile plain = Render(folder, "b.exr", light);
    EXPECT_EQ(render.radiance, plain.radiance);
    EXPECT_EQ(render.variance, plain.variance);
    EXPECT_TRUE(plain.lightGroups.empty());
}

TEST(ProgramLightGroup, TheOnlyLampHasAllTheLight) {
    const test::TemporaryFolder folder;
    const RenderFile render = Render(folder, "a.exr", "@cornell.gltf --spp 4 --light-group lamp=la*");
    ASSERT_EQ(render.lightGroups.size(), 3u);
    EXPECT_EQ(SumOf(render.lightGroups[0]), 0.0);
    EXPECT_EQ(SumOf(render.lightGroups[1]), 0.0);
    EXPECT_GT(SumOf(render.lightGroups[2]), 0.0);
    for (size_t i = 0; i < render.radiance.size(); ++i) {
        if (i % 4 != 3) {
            EXPECT_EQ(render.lightGroups[2][i], render.radiance[i]) << i;
        }
    }
    EXPECT_NE(image::ReadExr(folder / "a.exr").FloatChannel("light.lamp.R"), nullptr);
}

}  // namespace
}  // namespace raygraph::program_light_group_test

// Tests the program with a scene's own environment.
namespace raygraph::program_environment_test {
namespace {

using test::ProgramResult;
using test::RunProgram;

constexpr const char* kTriangle = R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
 "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
 "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                "min": [-1, -1, 0], "max": [1, 1, 0]}],
 "bufferViews": [{"buffer": 0, "byteLength": 36}],
 "buffers": [{"byteLength": 36, "uri":
  "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA"}]})";

// Each face is a PNG of one opaque white pixel.
TEST(ProgramRender, EnvironmentOfTheSceneIsUsedUnlessAnotherIsGiven) {
    const test::TemporaryFolder folder;
    std::string text = kTriangle;
    nlohmann::json scene = nlohmann::json::parse(text);
    image::WritePng(folder / "white.png", {1, 1, {255, 255, 255, 255}});
    scene["images"] = nlohmann::json::parse(R"([{"uri": "white.png"}])");
    scene["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 0;
    scene["extensions"]["EXT_lights_image_based"]["lights"] =
        nlohmann::json::parse(R"([{"intensity": 0.25, "specularImages": [[0, 0, 0, 0, 0, 0]]}])");
    std::ofstream(folder / "triangle.gltf") << scene;
    const auto corner = [&](const std::string& options, const std::string& messages = "") {
        const ProgramResult result =
            RunProgram(folder, "render triangle.gltf --size 8x8 --spp 1 -o a.exr " + options);
        EXPECT_EQ(result.exitCode, 0) << result.messages;
        EXPECT_EQ(result.messages.find("nothing emits light") != std::string::npos, !messages.empty())
            << result.messages;
        EXPECT_EQ(result.messages.find("--light studio") != std::string::npos, !messages.empty())
            << result.messages;
        return session::ReadRenderFile(folder / "a.exr").radiance[0];
    };
    EXPECT_NEAR(corner(""), 0.25f, 1e-6f);
    EXPECT_NEAR(corner("--env-tint 4,4,4"), 1.0f, 1e-6f);
    EXPECT_EQ(corner("--background 2,2,2"), 2.0f);
    image::WriteHdr(folder / "sky.hdr", {2, 1, std::vector<float>(8, 0.5f)});
    EXPECT_NEAR(corner("--env sky.hdr"), 0.5f, 0.01f);
    // The background is recorded, so that a resumed render has it, too
    EXPECT_EQ(corner("--background 0,0,0", "nothing emits light"), 0.0f);
    const ProgramResult resumed = RunProgram(folder, "render triangle.gltf --resume a.exr --spp 2 --quiet");
    EXPECT_EQ(resumed.exitCode, 0) << resumed.messages;
    EXPECT_EQ(session::ReadRenderFile(folder / "a.exr").radiance[0], 0.0f);
}

TEST(ProgramRender, UnlitSurfacesAreNoDarkness) {
    const test::TemporaryFolder folder;
    nlohmann::json scene = nlohmann::json::parse(kTriangle);
    const auto messages = [&](const nlohmann::json& material) {
        scene["materials"] = nlohmann::json::array({material});
        scene["meshes"][0]["primitives"][0]["material"] = 0;
        std::ofstream(folder / "triangle.gltf") << scene;
        const ProgramResult result =
            RunProgram(folder, "render triangle.gltf --size 8x8 --spp 1 --background 0,0,0 -o a.exr");
        EXPECT_EQ(result.exitCode, 0) << result.messages;
        return result.messages;
    };
    const nlohmann::json unlit = {{"KHR_materials_unlit", nlohmann::json::object()}};
    EXPECT_EQ(messages({{"extensions", unlit}}).find("nothing emits light"), std::string::npos);
    const std::vector<float>& radiance = session::ReadRenderFile(folder / "a.exr").radiance;
    EXPECT_EQ(*std::ranges::max_element(radiance), 1.0f);
    // An unlit material shows its base color, not its emission
    EXPECT_NE(messages({{"extensions", unlit},
                        {"emissiveFactor", {1, 1, 1}},
                        {"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}}}})
                  .find("nothing emits light"),
              std::string::npos);
    EXPECT_NE(messages(nlohmann::json::object()).find("nothing emits light"), std::string::npos);
}

}  // namespace
}  // namespace raygraph::program_environment_test

// Tests the light that biases removed from a render, as the program measures it. It needs a device.
namespace raygraph::program_bias_test {
namespace {

using session::Bias;
using session::RenderFile;
using session::Texels;
using test::RunProgram;
using test::SceneFile;

struct BiasRender {
    RenderFile file;
    nlohmann::json report;
    std::string summary;
};

class ProgramBias : public ::testing::Test {
  protected:
    BiasRender Render(const char* scene, const std::string& options) {
        const test::ProgramResult result = RunProgram(
            m_folder,
            Text("render @{} --size 16x16 --brdf lambert -o a.exr --report a.json {}", scene, options));
        EXPECT_EQ(result.exitCode, 0) << result.messages;
        std::ifstream file(m_folder / "a.json");
        return {session::ReadRenderFile(m_folder / "a.exr"), nlohmann::json::parse(file), result.output};
    }

    const test::TemporaryFolder m_folder;
};

const Texels& Removed(const BiasRender& render, Bias bias) {
    return render.file.removed[static_cast<size_t>(bias)];
}

double MeanOfColor(const Texels& texels) {
    double sum = 0.0;
    for (size_t i = 0; i < texels.size(); ++i)
        if (i % 4 != 3) sum += texels[i];
    return sum / (0.75 * static_cast<double>(texels.size()));
}

bool HasPass(const BiasRender& render, const char* name) {
    return std::ranges::any_of(render.report.at("passes"),
                               [&](const auto& pass) { return pass.at("name") == name; });
}

TEST_F(ProgramBias, MaxDepthInAClosedBoxRemovesWhatBouncedMoreOften) {
    // The radiance is 1 + a + a^2 + ... = 1 / (1 - a); depth 1 leaves 1 + a
    const BiasRender render =
        Render("closed_box_a50.gltf", "--max-depth 1 --spp 250 --aov removed_max_depth");
    const nlohmann::json& removed = render.report.at("removed").at("max_depth");
    EXPECT_EQ(removed.at("samples"), 16);
    const double error = removed.at("standard_error"), luminance = removed.at("luminance");
    EXPECT_GT(error, 0.0);
    EXPECT_LT(error, 0.03);
    EXPECT_NEAR(luminance, 0.5, 4.0 * error);
    EXPECT_NEAR(removed.at("share"), 0.25, 4.0 * removed.at("share_standard_error").get<double>());
    EXPECT_NEAR(MeanOfColor(Removed(render, Bias::MaxDepth)), luminance, 1e-5);
    EXPECT_NEAR(MeanOfColor(render.file.radiance), 1.5, 0.01);
    EXPECT_NE(render.summary.find("--max-depth removed 2"), std::string::npos) << render.summary;
}

TEST_F(ProgramBias, OneSampleAndWhatItLostIsTheUnbiasedSample) {
    const BiasRender unbiased = Render("cornell.gltf", "--spp 1");
    EXPECT_FALSE(HasPass(unbiased, "Subtract"));
    EXPECT_TRUE(unbiased.report.at("removed").empty());
    EXPECT_EQ(unbiased.summary.find("removed"), std::string::npos) << unbiased.summary;
    const auto expectWhole = [&](const char* option, const char* value, Bias bias) {
        const std::string aov = std::string("removed_") + Name(bias);
        const BiasRender render = Render("cornell.gltf", Text("--spp 1 {} {} --aov {}", option, value, aov));
        EXPECT_TRUE(HasPass(render, "Subtract")) << option;
        EXPECT_GT(MeanOfColor(Removed(render, bias)), 0.001) << option;
        for (size_t i = 0; i < unbiased.file.radiance.size(); ++i) {
            if (i % 4 == 3) continue;
            const float whole = render.file.radiance[i] + Removed(render, bias)[i];
            ASSERT_NEAR(whole, unbiased.file.radiance[i], 1e-5f * std::max(1.0f, whole)) << option << i;
        }
    };
    expectWhole("--clamp-indirect", "0.2", Bias::ClampIndirect);
    expectWhole("--max-depth", "2", Bias::MaxDepth);
}

TEST_F(ProgramBias, ClampedPictureAndWhatWasClampedIsTheUnclampedWithinNoise) {
    const BiasRender unclamped = Render("cornell.gltf", "--spp 192"),
                     clamped = Render("cornell.gltf", "--spp 192 --clamp-indirect 0.2");
    const nlohmann::json& removed = clamped.report.at("removed").at("clamp_indirect");
    const auto luminance = [](const BiasRender& render) {
        const nlohmann::json& mean = render.report.at("image").at("mean");
        return 0.2126 * mean.at(0).get<double>() + 0.7152 * mean.at(1).get<double>() +
               0.0722 * mean.at(2).get<double>();
    };
    const double error = removed.at("standard_error");
    EXPECT_GT(removed.at("luminance").get<double>(), 5.0 * error);
    EXPECT_NEAR(luminance(clamped) + removed.at("luminance").get<double>(), luminance(unclamped),
                4.0 * error);
}

TEST_F(ProgramBias, ResumedMeasuresWhatAnUninterruptedRenderDoes) {
    const auto render = [&](int count) {
        return Render("cornell.gltf", Text("--max-depth 2 --clamp-indirect 0.5 --aov all --spp {}", count));
    };
    const BiasRender whole = render(40);
    for (const int first : {20, 33}) {  // the added samples are with and without second traces
        render(first);
        const test::ProgramResult result =
            RunProgram(m_folder, "render @cornell.gltf --resume a.exr --spp 40");
        ASSERT_EQ(result.exitCode, 0) << result.messages;
        const RenderFile resumed = session::ReadRenderFile(m_folder / "a.exr");
        EXPECT_EQ(resumed.removedSamples, 3u);
        EXPECT_EQ(resumed.removed, whole.file.removed) << first;
        EXPECT_EQ(resumed.removedVariance, whole.file.removedVariance) << first;
        EXPECT_EQ(resumed.radiance, whole.file.radiance) << first;
    }
}

// The file stores one bias only, so it cannot be resumed with another one on.
TEST_F(ProgramBias, ResumedCountsForTheBiasThatItsFileHolds) {
    const auto render = [&](int count) {
        return Render("cornell.gltf",
                      Text("--max-depth 2 --clamp-indirect 0.5 --aov removed_max_depth --spp {}", count));
    };
    const BiasRender whole = render(40);
    EXPECT_EQ(whole.report.at("removed").at("clamp_indirect").at("samples"), 3);
    render(20);
    const test::ProgramResult result =
        RunProgram(m_folder, "render @cornell.gltf --resume a.exr --spp 40 --report resumed.json");
    ASSERT_EQ(result.exitCode, 0) << result.messages;
    const RenderFile resumed = session::ReadRenderFile(m_folder / "a.exr");
    EXPECT_EQ(resumed.removedSamples, 3u);
    EXPECT_EQ(resumed.removed, whole.file.removed);
    EXPECT_EQ(resumed.removedVariance, whole.file.removedVariance);
    std::ifstream file(m_folder / "resumed.json");
    const nlohmann::json removed = nlohmann::json::parse(file).at("removed");
    EXPECT_EQ(removed.at("max_depth"), whole.report.at("removed").at("max_depth"));
    EXPECT_FALSE(removed.contains("clamp_indirect")) << "of a part of the samples";
}

// A small sphere and a sky are both near the largest float, so that their sum is infinite.
TEST_F(ProgramBias, InfiniteSamplesAreBlackAndReported) {
    std::ifstream file(SceneFile("furnace_sphere.gltf"));
    nlohmann::json scene = nlohmann::json::parse(file);
    for (nlohmann::json& node : scene.at("nodes"))
        if (node.contains("mesh")) node["scale"] = {0.02, 0.02, 0.02};
    for (nlohmann::json& material : scene.at("materials")) {
        material["pbrMetallicRoughness"] = {{"metallicFactor", 0.0}};
        material["emissiveFactor"] = {1, 1, 1};
        material["extensions"] = {{"KHR_materials_emissive_strength", {{"emissiveStrength", 1e38}}}};
    }
    scene["extensionsUsed"] = {"KHR_materials_emissive_strength"};
    std::ofstream(m_folder / "bright.gltf") << scene;
    const test::ProgramResult result =
        RunProgram(m_folder,
                   "render bright.gltf -o bright.hdr --report bright.json --size 8x8 --spp 3 --brdf lambert "
                   "--nee off --background 3e38,3e38,3e38 --camera '0 0 1  0 0 0  0 1 0  1'");
    ASSERT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_NE(result.messages.find("192 samples were infinite or NaN"), std::string::npos) << result.messages;
    std::ifstream reported(m_folder / "bright.json");
    const nlohmann::json image = nlohmann::json::parse(reported).at("image");
    EXPECT_EQ(image.at("nonfinite_samples"), 8 * 8 * 3);
    EXPECT_EQ(image.at("mean"), nlohmann::json({0.0, 0.0, 0.0}));
    // Each sample is counted once, also where lists of pixels do not fill their rows
    for (const char* form : {"loop", "wavefront"}) {
        const test::ProgramResult adaptive = RunProgram(
            m_folder, std::string("render bright.gltf -o bright.hdr --report bright.json --size 7x5 --spp "
                                  "128 --adaptive on --brdf lambert --nee off --background 3e38,3e38,3e38 "
                                  "--camera '0 0 1  0 0 0  0 1 0  1' --integrator-form ") +
                          form);
        ASSERT_EQ(adaptive.exitCode, 0) << adaptive.messages;
        std::ifstream again(m_folder / "bright.json");
        EXPECT_EQ(nlohmann::json::parse(again).at("image").at("nonfinite_samples"), 7 * 5 * 128) << form;
    }
}

}  // namespace
}  // namespace raygraph::program_bias_test

// Tests the parts of the light as the program renders and stores them. It needs a device.
namespace raygraph::program_aov_test {
namespace {

using session::Aov;
using session::RenderFile;
using session::Texels;
using test::RunProgram;
using test::SumOf;

RenderFile Render(const test::TemporaryFolder& folder, const char* output, const std::string& options) {
    const test::ProgramResult result =
        RunProgram(folder, Text("render @cornell.gltf --size 24x24 -o {} {}", output, options));
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    return session::ReadRenderFile(folder / output);
}

// Expects that R, G and B of every pixel are the sums of the parts, relative to the brighter one.
void ExpectSum(const RenderFile& render, const std::vector<Aov>& parts) {
    for (size_t i = 0; i < render.radiance.size(); ++i) {
        if (i % 4 == 3) continue;
        double sum = 0.0;
        for (const Aov part : parts) sum += MeanOf(render, part)->at(i);
        ASSERT_NEAR(sum, render.radiance[i], 1e-5 * std::max(1e-3, sum)) << "texel " << i;
    }
}

TEST(ProgramAov, PartsOfTheLightSumToTheBeautyTwiceAndLeaveIt) {
    const test::TemporaryFolder folder;
    const RenderFile split =
        Render(folder, "split.exr", "--spp 4 --aov emission,direct,indirect,diffuse,specular,transmission");
    ExpectSum(split, {Aov::Emission, Aov::Direct, Aov::Indirect});
    ExpectSum(split, {Aov::Emission, Aov::Diffuse, Aov::Specular, Aov::Transmission});
    for (const Aov part : {Aov::Emission, Aov::Direct, Aov::Indirect, Aov::Diffuse})
        EXPECT_GT(SumOf(*MeanOf(split, part)), 0.0) << Name(part);
    EXPECT_EQ(SumOf(*MeanOf(split, Aov::Transmission)), 0.0);  // no glass in the box

    const RenderFile plain = Render(folder, "plain.exr", "--spp 4");
    if (plain.driver.find("llvmpipe") != std::string::npos) {
        EXPECT_EQ(split.radiance, plain.radiance);
        EXPECT_EQ(split.variance, plain.variance);
    } else {  // another driver may round differently in the longer shader
        size_t same = 0;
        for (size_t i = 0; i < plain.radiance.size(); ++i)
            same += std::abs(split.radiance[i] - plain.radiance[i]) <= 1e-5f * plain.radiance[i] + 1e-7f;
        EXPECT_GE(same, plain.radiance.size() * 99 / 100) << "of " << plain.radiance.size();
    }
    EXPECT_TRUE(AovsOf(plain).IsEmpty());
}

}  // namespace
}  // namespace raygraph::program_aov_test
