// Tests what is shown behind a scene whose environment is hidden.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <string>

#include "base/files.h"
#include "editor/session/backdrop.h"
#include "renderer/gpu_scene/camera_record.h"
#include "renderer/image/image.h"
#include "renderer/scene/model/camera_view.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::session::backdrop_test {
namespace {

constexpr double kPi = std::numbers::pi;

// Returns a map whose radiance is a function of the direction.
template <typename Radiance>
image::ImageF MapOf(uint32_t width, Radiance&& radiance) {
    const uint32_t height = width / 2;
    image::ImageF map{width, height, {}};
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            const double azimuth = 2.0 * kPi * ((x + 0.5) / width - 0.5), polar = kPi * (y + 0.5) / height;
            const glm::dvec3 d(std::sin(polar) * std::cos(azimuth), std::cos(polar),
                               std::sin(polar) * std::sin(azimuth));
            const glm::dvec3 value = radiance(d);
            for (int c = 0; c < 3; ++c) map.rgba.push_back(static_cast<float>(value[c]));
            map.rgba.push_back(1.0f);
        }
    return map;
}

glm::vec3 Seen(const image::ImageF& map, const glm::dvec3& direction, float rotation = 0.0f) {
    const scene::CameraView view = scene::CameraView::LookAt({}, direction, {0, 1, 0});
    const image::ImageF seen = SeenOf(map, rotation, ToRecord(view), {1, 1}, passes::WholeOf({1, 1}));
    return {seen.rgba[0], seen.rgba[1], seen.rgba[2]};
}

TEST(Backdrop, BlurOfAMapIsTheSameInAllDirections) {
    SceneInput input;
    // Linear in the direction: any blur that is the same everywhere scales the slope by one factor
    input.environment = MapOf(128, [](const glm::dvec3& d) { return 2.0 + d; });
    for (const float degrees : {4.0f, 15.0f, 60.0f}) {
        const double s = glm::radians(double{degrees});
        double sum = 0.0, weights = 0.0;
        for (double a = 0.0005; a < std::min(3.0 * s, kPi); a += 0.001) {
            const double weight = std::sin(a) * std::exp(-0.5 * a * a / (s * s));
            weights += weight;
            sum += weight * std::cos(a);
        }
        const image::ImageF blurred = *BackdropMap(input, {}, degrees);
        for (const glm::dvec3& d : {glm::dvec3(0, 1, 0), glm::dvec3(1, 0, 0), glm::dvec3(-1, 0, 0.1),
                                    glm::dvec3(0.3, -0.9, -0.5), glm::dvec3(0, 0, -1)}) {
            const glm::dvec3 expected = 2.0 + sum / weights * glm::normalize(d);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(Seen(blurred, d)[c], expected[c], 0.03) << degrees << d.x << d.y;
        }
    }
}

TEST(Backdrop, MapIsSeenWhereTheEnvironmentIs) {
    const image::ImageF map = MapOf(64, [](const glm::dvec3& d) { return 1.0 + d; });
    for (const glm::dvec3& d : {glm::dvec3(1, 0, 0), glm::dvec3(0, 0, 1), glm::dvec3(-1, 0.2, -0.3)})
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(Seen(map, d)[c], 1.0 + glm::normalize(d)[c], 0.02);
    // A quarter turn moves what was at +x to -z
    EXPECT_NEAR(Seen(map, {0, 0, -1}, static_cast<float>(kPi / 2)).x, 2.0, 0.02);
}

TEST(Backdrop, TintAndMissingMap) {
    SceneInput input;
    PictureSettings settings;
    settings.light = DefaultLight::None;
    EXPECT_FALSE(BackdropMap(input, settings, 10.0f));
    settings.light = DefaultLight::Studio;
    EXPECT_TRUE(BackdropMap(input, settings, 30.0f));
    input.environment = MapOf(32, [](const glm::dvec3&) { return glm::dvec3(1.0); });
    settings.environmentTint = {1.0f, 0.5f, 0.25f};
    const glm::vec3 seen = Seen(*BackdropMap(input, settings, 30.0f), {1, 2, 3});
    EXPECT_NEAR(glm::distance(seen, glm::vec3(1.0f, 0.5f, 0.25f)), 0.0f, 1e-5f);
}

TEST(Backdrop, IsMixedInLinearLight) {
    const image::Image8 picture{3, 1, {255, 255, 255, 0, 255, 255, 255, 128, 10, 20, 30, 255}};
    const image::Image8 over = Over(picture, {0.0f, 1.0f, 0.21586f});
    EXPECT_EQ(over.rgba[0], 0);
    EXPECT_EQ(over.rgba[1], 255);
    EXPECT_EQ(over.rgba[2], 128);
    EXPECT_EQ(over.rgba[4], 188);  // half the light of white
    EXPECT_EQ(over.rgba[8], 10);
    for (size_t i = 3; i < over.rgba.size(); i += 4) EXPECT_EQ(over.rgba[i], 255);
    EXPECT_EQ(Over(picture, image::Image8{3, 1, std::vector<uint8_t>(12, 77)}).rgba[0], 77);
}

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
