// Tests the log panel by scripts, without a window.
#include <imgui.h>

#include <fstream>
#include <string>

#include "base/files.h"
#include "renderer/image/image.h"
#include "tests/editor/editor_test.h"

namespace raygraph::editor::log_panel_test {

namespace {

// At these sizes the panel is as wide as the window, with its buttons at the right edge.
class LogPanelTest : public EditorTest {
  protected:
    LogPanelTest() : EditorTest({.shaders = {}, .log = std::make_shared<LogHistory>()}) {
        Panels& panels = editor.Work().panels;
        panels.hierarchy = panels.inspector = false;
        log->Add({LogLevel::Info, log_category::kScene, "cornell.gltf: 3 KiB read in 1.2 ms"});
        log->Add({LogLevel::Debug, log_category::kShaders, "pipeline of pathtrace/pathtrace.rgen is made"});
        log->Add({LogLevel::Warning, log_category::kCache, "cache.bin is ignored"});
        Play("size 640x400\nkey L\nframes 2\n");
    }
    // Rows of pixels of the panel, below which is the status line.
    static constexpr int kTop = 400 - 28 - 230, kBottom = 400 - 28;
    // Returns what a click on "Copy" puts on the clipboard.
    std::string Copied() {
        ImGui::SetClipboardText("nothing");
        Play(At(-86) + "click left\nframes 2\n");
        return ImGui::GetClipboardText();
    }
    // Moves the mouse in the row of buttons to this distance from the left edge, or from the right one if
    // negative.
    static std::string At(int x) {
        return "size 640x400\nmouse " + std::to_string(x < 0 ? 640 + x : x) + " " +
               std::to_string(kTop + 41) + "\nframes 2\n";
    }

    const std::shared_ptr<LogHistory> log = editor.Work().log;
};

}  // namespace

TEST_F(LogPanelTest, CopyTakesWhatTheFilterShowsAndClearForgetsAll) {
    ASSERT_TRUE(editor.Work().panels.log);
    EXPECT_EQ(Copied(), log->Text({})) << "all three";
    editor.Work().logFilter.minLevel = LogLevel::Warning;
    EXPECT_EQ(Copied(), log->Text({.minLevel = LogLevel::Warning}));
    editor.Work().logFilter = {};
    Play(At(320) + "click left\nframes 2\ntext RGEN\nframes 2\n");
    EXPECT_EQ(editor.Work().logFilter.text, "RGEN");
    EXPECT_TRUE(Copied().ends_with(" debug shaders: pipeline of pathtrace/pathtrace.rgen is made\n"))
        << Copied();
    Play(At(-30) + "click left\nframes 2\n");
    EXPECT_EQ(log->Text({}), "");
}

TEST_F(LogPanelTest, ShowsItsRowsAndManyMoreAreNoTrouble) {
    // Compares the panel alone, since numbers around it change by themselves
    const auto panel = [&] {
        Play("size 640x400\nmouse 1 1\nframes 2\nwindow " + (folder / "a.png").string() + "\n");
        const std::vector<uint8_t> texels = image::DecodeImage8(ReadFile(folder / "a.png"), "a.png").rgba;
        return std::vector(texels.begin() + 4 * 640 * kTop, texels.begin() + 4 * 640 * kBottom);
    };
    const auto three = panel();
    EXPECT_EQ(panel(), three) << "nothing was logged";
    for (size_t i = 0; i < 2 * LogHistory::kMax; ++i)
        log->Add({LogLevel::Error, log_category::kMemory, "line " + std::to_string(i)});
    const auto many = panel();
    log->Clear();
    const auto none = panel();
    EXPECT_NE(three, none);
    EXPECT_NE(many, three);
    EXPECT_NE(many, none);
}

TEST_F(LogPanelTest, AFailedLoadIsAMessage) {
    std::ofstream(folder / "broken.gltf") << "no scene";
    const size_t before = Log().Count();
    Play("open " + (folder / "broken.gltf").string() + "\nwait\n");
    EXPECT_NE(Log().Text(before).find("broken.gltf"), std::string::npos) << Log().Text(before);
}

}  // namespace raygraph::editor::log_panel_test
