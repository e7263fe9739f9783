// Tests `raygraph denoise` by the built program. It needs a device.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "editor/session/file/render_file.h"
#include "renderer/image/exr.h"
#include "tests/cli/program_runner.h"
#include "tests/support/source_file.h"

namespace raygraph::program_denoise_test {
namespace {

using test::ProgramResult;
using test::RunProgram;

std::string Bytes(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(ProgramDenoise, FileHasThePictureOfTheRenderThatDenoises) {
    const test::TemporaryFolder folder;
    test::WriteBox(folder);
    const std::string still = "render @cornell.gltf --size 24x18 --spp 16 --quiet ",
                      moving = "render box.gltf --size 24x18 --spp 16 --at 0 --shutter 0:0.5 --quiet ";
    for (const std::string& render : {still, moving}) {
        const bool isStill = render == still;
        ASSERT_EQ(RunProgram(folder, render + "--denoise --exposure 1 -o whole.exr -o whole.png").exitCode,
                  0);
        ASSERT_EQ(RunProgram(folder, render + "--aov denoising -o a.exr").exitCode, 0);
        // The file is replaced by itself with the picture that it did not have
        const ProgramResult result =
            RunProgram(folder, "denoise a.exr --exposure 1 -o a.exr -o a.png --validate");
        ASSERT_EQ(result.exitCode, 0) << result.messages;
        EXPECT_EQ(result.output, "a.exr\na.png\n");
        const image::ExrImage whole = image::ReadExr(folder / "whole.exr"),
                              denoised = image::ReadExr(folder / "a.exr");
        for (const char* channel : {"R", "variance.G", "denoised.R", "denoised.G", "denoised.B"}) {
            ASSERT_NE(denoised.FloatChannel(channel), nullptr) << channel;
            EXPECT_EQ(*denoised.FloatChannel(channel), *whole.FloatChannel(channel)) << channel;
        }
        EXPECT_EQ(Bytes(folder / "a.png"), Bytes(folder / "whole.png"));
        EXPECT_EQ(denoised.FloatChannel("denoising.seen.R") != nullptr, isStill);
        EXPECT_TRUE(session::HasSums(session::ReadRenderFile(folder / "a.exr")));
    }
}

TEST(ProgramDenoise, RefusalsAreOneLineAndTheOldFileStays) {
    const test::TemporaryFolder folder;
    std::ofstream(folder / "old.png") << "old";
    const auto expect = [&](const char* options, const char* why) {
        ASSERT_EQ(RunProgram(folder, std::string("render @cornell.gltf --size 8x8 --spp 2 --quiet ") +
                                         options + " -o a.exr")
                      .exitCode,
                  0);
        const ProgramResult result = RunProgram(folder, "denoise a.exr -o old.png");
        EXPECT_EQ(result.exitCode, 4);
        EXPECT_EQ(result.messages, std::string("raygraph: a.exr cannot be denoised: ") + why + "\n");
        EXPECT_EQ(Bytes(folder / "old.png"), "old");
    };
    expect("",
           "it has neither the channels of --aov denoising nor those of --aov albedo,normal. Render it again "
           "with --aov denoising");
    expect("--view normals", "it shows the view normals");
    expect("--adaptive on --aov albedo,normal",
           "it is adaptive, and its pixels have different numbers of samples");
    ASSERT_EQ(
        RunProgram(folder, "render @cornell.gltf --size 8x8 --spp 2 --quiet --aov albedo,normal -o a.exr")
            .exitCode,
        0);
    const ProgramResult plain = RunProgram(folder, "denoise a.exr -o old.png");
    EXPECT_EQ(plain.exitCode, 0) << plain.messages;
    EXPECT_NE(plain.messages.find("warning: a.exr was rendered without --aov denoising"), std::string::npos)
        << plain.messages;
    EXPECT_NE(Bytes(folder / "old.png"), "old");
}

TEST(ProgramDenoise, WhatIsNotDenoisedIsRefusedBeforeTheSceneIsRead) {
    const test::TemporaryFolder folder;
    const std::string render = "render none.gltf --denoise -o a.png ", refusal = "raygraph: --denoise: ";
    for (const auto& [options, why] :
         {std::pair("--adaptive on", "an adaptive picture has different numbers of samples in its pixels\n"),
          std::pair("--view albedo", "the view albedo is not denoised\n")}) {
        const ProgramResult result = RunProgram(folder, render + options);
        EXPECT_EQ(result.exitCode, 2);
        EXPECT_EQ(result.messages, refusal + why);
    }
    std::ofstream(folder / "a.txt") << "text";
    const ProgramResult result = RunProgram(folder, "denoise a.txt -o a.png");
    EXPECT_EQ(result.exitCode, 4);
    EXPECT_EQ(result.messages,
              "raygraph: a.txt: is not an OpenEXR file; denoise reads an .exr of `raygraph render --aov "
              "denoising`\n");
}

// Runs the program with these folders before all others in which libraries are searched.
ProgramResult RunWithLibraries(const test::TemporaryFolder& folder, std::string folders,
                               const std::string& line) {
    if (const char* others = std::getenv("LD_LIBRARY_PATH")) (folders += ':') += others;
    const test::EnvironmentVariable path("LD_LIBRARY_PATH", folders);
    return RunProgram(folder, line);
}

std::string OidnFolder(const char* version) {
    return test::EnvironmentOr("RAYGRAPH_OIDN", RAYGRAPH_BUILT_OIDN) + std::string(version);
}

void RenderForOidn(const test::TemporaryFolder& folder, const char* aovs) {
    const std::string line = "render @cornell.gltf --size 9x7 --spp 2 --quiet -o a.exr --aov ";
    ASSERT_EQ(RunProgram(folder, line + aovs).exitCode, 0);
}

// Writes a library that cannot be loaded, and so hides those behind it.
void WriteBrokenLibrary(const test::TemporaryFolder& folder, const std::string& ending) {
    std::ofstream(folder / ("libOpenImageDenoise.so" + ending)) << "This is no library.";
}

TEST(ProgramDenoise, OpenImageDenoiseGetsRadianceAndGuidesInBothVersions) {
    const test::TemporaryFolder folder, broken;
    WriteBrokenLibrary(broken, ".2");
    for (const bool isClean : {true, false}) {
        RenderForOidn(folder, isClean ? "denoising" : "albedo,normal");
        const session::RenderFile render = session::ReadRenderFile(folder / "a.exr");
        const session::Texels& albedo = isClean ? render.denoising.albedo : render.albedo;
        const session::Texels& normal = isClean ? render.denoising.normal : render.normal;
        for (const char* version : {"2", "1"}) {
            // Version 1 is found under its name although version 2 cannot be loaded
            const std::string folders =
                (version[0] == '1' ? broken.Path().string() + ':' : "") + OidnFolder(version);
            const ProgramResult result = RunWithLibraries(
                folder, folders, "denoise a.exr --denoiser oidn --quiet -o b.exr -o b.png --exposure 1");
            ASSERT_EQ(result.exitCode, 0) << result.messages;
            EXPECT_FALSE(Bytes(folder / "b.png").empty());
            const image::ExrImage file = image::ReadExr(folder / "b.exr");
            for (size_t c = 0; c < 3; ++c) {
                const std::vector<float>* denoised = file.FloatChannel(std::string("denoised.") + "RGB"[c]);
                ASSERT_TRUE(denoised && denoised->size() == 63);
                for (size_t i = 0; i < 63; ++i)
                    ASSERT_EQ((*denoised)[i], render.radiance[4 * i + c] + 2.0f * albedo[4 * i + c] +
                                                  4.0f * normal[4 * i + c] + (isClean ? 8.0f : 0.0f));
            }
        }
    }
}

TEST(ProgramDenoise, FailuresOfOpenImageDenoiseAreOneLineAndTheOldFileStays) {
    const test::TemporaryFolder folder, broken, other;
    for (const char* ending : {".2", ".1", ""}) WriteBrokenLibrary(broken, ending);
    RenderForOidn(folder, "denoising");
    std::ofstream(folder / "old.png") << "old";
    const auto expect = [&](const std::string& libraries, const std::string& what) {
        const ProgramResult result =
            RunWithLibraries(folder, libraries, "denoise a.exr --denoiser oidn -o old.png");
        EXPECT_EQ(result.exitCode, 4);
        EXPECT_TRUE(result.messages.starts_with("raygraph: Open Image Denoise: ")) << result.messages;
        EXPECT_EQ(std::ranges::count(result.messages, '\n'), 1) << result.messages;
        EXPECT_NE(result.messages.find(what), std::string::npos) << result.messages;
        EXPECT_EQ(Bytes(folder / "old.png"), "old");
    };
    expect(broken.Path(), "; install it");
    for (const char* step : {"device", "filter", "execute"}) {
        const test::EnvironmentVariable fail("RAYGRAPH_FAIL", step);
        expect(OidnFolder("2"), std::string("the library says: no ") + step);
    }
    const std::string vulkan = test::EnvironmentOr("RAYGRAPH_FAILING_VULKAN", RAYGRAPH_BUILT_FAILING_VULKAN);
    std::filesystem::create_symlink(vulkan + "/libvulkan.so.1", other / "libOpenImageDenoise.so.2");
    expect(other.Path(), "no function oidnNewDevice");
}

}  // namespace
}  // namespace raygraph::program_denoise_test
