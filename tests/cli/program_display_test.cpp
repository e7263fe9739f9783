// Tests --white-point, --transparent, --exr-type and --settings-from by whole renders. It needs a device.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/files.h"
#include "base/text.h"
#include "passes/tonemap.h"
#include "renderer/image/exr.h"
#include "renderer/image/image.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_display_test {
namespace {

using nlohmann::json;
using test::ProgramResult;
using test::RunProgram;

void Render(const test::TemporaryFolder& folder, const std::string& options) {
    const ProgramResult result = RunProgram(folder, "render " + options);
    EXPECT_EQ(result.exitCode, 0) << result.messages;
}

image::Image8 Picture(const test::TemporaryFolder& folder, const char* name) {
    return image::DecodeImage8(ReadFile(folder / name), name);
}

// Returns the largest difference between red, green and blue of a pixel.
int Tint(const image::Image8& picture) {
    int tint = 0;
    for (size_t i = 0; i < picture.rgba.size(); i += 4) {
        const auto [least, most] = std::minmax({picture.rgba[i], picture.rgba[i + 1], picture.rgba[i + 2]});
        tint = std::max(tint, most - least);
    }
    return tint;
}

// Returns a color of luminance 1 with the chromaticity of a black body, which WhiteBalance turns white.
glm::dvec3 LightOf(double kelvin) {
    const glm::dmat3 balance(passes::WhiteBalance(passes::WhitePointAt(kelvin)));
    return glm::inverse(balance) * glm::dvec3(1.0);
}

TEST(ProgramDisplay, GrayUnderAWarmLightIsShownNeutral) {
    const test::TemporaryFolder folder;
    const glm::dvec3 light = LightOf(2856.0);
    EXPECT_GT(light.x, 2.0 * light.z);
    const std::string gray =
        Text("@furnace_sphere.gltf --size 16x16 --spp 4 --brdf lambert --exposure -2 --background {},{},{} ",
             light.x, light.y, light.z);
    Render(folder, gray + "-o plain.png");
    Render(folder, gray + "-o same.png --white-point 6500");
    Render(folder, gray + "-o a.png --white-point 2856");
    Render(folder, gray + "-o auto.png --white-point auto --report auto.json");
    EXPECT_EQ(json::parse(std::ifstream(folder / "auto.json"))["settings"]["white-point"], "auto");
    Render(folder, gray + "-o other.png --white-point 5000");
    EXPECT_GT(Tint(Picture(folder, "plain.png")), 40);
    EXPECT_EQ(Picture(folder, "same.png").rgba, Picture(folder, "plain.png").rgba);
    EXPECT_LE(Tint(Picture(folder, "a.png")), 1);
    EXPECT_LE(Tint(Picture(folder, "auto.png")), 1);
    EXPECT_GT(Tint(Picture(folder, "other.png")), 20);
    const image::Image8 balanced = Picture(folder, "a.png");
    EXPECT_GT(*std::min_element(balanced.rgba.begin(), balanced.rgba.end()), 60) << "not black";
}

TEST(ProgramDisplay, AWhitePointThatHasNoMeaningIsRefused) {
    const test::TemporaryFolder folder;
    const auto refusal = [&](int code, const std::string& options) {
        const ProgramResult result = RunProgram(folder, "render @cornell.gltf --size 8x8 --spp 1 " + options);
        EXPECT_EQ(result.exitCode, code) << options << result.messages;
        return result.messages;
    };
    for (const char* text : {"999", "25001", "warm", "-5", ""})
        EXPECT_NE(refusal(2, Text("--white-point '{}'", text)).find("--white-point"), std::string::npos);
    EXPECT_NE(refusal(2, "--white-point 3200 -o a.exr").find("--white-point is of a .png"),
              std::string::npos);
    EXPECT_NE(refusal(2, "--white-point auto --view albedo").find("no light"), std::string::npos);
    const ProgramResult dark = RunProgram(folder,
                                          "render @furnace_sphere.gltf --size 8x8 --spp 1 --white-point auto "
                                          "--background 0,0,0");
    EXPECT_EQ(dark.exitCode, 4) << dark.messages;
    EXPECT_NE(dark.messages.find("has no light to take the color of"), std::string::npos) << dark.messages;
}

// Writes an unlit square of one color in the middle of the picture, which covers half of the pixels at its
// edge.
void WriteSquare(const test::TemporaryFolder& folder) {
    json scene = json::parse(std::ifstream(test::SceneFile("furnace_sphere.gltf")));
    for (json& material : scene["materials"]) {
        material["pbrMetallicRoughness"] = {{"baseColorFactor", json::array({0.8, 0.4, 0.1, 1.0})}};
        material["extensions"] = {{"KHR_materials_unlit", json::object()}};
    }
    scene["extensionsUsed"] = json::array({"KHR_materials_unlit"});
    std::ofstream(folder / "square.gltf") << scene;
}

TEST(ProgramDisplay, TransparentPicturesHoldWhatAlphaCovers) {
    const test::TemporaryFolder folder;
    WriteSquare(folder);
    const std::string ball = "square.gltf --size 24x24 --spp 16 --tonemap srgb ";
    Render(folder, ball + "--background 0.5,0.7,1 --aov emission --transparent on -o ball.png -o ball.exr");
    Render(folder, ball + "--background 0.5,0.7,1 -o opaque.png -o opaque.exr");
    const image::Image8 picture = Picture(folder, "ball.png"), opaque = Picture(folder, "opaque.png");
    const session::RenderFile render = session::ReadRenderFile(folder / "ball.exr");
    const session::RenderFile whole = session::ReadRenderFile(folder / "opaque.exr");
    EXPECT_EQ(render.settings.at("transparent"), "on");
    const uint8_t* inside = &picture.rgba[4 * (12 * 24 + 12)];
    ASSERT_EQ(inside[3], 255);
    size_t empty = 0, soft = 0;
    for (size_t i = 0; i < picture.rgba.size(); i += 4) {
        const float alpha = render.radiance[i + 3];
        EXPECT_EQ(opaque.rgba[i + 3], 255);
        EXPECT_EQ(alpha, whole.radiance[i + 3]) << "coverage is the same";
        EXPECT_NEAR(picture.rgba[i + 3], 255.0f * alpha, 0.51f) << "linear";
        if (alpha == 0.0f) {
            ++empty;
            for (size_t c = 0; c < 4; ++c) EXPECT_EQ(picture.rgba[i + c], 0);
            for (size_t c = 0; c < 3; ++c) EXPECT_EQ(render.radiance[i + c], 0.0f);
            EXPECT_GT(whole.radiance[i + 2], 0.9f);
            continue;
        }
        soft += alpha < 1.0f;
        for (size_t c = 0; c < 3; ++c) {
            EXPECT_NEAR(picture.rgba[i + c], inside[c], 1) << "the ball's color, however little of it";
            // Composited over the background, the picture equals the whole
            const float sky[] = {0.5f, 0.7f, 1.0f};
            EXPECT_NEAR(render.radiance[i + c] + (1.0f - alpha) * sky[c], whole.radiance[i + c], 1e-5f);
        }
    }
    EXPECT_GT(empty, 50u);
    EXPECT_GT(soft, 10u);
    const ProgramResult refused =
        RunProgram(folder, "render square.gltf --transparent on --view raster -o a.png");
    EXPECT_EQ(refused.exitCode, 2);
    EXPECT_NE(refused.messages.find("--transparent"), std::string::npos) << refused.messages;
}

TEST(ProgramDisplay, TheHiddenEnvironmentStillLightsTheScene) {
    const test::TemporaryFolder folder;
    const std::string ball = "@furnace_sphere.gltf --size 16x16 --spp 4 --background 1,1,1 ";
    Render(folder, ball + "--transparent on -o hidden.exr");
    Render(folder, ball + "-o seen.exr");
    const session::RenderFile hidden = session::ReadRenderFile(folder / "hidden.exr");
    const session::RenderFile seen = session::ReadRenderFile(folder / "seen.exr");
    size_t covered = 0;
    for (size_t i = 0; i < seen.radiance.size(); i += 4) {
        if (seen.radiance[i + 3] != 1.0f) continue;
        ++covered;
        for (size_t c = 0; c < 3; ++c) EXPECT_EQ(hidden.radiance[i + c], seen.radiance[i + c]);
        EXPECT_GT(seen.radiance[i], 0.0f);
    }
    EXPECT_GT(covered, 20u);
}

TEST(ProgramDisplay, HalfFilesAreTheRoundedMeansWithoutSums) {
    const test::TemporaryFolder folder;
    const std::string box = "@cornell.gltf --size 24x16 --spp 4 --aov albedo,depth,instance --quiet ";
    Render(folder, box + "-o float.exr --exr-type float");
    Render(folder, box + "-o half.exr --exr-type half");
    const image::ExrImage whole = image::ReadExr(folder / "float.exr"),
                          half = image::ReadExr(folder / "half.exr");
    for (const image::ExrChannel& channel : half.channels) {
        EXPECT_EQ(channel.name.find("sum"), std::string::npos) << channel.name;
        EXPECT_EQ(channel.name.find("squares"), std::string::npos) << channel.name;
        const std::vector<float>*rounded = half.FloatChannel(channel.name),
              *exact = whole.FloatChannel(channel.name);
        if (rounded == nullptr) {
            ASSERT_NE(whole.UintChannel(channel.name), nullptr) << channel.name;
            EXPECT_EQ(*half.UintChannel(channel.name), *whole.UintChannel(channel.name)) << channel.name;
            continue;
        }
        ASSERT_NE(exact, nullptr) << channel.name;
        for (size_t i = 0; i < exact->size(); ++i)
            if (channel.name == "Z")
                EXPECT_EQ((*rounded)[i], (*exact)[i]);
            else
                EXPECT_NEAR((*rounded)[i], (*exact)[i], 0x1p-11f * std::abs((*exact)[i]) + 0x1p-25f);
    }
    ASSERT_NE(half.FloatChannel("albedo.R"), nullptr);
    EXPECT_LT(2 * std::filesystem::file_size(folder / "half.exr"),
              std::filesystem::file_size(folder / "float.exr"));

    const ProgramResult resumed = RunProgram(folder, "render @cornell.gltf --resume half.exr --spp 8");
    EXPECT_EQ(resumed.exitCode, 4);
    EXPECT_NE(resumed.messages.find("no channel sum0.R, as in any file of half floats"), std::string::npos)
        << resumed.messages;
    Render(folder, box + "-o half2.exr --exr-type half --sample-offset 4");
    const ProgramResult merged = RunProgram(folder, "merge half.exr half2.exr -o x.exr");
    EXPECT_EQ(merged.exitCode, 4);
    EXPECT_NE(merged.messages.find("as in any file of half floats"), std::string::npos) << merged.messages;
    const ProgramResult lost =
        RunProgram(folder, "render @cornell.gltf --resume float.exr --spp 8 --exr-type half");
    EXPECT_EQ(lost.exitCode, 2);
    EXPECT_NE(lost.messages.find("would lose its sums"), std::string::npos) << lost.messages;
    EXPECT_EQ(RunProgram(folder, "render @cornell.gltf --exr-type half -o a.png").exitCode, 2);
}

TEST(ProgramDisplay, WhatHalfCannotHoldIsClampedAndCounted) {
    const test::TemporaryFolder folder;
    const ProgramResult result = RunProgram(
        folder,
        "render @furnace_sphere.gltf --size 8x8 --spp 1 --background 1e5,1,1 -o a.exr --exr-type half");
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_NE(result.messages.find("beyond 65504"), std::string::npos) << result.messages;
    const image::ExrImage half = image::ReadExr(folder / "a.exr");
    EXPECT_EQ(half.FloatChannel("R")->front(), 65504.0f);
    EXPECT_EQ(half.FloatChannel("G")->front(), 1.0f);
}

TEST(ProgramDisplay, SettingsOfARenderAreDefaultsOfAnother) {
    const test::TemporaryFolder folder;
    Render(folder,
           "@cornell.gltf --size 20x14 --seed 5 --max-depth 3 --crop 3,2,9,7 --spp 6 --sample-offset 4 "
           "--aov albedo --exr-type half --quiet -o model.exr");
    Render(folder, "@cornell.gltf --settings-from model.exr --spp 2 --seed 6 -o taken.exr --quiet");
    Render(folder,
           "@cornell.gltf --size 20x14 --seed 6 --max-depth 3 --crop 3,2,9,7 --spp 2 -o said.exr --quiet");
    const session::RenderFile taken = session::ReadRenderFile(folder / "taken.exr");
    const session::RenderFile said = session::ReadRenderFile(folder / "said.exr");
    EXPECT_EQ(taken.settings, said.settings);
    EXPECT_EQ(taken.radiance, said.radiance);
    EXPECT_EQ(taken.samples, (session::SampleRanges{{0, 2}})) << "from the first sample on";
    EXPECT_TRUE(taken.albedo.empty()) << "channels are no settings";
    Render(folder, "@small_light.gltf --settings-from model.exr --spp 1 -o other.exr --quiet");
    EXPECT_EQ(session::ReadRenderFile(folder / "other.exr").settings.at("seed"), "5");

    const auto refusal = [&](int code, const std::string& options) {
        const ProgramResult result = RunProgram(folder, "render @cornell.gltf --settings-from " + options);
        EXPECT_EQ(result.exitCode, code) << options;
        return result.messages;
    };
    EXPECT_NE(refusal(2, "model.exr --resume model.exr").find("--resume"), std::string::npos);
    EXPECT_NE(refusal(2, "model.exr --size 8x8").find("--crop"), std::string::npos);
    EXPECT_NE(refusal(4, "none.exr").find("none.exr"), std::string::npos);
    EXPECT_NE(refusal(2, "model.exr -o model.exr").find("model.exr"), std::string::npos);
}

TEST(ProgramDisplay, TheMapOfTheOtherRenderIsAskedFor) {
    const test::TemporaryFolder folder;
    image::WriteHdr(folder / "sky.hdr", {2, 1, {1.0f, 1.0f, 1.0f, 1.0f, 0.5f, 0.5f, 0.5f, 1.0f}});
    const std::string ball = "@furnace_sphere.gltf --size 8x8 --spp 1 ";
    Render(folder, ball + "--env sky.hdr --env-rotation 90 -o model.exr");
    const ProgramResult unlit =
        RunProgram(folder, "render @furnace_sphere.gltf --settings-from model.exr --spp 1 -o a.exr");
    EXPECT_EQ(unlit.exitCode, 0) << unlit.messages;
    EXPECT_NE(unlit.messages.find("sky.hdr, which is no setting"), std::string::npos) << unlit.messages;
    const ProgramResult lit = RunProgram(
        folder, "render @furnace_sphere.gltf --settings-from model.exr --env sky.hdr --spp 1 -o b.exr");
    EXPECT_EQ(lit.messages, "");
    EXPECT_EQ(session::ReadRenderFile(folder / "b.exr").radiance,
              session::ReadRenderFile(folder / "model.exr").radiance);
    const ProgramResult plain = RunProgram(
        folder, "render @furnace_sphere.gltf --settings-from model.exr --background 1,1,1 --spp 1 -o c.exr");
    EXPECT_EQ(plain.messages, "");
    EXPECT_EQ(session::ReadRenderFile(folder / "c.exr").settings.at("env-rotation"), "0");

    // A map replaces the background of the other render
    Render(folder, ball + "--background 0.2,0.4,0.8 -o flat.exr");
    const ProgramResult mapped = RunProgram(
        folder, "render @furnace_sphere.gltf --settings-from flat.exr --env sky.hdr --spp 1 -o d.exr");
    EXPECT_EQ(mapped.messages, "");
    Render(folder, ball + "--env sky.hdr -o e.exr");
    const session::RenderFile d = session::ReadRenderFile(folder / "d.exr");
    EXPECT_EQ(d.settings, session::ReadRenderFile(folder / "e.exr").settings);
    EXPECT_EQ(d.radiance, session::ReadRenderFile(folder / "e.exr").radiance);
}

}  // namespace
}  // namespace raygraph::program_display_test
