// Tests of how a session decides on the studio, records it, and takes it from a file. They need a device.
#include "editor/session/file/merge.h"
#include "editor/session/session.h"
#include "editor/session/settings/light_settings.h"
#include "renderer/image/exr.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/vulkan_test.h"

namespace raygraph::session::session_light_test {

namespace {

using test::ExpectError;

class SessionLightTest : public testing::VulkanTest {
  protected:
    static SceneInput Dark() { return LoadInput(test::SceneFile("furnace_sphere.gltf")); }
    static SceneInput Lit() { return LoadInput(test::SceneFile("cornell.gltf")); }
    static PictureSettings Small(DefaultLight light = DefaultLight::Auto) {
        PictureSettings settings;
        settings.size = {8, 8};
        settings.light = light;
        return settings;
    }
    static RenderFile Render(SceneInput input, const PictureSettings& settings, uint32_t firstSample = 0) {
        Session session(Device(), std::move(input), {.settings = settings, .firstSample = firstSample});
        session.Run({.samples = 1});
        return session.Result().render;
    }
    static std::string LightOf(const RenderFile& render) {
        return render.settings.at(std::string(kLightSetting));
    }
};

}  // namespace

TEST_F(SessionLightTest, ASceneWithoutLightIsShownInTheStudio) {
    const RenderFile render = Render(Dark(), {.size = {8, 8}});
    EXPECT_EQ(LightOf(render), "studio");
    for (size_t i = 0; i < render.radiance.size(); i += 4) EXPECT_GT(render.radiance[i], 0.0f);
    const RenderFile dark = Render(Dark(), Small(DefaultLight::None));
    EXPECT_EQ(LightOf(dark), "none");
    EXPECT_EQ(test::SumOf(dark.radiance), 0.0);
    PictureSettings black = Small();
    black.background = {0.0f, 0.0f, 0.0f};
    const RenderFile withBackground = Render(Dark(), black);
    EXPECT_EQ(LightOf(withBackground), "none");
    EXPECT_EQ(test::SumOf(withBackground.radiance), 0.0);
}

TEST_F(SessionLightTest, ASceneWithALampHasTheBitsThatItHasWithoutAStudio) {
    const RenderFile render = Render(Lit(), Small());
    EXPECT_EQ(LightOf(render), "none");
    EXPECT_EQ(render.radiance, Render(Lit(), Small(DefaultLight::None)).radiance);
    const RenderFile asked = Render(Lit(), Small(DefaultLight::Studio));
    EXPECT_EQ(LightOf(asked), "studio");
    EXPECT_GT(test::SumOf(asked.radiance), 1.1 * test::SumOf(render.radiance)) << "around the box, at least";
}

TEST_F(SessionLightTest, WhatIsSeenDecidesNothing) {
    for (const bool isLit : {false, true}) {
        const SceneInput input = isLit ? Lit() : Dark();
        const DefaultLight expected = isLit ? DefaultLight::None : DefaultLight::Studio;
        PictureSettings settings = Small();
        EXPECT_EQ(ChooseLight(input, settings), expected);
        settings.size = {4096, 16};
        settings.crop = passes::Region{4000, 3, 1, 1};
        settings.camera = "0 900 0 0 1000 0 0 0 1 10";
        settings.paths.seed = 7;
        settings.isAdaptive = true;
        EXPECT_EQ(ChooseLight(input, settings), expected);
        settings.view = View::Raster;
        EXPECT_EQ(ChooseLight(input, settings), expected);
        settings.view = View::Normals;
        EXPECT_EQ(ChooseLight(input, settings), DefaultLight::None) << "it shows no light";
    }
    SceneInput mapped = Dark();
    SetEnvironment(mapped, {1, 1, {0, 0, 0, 1}}, "black");
    EXPECT_EQ(ChooseLight(mapped, Small()), DefaultLight::None);
}

TEST_F(SessionLightTest, AResumedRenderSaysWhetherThereIsAStudio) {
    for (const DefaultLight light : {DefaultLight::None, DefaultLight::Studio}) {
        ResumedRender first{"first.exr", Render(Dark(), Small(light))};
        SessionDesc desc = Resuming(first);
        desc.settings.light = DefaultLight::Auto;  // as for the pictures of a sequence
        Session session(Device(), Dark(), desc);
        session.Run({.samples = 2});
        EXPECT_EQ(LightOf(session.Result().render), Name(light));
        PictureSettings all = Small(light);
        Session whole(Device(), Dark(), {.settings = all});
        whole.Run({.samples = 2});
        EXPECT_EQ(session.Result().render.radiance, whole.Result().render.radiance);
        // A file that was rendered in the other light is refused
        const DefaultLight other = light == DefaultLight::None ? DefaultLight::Studio : DefaultLight::None;
        const ResumedRender unlike{"other.exr", Render(Dark(), Small(other))};
        ExpectError(
            ErrorKind::BadInput, [&] { session.StartPicture({.resumed = &unlike}); }, "other.exr", "light: ");
    }
}

TEST_F(SessionLightTest, RendersWithAndWithoutAStudioAreNotMerged) {
    ExpectError(
        ErrorKind::BadInput,
        [] {
            Merge({{"a.exr", Render(Dark(), Small())},
                   {"b.exr", Render(Dark(), Small(DefaultLight::None), 1)}});
        },
        "a.exr and b.exr differ", "light: studio against none");
    const RenderFile merged = Merge(
        {{"a.exr", Render(Dark(), Small())}, {"b.exr", Render(Dark(), Small(DefaultLight::Studio), 1)}});
    EXPECT_EQ(LightOf(merged), "studio");
}

TEST_F(SessionLightTest, AFileThatDoesNotSayIsWithoutAStudio) {
    const test::TemporaryFolder folder;
    WriteRenderFile(folder / "a.exr", Render(Dark(), Small(DefaultLight::None)));
    EXPECT_EQ(LightOf(ReadRenderFile(folder / "a.exr")), "none");
    image::ExrImage file = image::ReadExr(folder / "a.exr");
    ASSERT_EQ(file.attributes.erase("raygraph.setting.light"), 1u);
    image::WriteExr(folder / "old.exr", file);
    const ResumedRender old = ReadResumedRender(folder / "old.exr");
    EXPECT_EQ(LightOf(old.render), "none");
    Session session(Device(), Dark(), Resuming(old));
    session.Run({.samples = 2});
    EXPECT_EQ(test::SumOf(session.Result().render.radiance), 0.0);
}

TEST_F(SessionLightTest, AStudioGoesWithNoOtherEnvironment) {
    PictureSettings settings = Small(DefaultLight::Studio);
    settings.background = {1.0f, 1.0f, 1.0f};
    ExpectError(
        ErrorKind::Usage, [&] { const Session session(Device(), Dark(), {.settings = settings}); },
        "light: the studio takes the place of a background");
    SceneInput mapped = Dark();
    SetEnvironment(mapped, {1, 1, {1, 1, 1, 1}}, "white");
    ExpectError(
        ErrorKind::Usage,
        [&] { const Session session(Device(), mapped, {.settings = Small(DefaultLight::Studio)}); },
        "light: the studio takes the place of the map white");
}

TEST_F(SessionLightTest, TheColorOfTheStudioIsGrayAndThatOfItsTint) {
    PictureSettings settings = Small();
    settings.environmentTint = {1.0f, 0.5f, 0.25f};
    const std::optional<glm::dvec3> color = LightColor(Dark(), settings);
    ASSERT_TRUE(color);
    EXPECT_NEAR(color->y / color->x, 0.5, 1e-6);
    EXPECT_NEAR(color->z / color->x, 0.25, 1e-6);
    settings.light = DefaultLight::None;
    EXPECT_FALSE(LightColor(Dark(), settings));
}

}  // namespace raygraph::session::session_light_test
