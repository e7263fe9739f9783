// Tests the words of the command line that say what the editor shows.
#include "editor/app/render_words.h"

#include <gtest/gtest.h>
#include <imgui.h>
#include <cstdlib>
#include <map>

#include "base/files.h"
#include "editor/session/file/render_file.h"
#include "editor/session/settings/picture_settings.h"
#include "renderer/image/image.h"
#include "tests/editor/editor_test.h"
#include "tests/support/text_files.h"

namespace raygraph::editor {

namespace {

class RenderWordsTest : public EditorTest {
  protected:
    // Returns the options by their names, without "--".
    static std::map<std::string, std::string> OptionsOf(const std::vector<std::string>& words) {
        std::map<std::string, std::string> options;
        for (size_t i = 0; i < words.size(); ++i) {
            EXPECT_TRUE(words[i].starts_with("--")) << words[i];
            const std::string name = words[i].substr(2);
            const size_t equals = name.find('=');
            options[name.substr(0, equals)] =
                equals != std::string::npos ? name.substr(equals + 1) : words.at(++i);
        }
        return options;
    }
    // Returns the settings that `render` makes of what is shown.
    session::PictureSettings Parsed() {
        session::SettingTexts texts;
        for (const auto& [name, value] : OptionsOf(RenderWords(editor.Work(), ShownSettings(editor.Work()))))
            texts[name] = value;
        return session::SettingsFrom(texts);  // which ignores what is no setting
    }
};

void ExpectSameView(const scene::CameraView& a, const scene::CameraView& b) {
    ASSERT_EQ(a.projection, b.projection);
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(a.eye[i], b.eye[i], 1e-8) << "decimals, finer than a float";
        EXPECT_NEAR(a.forward[i], b.forward[i], 2e-7f);
        EXPECT_NEAR(a.up[i], b.up[i], 2e-7f);
        EXPECT_NEAR(a.right[i], b.right[i], 2e-7f);
    }
    if (a.projection == scene::Projection::Orthographic)
        EXPECT_FLOAT_EQ(a.height, b.height);
    else
        EXPECT_FLOAT_EQ(a.yFov, b.yFov);
}

}  // namespace

TEST_F(RenderWordsTest, CopiedCameraIsTheViews) {
    Play(OpenCornell() + "mouse 320 200\ndrag left 37 -21\nwheel 3\nkey ctrl+shift+c\n" +
         "expect message copied --camera\n");
    const auto copied = [&] {
        const std::string text = ImGui::GetClipboardText();
        const size_t first = text.find('"') + 1;
        EXPECT_TRUE(text.starts_with("--camera \"")) << text;
        return scene::ViewFromText(text.substr(first, text.size() - 1 - first), 1.0f);
    };
    const scene::CameraView& view = editor.Work().camera.View();
    ExpectSameView(copied(), view);
    Play("key 5\nkey ctrl+shift+c\n");
    ASSERT_EQ(view.projection, scene::Projection::Orthographic);
    ExpectSameView(copied(), view);
}

TEST_F(RenderWordsTest, OptionsSayWhatIsShown) {
    image::WriteHdr(folder / "a sky.hdr", {8, 4, std::vector<float>(8 * 4 * 4, 0.5f)});
    Play(OpenCornell() + "view path-traced\nopen " + (folder / "a sky.hdr").string() + "\nwait\n");
    Workspace& work = editor.Work();
    viewport::ShowSettings show = work.view.Show();
    show.tonemap = {.exposureEv = -1.5f, .tonemapOperator = TonemapOperator::AgX};
    work.view.SetShow(show);
    work.gpu.SetEnvironment({.radiance = {0.5f, 1.0f, 2.0f}, .rotation = -0.75f});
    viewport::PathSettings paths = work.view.Paths();
    paths.biases.maxDepth = 3;
    work.view.SetPaths(paths);

    const session::PictureSettings shown = ShownSettings(work), parsed = Parsed();
    EXPECT_EQ(session::FirstDifference(session::Texts(parsed), session::Texts(shown)), "");
    EXPECT_EQ(parsed.paths, paths);
    EXPECT_EQ(parsed.size, work.view.Size());
    EXPECT_FLOAT_EQ(parsed.environmentRotation, glm::degrees(-0.75f));
    EXPECT_EQ(parsed.environmentTint, (std::array{0.5f, 1.0f, 2.0f}));
    const auto options = OptionsOf(RenderWords(work, shown));
    EXPECT_EQ(options.at("exposure"), "-1.5");
    EXPECT_EQ(options.at("tonemap"), "agx");
    EXPECT_EQ(options.at("env"), (folder / "a sky.hdr").string());

    Play("key ctrl+shift+r\nexpect message copied raygraph render\n");
    const std::string line = ImGui::GetClipboardText();
    EXPECT_NE(line.find("--env \"" + (folder / "a sky.hdr").string() + '"'), std::string::npos) << line;
    EXPECT_NE(line.find(" --exposure=-1.5 --tonemap agx"), std::string::npos) << line;
}

#ifdef RAYGRAPH_BUILT_PROGRAM

TEST_F(RenderWordsTest, TheCopiedCommandMakesTheShownPicture) {
    std::vector<float> sky(8 * 4 * 4, 0.5f);
    for (size_t i = 0; i < sky.size(); i += 5) sky[i] = 0.25f + 0.01f * static_cast<float>(i);
    image::WriteHdr(folder / "a sky.hdr", {8, 4, sky});
    Workspace& work = editor.Work();
    work.panels.hierarchy = work.panels.inspector = false;
    viewport::BudgetSettings budget = work.view.Budget();
    budget.maxSamples = 3;
    work.view.SetBudget(budget);
    Play("size 320x200\nopen " + test::SourceFile("scenes/cornell.gltf").string() + "\nopen " +
         (folder / "a sky.hdr").string() + "\nwait\nmouse 160 100\ndrag left 37 -21\nwheel -2\n" +
         "key shift+f\nexpect message click on what is to be in focus\nclick left\nwait\n" +
         "expect message in focus: \nexpect selected nothing\n" +
         "fov 51.3\naperture 0.07\nexposure 0.7\nwhite-point 3700\nsize 64x99\nframes 2\n");
    work.gpu.SetEnvironment({.radiance = {0.5f, 1.0f, 2.0f}, .rotation = -0.75f});
    work.view.SetRaster({});  // recorded as `render` does, which has no such option for this view

    const auto texels = [&](const char* name) {
        return image::DecodeImage8(ReadFile(folder / name), name).rgba;
    };
    const auto show = [&](const std::string& changes) {
        Play("size 64x99\nview path-traced\n" + changes + "samples 3\npicture " +
             (folder / "shown.png").string() + "\npicture " + (folder / "shown.exr").string() +
             "\nkey ctrl+shift+r\n");
        return texels("shown.png");
    };
    const auto expectSamePicture = [&](std::initializer_list<const char*> options) {
        const std::string command = ImGui::GetClipboardText();
        for (const char* option : options)
            EXPECT_NE(command.find(option), std::string::npos) << command << " lacks" << option;
        const std::string line =
            "cd " + folder.Path().string() +
            " && PATH=" + std::filesystem::path(RAYGRAPH_BUILT_PROGRAM).parent_path().string() +
            ":$PATH && " + command + " --spp 3 --output made.png --output made.exr > output 2>&1";
        ASSERT_EQ(std::system(line.c_str()), 0) << line << test::TextOf(folder / "output");
        const session::RenderFile shown = session::ReadRenderFile(folder / "shown.exr"),
                                  made = session::ReadRenderFile(folder / "made.exr");
        EXPECT_EQ(shown.samples, made.samples);
        EXPECT_EQ(shown.radiance, made.radiance) << "the same bits";
        EXPECT_EQ(session::FirstDifference(shown.settings, made.settings), "");
        EXPECT_EQ(texels("shown.png"), texels("made.png"));
    };
    show("");
    expectSamePicture({" --aperture 0.07 ", " --focus ", " --exposure 0.7 ", " --white-point 3700", " 51.3"});
    work.UseCamera("orbit 30 25");
    const std::vector<uint8_t> withoutGround = show("backdrop blur:20\n");
    EXPECT_NE(show("ground on\n"), withoutGround) << "its shadow is seen";
    expectSamePicture({" --backdrop blur:20", " --ground on"});
}

#endif

TEST_F(RenderWordsTest, ViewsLeaveOutWhatRenderRefusesForThem) {
    Play(OpenCornell());
    viewport::PathSettings paths = editor.Work().view.Paths();
    paths.biases.maxDepth = 3;
    editor.Work().view.SetPaths(paths);
    session::PictureSettings parsed = Parsed();
    EXPECT_EQ(parsed.view, passes::View::Raster);
    EXPECT_EQ(parsed.paths, viewport::PathSettings{});
    EXPECT_EQ(parsed.raster.shadows, passes::RasterShadows::Off);
    viewport::ShowSettings show = editor.Work().view.Show();
    show.view = viewport::View::Surface;
    show.surface = passes::View::Normals;
    show.tonemap.exposureEv = 2.0f;
    editor.Work().view.SetShow(show);
    parsed = Parsed();
    EXPECT_EQ(parsed.view, passes::View::Normals);
    const auto options = OptionsOf(RenderWords(editor.Work(), ShownSettings(editor.Work())));
    EXPECT_FALSE(options.contains("exposure"));
    EXPECT_FALSE(options.contains("light"));
}

TEST(ShellLine, QuotesWhatAShellWouldChange) {
    EXPECT_EQ(ShellLine(std::vector<std::string>{"a-b=1,2", "two words", "", "it's", "a$b", "#1"}),
              "a-b=1,2 \"two words\" \"\" \"it's\" 'a$b' \"#1\"");
}

}  // namespace raygraph::editor
