// Tests the editor's stored settings.
#include "editor/app/settings.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "base/error.h"
#include "tests/support/environment_variable.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::editor::settings_test {

namespace {

class SettingsTest : public ::testing::Test {
  protected:
    Settings Read(const std::string& text) {
        std::ofstream(folder.Path() / "editor.json") << text;
        message.clear();
        return ReadSettings(folder.Path(), message);
    }
    test::TemporaryFolder folder;
    std::string message;
};

}  // namespace

TEST_F(SettingsTest, ComeBackAsTheyWere) {
    Settings settings;
    for (const PanelName& panel : kPanels) settings.panels.*panel.isShown ^= true;
    settings.window = {1234, 777};
    settings.show.view = viewport::View::Wipe;
    settings.show.wipePosition = 0.3f;
    settings.show.tonemap.exposureEv = -1.5f;
    settings.show.tonemap.tonemapOperator = static_cast<TonemapOperator>(0);
    settings.tool = GizmoTool::Scale;
    settings.toolSpace = GizmoSpace::Local;
    settings.pivot = GizmoPivot::Origin;
    settings.AddRecentFile("/scenes/a.gltf");
    const std::filesystem::path config = folder.Path() / "new" / "raygraph";
    WriteSettings(config, settings);
    EXPECT_EQ(ReadSettings(config, message), settings);
    EXPECT_EQ(message, "");
    EXPECT_EQ(ReadSettings(folder.Path() / "none", message), Settings());
    EXPECT_EQ(message, "") << "there need be none";
}

TEST_F(SettingsTest, EachPanelHasItsOwn) {
    for (const PanelName& panel : kPanels) {
        Settings settings;
        settings.panels.*panel.isShown ^= true;
        WriteSettings(folder.Path(), settings);
        EXPECT_EQ(ReadSettings(folder.Path(), message), settings);
    }
}

// The file is older than the log panel and than the operators' names on the command line.
TEST_F(SettingsTest, FileOfAnOlderVersionIsRead) {
    const Settings read = Read(R"({
        "gizmo": {"pivot": "Origin", "space": "Local", "tool": "Rotate"},
        "panels": {"graph": true, "help": false, "hierarchy": false, "inspector": true, "statistics": true},
        "recent": ["/scenes/a.gltf"],
        "view": {"exposure": 1.5, "maxError": 0.25, "tonemap": "AgX", "view": "Raster", "wipe": 0.75},
        "window": {"height": 777, "width": 1234}
    })");
    EXPECT_EQ(message, "");
    Settings expected;
    expected.tool = GizmoTool::Rotate;
    expected.toolSpace = GizmoSpace::Local;
    expected.pivot = GizmoPivot::Origin;
    expected.panels = {.hierarchy = false, .inspector = true, .statistics = true, .graph = true};
    expected.recent = {"/scenes/a.gltf"};
    expected.show.view = viewport::View::Raster;
    expected.show.tonemap = {.exposureEv = 1.5f, .tonemapOperator = TonemapOperator::AgX};
    expected.show.wipePosition = 0.75f;
    expected.show.maxError = 0.25f;
    expected.window = {1234, 777};
    EXPECT_EQ(read, expected);
}

TEST_F(SettingsTest, BrokenOnesAreLeftAsideWithOneLine) {
    for (const char* text : {"{", "[]", "{\"panels\": 3}", "{\"panels\": {\"help\": \"yes\"}}",
                             "{\"recent\": {}}", "{\"view\": {\"exposure\": []}}", "\xff\xfe", "\x7f"}) {
        EXPECT_EQ(Read(text), Settings()) << text;
        EXPECT_NE(message.find("editor.json: "), std::string::npos) << text;
        EXPECT_EQ(message.find_first_of("\n\x7f"), std::string::npos) << text;
    }
}

TEST_F(SettingsTest, ValuesOutOfRangeArePutIntoIt) {
    const Settings read = Read(
        "{\"window\": {\"width\": 1e9, \"height\": -4}, \"view\": {\"exposure\": 99, \"view\": \"of "
        "tomorrow\"}}");
    EXPECT_EQ(message, "");
    EXPECT_EQ(read.window, (rhi::Extent2D{16384, 320}));
    EXPECT_EQ(read.show.tonemap.exposureEv, 8.0f);
    EXPECT_EQ(read.show.view, Settings().show.view);
}

TEST_F(SettingsTest, RecentFilesAreFewAndTheNewestComesFirst) {
    Settings settings;
    for (int i = 0; i < 14; ++i) settings.AddRecentFile("/s/" + std::to_string(i) + ".gltf");
    settings.AddRecentFile("/s/x/../9.gltf");
    ASSERT_EQ(settings.recent.size(), Settings::kMaxRecent);
    EXPECT_EQ(settings.recent[0], "/s/9.gltf");
    EXPECT_EQ(settings.recent[1], "/s/13.gltf");
    EXPECT_EQ(std::count(settings.recent.begin(), settings.recent.end(), "/s/9.gltf"), 1);
}

TEST_F(SettingsTest, FolderIsTheUsersOrTheOneThatIsSet) {
    {
        const test::EnvironmentVariable config("XDG_CONFIG_HOME", "/somewhere");
        EXPECT_EQ(ConfigFolder(), "/somewhere/raygraph");
    }
    const test::EnvironmentVariable config("XDG_CONFIG_HOME", "relative"), home("HOME", "/home/somebody");
    EXPECT_EQ(ConfigFolder(), "/home/somebody/.config/raygraph");
}

TEST_F(SettingsTest, FolderThatCannotBeWrittenIsAnError) {
    std::ofstream(folder.Path() / "file") << "no folder";
    EXPECT_THROW(WriteSettings(folder.Path() / "file", {}), Error);
}

}  // namespace raygraph::editor::settings_test
