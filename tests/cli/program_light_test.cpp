// Tests of --light, and of the studio in renders of the program. They need a device.
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

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
    for (const bool hasEmission : {false, true}) {
        WriteTriangle(folder, "model.gltf", hasEmission);
        const session::RenderFile render =
            Render(folder, "model.gltf --size 8x8 --spp 1 --report report.json");
        EXPECT_EQ(render.settings.at("light"), "studio");
        for (size_t i = 0; i < render.radiance.size(); i += 4) EXPECT_GT(render.radiance[i], 0.0f);
        const nlohmann::json report = nlohmann::json::parse(std::ifstream(folder / "report.json"));
        EXPECT_EQ(report["settings"]["light"], "studio");
        EXPECT_EQ(image::ReadExr(folder / "a.exr").attributes.count("raygraph.setting.light"), 1u);
        const session::RenderFile dark = Render(folder, "model.gltf --size 8x8 --spp 1 --light none --quiet");
        EXPECT_EQ(dark.settings.at("light"), "none");
        EXPECT_EQ(dark.radiance[0], 0.0f);
        // The studio is rotated, tinted and hidden like an environment map
        const session::RenderFile tinted =
            Render(folder, "model.gltf --size 8x8 --spp 1 --env-tint 2,1,0 --env-rotation 0");
        EXPECT_FLOAT_EQ(tinted.radiance[0], 2.0f * render.radiance[0]);
        EXPECT_EQ(tinted.radiance[2], 0.0f);
        const session::RenderFile transparent =
            Render(folder, "model.gltf --size 8x8 --spp 1 --transparent on");
        EXPECT_EQ(transparent.radiance[0], 0.0f);
        EXPECT_GT(test::SumOf(transparent.radiance), 0.0);
    }
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
    Render(folder, line + "--spp 2 --sample-offset 1", "rest.exr");
    ASSERT_EQ(RunProgram(folder, "merge first.exr rest.exr -o merged.exr --quiet").exitCode, 0);
    EXPECT_EQ(session::ReadRenderFile(folder / "merged.exr").radiance, whole.radiance);
    EXPECT_EQ(Render(folder, "model.gltf --resume first.exr --spp 3 --quiet").radiance, whole.radiance);
    // Files that were rendered in another light are refused
    const ProgramResult refused =
        RunProgram(folder, "render model.gltf --resume first.exr --spp 3 --light none");
    EXPECT_EQ(refused.exitCode, 2);
    EXPECT_NE(refused.messages.find("first.exr was rendered with studio"), std::string::npos)
        << refused.messages;
    Render(folder, line + "--spp 2 --sample-offset 1 --light none", "dark.exr");
    const ProgramResult unlike = RunProgram(folder, "merge first.exr dark.exr -o merged.exr");
    EXPECT_EQ(unlike.exitCode, 4);
    EXPECT_NE(unlike.messages.find("light: studio against none"), std::string::npos) << unlike.messages;
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

TEST(ProgramLight, TheSummarySaysThatTheStudioLightsThePicture) {
    const test::TemporaryFolder folder;
    WriteTriangle(folder, "model.gltf", false);
    const auto summary = [&](const std::string& options) {
        const ProgramResult result =
            RunProgram(folder, "render model.gltf --size 8x8 --spp 1 -o a.exr " + options);
        EXPECT_EQ(result.exitCode, 0) << result.messages;
        return result.output;
    };
    EXPECT_NE(summary("").find(", lit by the studio, on "), std::string::npos) << summary("");
    EXPECT_EQ(summary("--background 1,1,1").find("studio"), std::string::npos);
    const ProgramResult dark =
        RunProgram(folder, "render model.gltf --size 8x8 --spp 1 -o a.exr --light none");
    EXPECT_EQ(dark.output.find("studio"), std::string::npos);
    EXPECT_NE(dark.messages.find("the picture will be black; give --light studio"), std::string::npos)
        << dark.messages;
}

TEST(ProgramLight, GraphTakesItLikeOtherOptionsOfThePicture) {
    const test::TemporaryFolder folder;
    WriteTriangle(folder, "model.gltf", false);
    for (const char* light : {"auto", "studio", "none"}) {
        const ProgramResult result =
            RunProgram(folder, "graph model.gltf --size 8x8 --light " + std::string(light));
        EXPECT_EQ(result.exitCode, 0) << result.messages;
        EXPECT_NE(result.output.find("environmentMap"), std::string::npos) << result.output;
    }
    EXPECT_EQ(RunProgram(folder, "graph model.gltf --light lamp").exitCode, 2);
}

TEST(ProgramLight, OptionsThatContradictItAreRefused) {
    const test::TemporaryFolder folder;
    WriteTriangle(folder, "model.gltf", false);
    image::WriteHdr(folder / "sky.hdr", {2, 1, std::vector<float>(8, 0.5f)});
    const auto refuses = [&](const std::string& options, const std::string& why) {
        const ProgramResult result = RunProgram(folder, options);
        EXPECT_EQ(result.exitCode, 2) << options;
        EXPECT_NE(result.messages.find(why), std::string::npos) << result.messages;
    };
    refuses("render model.gltf --light studio --background 0,0,0",
            "--background and --light studio exclude each other");
    refuses("render model.gltf --light studio --env sky.hdr", "--env and --light studio exclude each other");
    refuses("edit model.gltf --light studio --env sky.hdr", "--env and --light studio exclude each other");
    refuses("render model.gltf --background 0,0,0 --env-tint 1,1,1",
            "--env-tint is of a map or the studio, which --background replaces");
    refuses("render model.gltf --light lamp", "lamp");
    refuses("render model.gltf --view normals --light none", "there is no light for --light");
}

TEST(ProgramLight, BenchTimesScenesInTheirOwnLightAlone) {
    const test::TemporaryFolder folder;
    WriteTriangle(folder, "model.gltf", false);
    const ProgramResult result =
        RunProgram(folder, "bench model.gltf --size 8x8 --frames 1 --rounds 1 --quiet");
    ASSERT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_EQ(nlohmann::json::parse(result.output)["settings"]["light"], "none");
}

}  // namespace
}  // namespace raygraph::program_light_test
