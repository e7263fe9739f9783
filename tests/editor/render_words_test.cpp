// Tests the words of the command line that say what the editor shows.
#include "editor/app/render_words.h"

#include <gtest/gtest.h>
#include <imgui.h>
#include <map>

#include "editor/session/settings/picture_settings.h"
#include "renderer/image/image.h"
#include "tests/editor/editor_test.h"

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
