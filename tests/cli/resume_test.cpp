#include "editor/cli/resume_settings.h"

#include "tests/cli/cli_test.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::cli::resume_test {
namespace {

using test::ExpectError;
using test::MakeRender;

ResumedRender Resumed(uint32_t first, uint32_t count) {
    return {"old.exr", MakeRender(first, count)};
}

RenderArguments Asking(uint32_t samples, const SettingTexts& given = {}) {
    RenderArguments arguments;
    arguments.samples = samples;
    arguments.given = given;
    return arguments;
}

TEST(Resume, TakesTheSettingsOfTheFile) {
    const PictureSettings settings = SettingsOf(Resumed(0, 8), Asking(16));
    EXPECT_EQ(settings.size, (Extent2D{5, 3}));
    EXPECT_EQ(settings.paths.seed, 9u);
    EXPECT_EQ(SettingsOf(Resumed(0, 8), Asking(16, {{"seed", "9"}, {"size", "5x3"}})).paths.seed, 9u);
}

TEST(Resume, AnOptionThatSaysOtherwiseIsNamed) {
    ExpectError(
        ErrorKind::Usage,
        [] {
            SettingsOf(Resumed(0, 8), Asking(16, {{"seed", "1"}}));
        },
        "--seed 1", "old.exr was rendered with 9");
    ExpectError(
        ErrorKind::Usage,
        [] {
            SettingsOf(Resumed(0, 8), Asking(16, {{"camera", "Cam"}}));
        },
        "--camera Cam", "the default");
    RenderArguments offset = Asking(16);
    offset.sampleOffset = 4;
    ExpectError(
        ErrorKind::Usage, [&] { SettingsOf(Resumed(2, 8), offset); }, "--sample-offset 4", "with 2");
    RenderArguments aovs = Asking(16);
    aovs.aovs = ParseAovs("albedo,normal");
    ExpectError(
        ErrorKind::Usage, [&] { SettingsOf(Resumed(0, 8), aovs); }, "--aov albedo,normal",
        "albedo,normal,depth,instance,material");
}

// A choice that the render has made stays.
TEST(Resume, AnOptionThatLeavesAChoiceOpenTakesThatOfTheFile) {
    ResumedRender resumed = Resumed(0, 8);
    resumed.render.settings["light"] = "studio";
    EXPECT_EQ(SettingsOf(resumed, Asking(16, {{"light", "auto"}})).light, DefaultLight::Studio);
    ExpectError(
        ErrorKind::Usage,
        [&] {
            SettingsOf(resumed, Asking(16, {{"light", "none"}}));
        },
        "--light none", "old.exr was rendered with studio");
}

TEST(Resume, TheTotalMustBeMoreThanThereIs) {
    ExpectError(
        ErrorKind::Usage, [] { SettingsOf(Resumed(0, 8), Asking(8)); }, "--spp 8", "holds 8 samples");
    ExpectError(
        ErrorKind::Usage, [] { SettingsOf(Resumed(0, 8), {}); }, "--spp", "--time");
    RenderArguments timed;
    timed.seconds = 1.0;
    EXPECT_EQ(SettingsOf(Resumed(0, 8), timed).paths.seed, 9u);
}

TEST(Resume, WhatCannotBeContinuedIsBadInput) {
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder / "a.exr";
    const auto read = [&] { ReadResumedRender(path); };
    RenderFile render = MakeRender(0, 8);
    render.samples = {{0, 4}, {8, 4}};
    WriteRenderFile(path, render);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "0-3 8-11");

    render = MakeRender(0, 8);
    render.variance.clear();
    WriteRenderFile(path, render);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "variance");

    render = MakeRender(0, 8);
    render.sums = {};
    WriteRenderFile(path, render);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "sum0.R");

    render = MakeRender(0, 8);
    render.settings["view"] = "albedo";
    WriteRenderFile(path, render);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "albedo");

    render = MakeRender(0, 8);
    render.sceneHash.clear();
    WriteRenderFile(path, render);
    ExpectError(ErrorKind::BadInput, read, "a.exr", "saved by the editor");

    WriteRenderFile(path, MakeRender(3, 8));
    EXPECT_EQ(ReadResumedRender(path).render.samples, (SampleRanges{{3, 8}}));
}

TEST(Resume, ACompleteRenderHasTheSamplesOrTheError) {
    RenderFile render = MakeRender(5, 100);
    EXPECT_TRUE(IsComplete(render, {.samples = 100}));
    EXPECT_TRUE(IsComplete(render, {.samples = 99}));
    EXPECT_FALSE(IsComplete(render, {.samples = 101}));
    EXPECT_FALSE(IsComplete(render, {.seconds = 1.0})) << "each run takes its time";
    EXPECT_FALSE(IsComplete(render, {.relativeError = 0.9})) << "nothing was measured";
    // An error of 0.1 at 64 samples is 0.08 at 100
    render.measuredError = {64, 0.1};
    EXPECT_TRUE(IsComplete(render, {.relativeError = 0.08}));
    EXPECT_FALSE(IsComplete(render, {.relativeError = 0.0799}));
    EXPECT_TRUE(IsComplete(render, {.samples = 200, .relativeError = 0.08}));
    EXPECT_TRUE(IsComplete(render, {.samples = 100, .relativeError = 0.01}));
    EXPECT_FALSE(IsComplete(render, {.samples = 200, .relativeError = 0.01}));
    render.samples = {{5, 63}};  // no render stops before the first measurement
    EXPECT_FALSE(IsComplete(render, {.relativeError = 0.9}));
    render.measuredError = {64, std::nullopt};
    render.samples = {{5, 100}};
    EXPECT_FALSE(IsComplete(render, {.relativeError = 0.9}));
}

}  // namespace
}  // namespace raygraph::cli::resume_test
