// Tests what is shown behind a scene whose environment is hidden.
#include <gtest/gtest.h>
#include <glm/glm.hpp>
#include <string>

#include "base/files.h"
#include "renderer/image/image.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::session::backdrop_test {
namespace {

TEST(Backdrop, ColorIsShownAsItIsAndTheSceneStaysLit) {
    const test::TemporaryFolder folder;
    const auto render = [&](const std::string& options) {
        const test::ProgramResult result = test::RunProgram(
            folder, "render @glass_sphere.gltf --size 16x12 --spp 4 --background 0.5 --exposure 2 -o a.png " +
                        options);
        EXPECT_EQ(result.exitCode, 0) << result.messages;
        return image::DecodeImage8(ReadFile(folder / "a.png"), "a.png");
    };
    const image::Image8 cut = render("--transparent on"), shown = render("--backdrop '#336699'");
    size_t behind = 0, inFront = 0;
    for (size_t i = 0; i < cut.rgba.size(); i += 4) {
        EXPECT_EQ(shown.rgba[i + 3], 255);
        const bool isBehind = cut.rgba[i + 3] == 0;
        behind += isBehind;
        const glm::ivec3 color(shown.rgba[i], shown.rgba[i + 1], shown.rgba[i + 2]);
        if (isBehind) {
            EXPECT_EQ(color, glm::ivec3(0x33, 0x66, 0x99));
        }
        if (cut.rgba[i + 3] != 255) continue;
        ++inFront;
        for (size_t c = 0; c < 3; ++c) EXPECT_EQ(shown.rgba[i + c], cut.rgba[i + c]);
    }
    EXPECT_GT(behind, 8u);
    EXPECT_GT(inFront, 8u);
}

TEST(Ground, ShadowDarkensTheBackdropAndNothingElse) {
    const test::TemporaryFolder folder;
    const auto render = [&](const std::string& options) {
        const test::ProgramResult result = test::RunProgram(
            folder,
            "render @glass_sphere.gltf --size 24x18 --spp 16 --light studio --ground on --orbit 0,20 "
            "-o a.png " +
                options);
        EXPECT_EQ(result.exitCode, 0) << result.messages;
        return image::DecodeImage8(ReadFile(folder / "a.png"), "a.png");
    };
    // The mean of a channel in the lowest row, where the sphere's shadow ends
    const auto onGround = [](const image::Image8& picture, size_t channel) {
        double sum = 0.0;
        for (size_t x = 0; x < picture.width; ++x)
            sum += picture.rgba[4 * ((picture.height - 1) * size_t{picture.width} + x) + channel];
        return sum / picture.width;
    };
    const image::Image8 white = render("--backdrop white"), cut = render("--backdrop transparent");
    EXPECT_EQ(white.rgba[0], 255) << "the sky";
    EXPECT_LT(onGround(white, 0), 250.0);
    EXPECT_GT(onGround(white, 0), 225.0);
    EXPECT_EQ(cut.rgba[3], 0);
    EXPECT_GT(onGround(cut, 3), 10.0);
    EXPECT_LT(onGround(cut, 3), 70.0);
    EXPECT_EQ(onGround(cut, 0), 0.0) << "a shadow has no color";
    const image::Image8 studio = render(""), plane = render("--transparent off");
    EXPECT_GT(studio.rgba[0], 100) << "the studio is seen, darker on the ground";
    EXPECT_EQ(studio.rgba[3], 255);
    EXPECT_EQ(studio.rgba[0], plane.rgba[0]);
    EXPECT_LT(onGround(studio, 0), studio.rgba[0]);
    EXPECT_GT(onGround(plane, 0), onGround(studio, 0)) << "a gray plane is brighter than the studio's floor";
}

TEST(Backdrop, BlurNeedsAMap) {
    const test::TemporaryFolder folder;
    const auto messages = [&](const std::string& options) {
        const test::ProgramResult result =
            test::RunProgram(folder, "render @cornell.gltf --size 8x8 " + options);
        EXPECT_EQ(result.exitCode, 2) << result.messages;
        return result.messages;
    };
    EXPECT_NE(messages("--backdrop blur:10 --background gray").find("has no map to blur"), std::string::npos);
    EXPECT_NE(messages("--backdrop blur").find("nor map, blur:N or transparent"), std::string::npos);
    EXPECT_NE(messages("--backdrop gray --transparent on").find("exclude each other"), std::string::npos);
    EXPECT_NE(messages("--backdrop gray -o a.exr").find("--backdrop is of a .png"), std::string::npos);
    EXPECT_NE(messages("--view raster --ground on").find("only path-traced renders know --"),
              std::string::npos);
    EXPECT_NE(messages("--backdrop transparent -o a.jpg").find("a .jpg has no alpha"), std::string::npos);
}

}  // namespace
}  // namespace raygraph::session::backdrop_test
