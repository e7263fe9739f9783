// Tests the log panel by scripts, without a window.
#include <gtest/gtest.h>
#include <imgui.h>
#include <algorithm>
#include <fstream>
#include <limits>
#include <string>
#include <thread>

#include "base/error.h"
#include "base/files.h"
#include "editor/app/frame_statistics.h"
#include "editor/app/graph_layout.h"
#include "editor/app/log_history.h"
#include "editor/app/settings.h"
#include "renderer/graph/compile.h"
#include "renderer/image/image.h"
#include "tests/editor/editor_test.h"
#include "tests/support/environment_variable.h"
#include "tests/support/temporary_folder.h"

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
        Play("size 640x400\nview raster\nkey L\nframes 2\n");
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

namespace raygraph::editor::log_history_test {
namespace {

LogEntry Entry(LogLevel level, const char* category, const char* text) {
    return {.time = "12:00:00", .level = level, .category = category, .text = text};
}

TEST(LogFilter, LetsThroughByLevelCategoryAndText) {
    const LogEntry entry = Entry(LogLevel::Warning, "shaders", "Tonemap.comp:12: 'lumi'");
    EXPECT_TRUE(LogFilter{}.Accepts(entry));
    EXPECT_TRUE(LogFilter{.minLevel = LogLevel::Warning}.Accepts(entry));
    EXPECT_FALSE(LogFilter{.minLevel = LogLevel::Error}.Accepts(entry));
    EXPECT_TRUE(LogFilter{.category = "shaders"}.Accepts(entry));
    EXPECT_FALSE(LogFilter{.category = "shader"}.Accepts(entry)) << "categories are whole";
    EXPECT_TRUE(LogFilter{.text = "tonemap.COMP"}.Accepts(entry)) << "case does not matter";
    EXPECT_TRUE(LogFilter{.text = "shad"}.Accepts(entry)) << "the category is text, too";
    EXPECT_FALSE(LogFilter{.text = "Tonemap.frag"}.Accepts(entry));
}

TEST(LogHistory, KeepsTheNewestAndCountsByLevel) {
    LogHistory history;
    for (size_t i = 0; i < LogHistory::kMax + 10; ++i)
        history.Add({LogLevel::Info, log_category::kScene, std::to_string(i)});
    history.Add({LogLevel::Error, log_category::kScene, "last"});
    EXPECT_EQ(history.CountOf(LogLevel::Info), LogHistory::kMax + 10);
    EXPECT_EQ(history.CountOf(LogLevel::Error), 1u);
    history.Read([](const std::deque<LogEntry>& entries) {
        ASSERT_EQ(entries.size(), LogHistory::kMax);
        EXPECT_EQ(entries.front().text, "11");
        EXPECT_EQ(entries.back().text, "last");
        EXPECT_EQ(entries.back().time.size(), 8u) << entries.back().time;
    });
    const uint64_t revision = history.Revision();
    EXPECT_EQ(history.Revision(), revision);
    history.Clear();
    EXPECT_NE(history.Revision(), revision);
    EXPECT_EQ(history.CountOf(LogLevel::Error), 0u);
    EXPECT_EQ(history.Text({}), "");
}

TEST(LogHistory, TextIsWhatTheFilterLetsThrough) {
    LogHistory history;
    history.Add({LogLevel::Info, log_category::kScene, "a.gltf"});
    history.Add({LogLevel::Warning, log_category::kCache, "is ignored"});
    const std::string text = history.Text({.minLevel = LogLevel::Warning});
    EXPECT_TRUE(text.ends_with(" warning cache: is ignored\n")) << text;
    EXPECT_EQ(text.find("a.gltf"), std::string::npos);
}

TEST(LogHistory, IsAddedToBesideItsReader) {
    LogHistory history;
    std::thread other([&] {
        for (int i = 0; i < 2000; ++i) history.Add({LogLevel::Info, log_category::kScene, "other"});
    });
    for (uint32_t seen = 0; seen < 2000; seen = history.CountOf(LogLevel::Info))
        history.Read([](const std::deque<LogEntry>& entries) {
            for (const LogEntry& entry : entries) ASSERT_EQ(entry.text, "other");
        });
    other.join();
}

}  // namespace
}  // namespace raygraph::editor::log_history_test

// Tests what is stored of the last frames.
namespace raygraph::editor::frame_history_test {

namespace {

FrameTiming Timing(std::vector<PassTiming> passes) {
    FrameTiming timing;
    timing.declareMs = timing.compileMs = timing.recordMs = timing.submitMs = 0.25;
    timing.passes = std::move(passes);
    return timing;
}

}  // namespace

TEST(FrameHistory, PassesOfANameAreOneAndTheLongestComesFirst) {
    FrameHistory history;
    history.Add(Timing({{"Trace", 0.0, 4.0}, {"Tonemap", 0.0, 1.0}, {"Trace", 0.0, 2.0}}));
    history.Add(Timing({{"Tonemap", 0.0, 3.0}, {"Idle", 0.0, 0.0}}));
    EXPECT_EQ(history.Gpu(), (std::vector<float>{7.0f, 3.0f}));
    EXPECT_EQ(history.Cpu(), (std::vector<float>{1.0f, 1.0f}));
    const std::vector<FrameHistory::Pass> passes = history.Passes();
    ASSERT_EQ(passes.size(), 2u);
    EXPECT_EQ(passes[0].name, "Trace");
    EXPECT_EQ(passes[0].ms, (std::vector<float>{6.0f, 0.0f}));
    EXPECT_EQ(passes[0].mean, 3.0f);
    EXPECT_EQ(passes[1].ms, (std::vector<float>{1.0f, 3.0f}));
}

TEST(FrameHistory, ForgetsTheOldest) {
    FrameHistory history;
    for (size_t i = 0; i < FrameHistory::kLength + 5; ++i)
        history.Add(Timing({{"Pass", 0.0, static_cast<double>(i)}}));
    EXPECT_EQ(history.Count(), FrameHistory::kLength);
    EXPECT_EQ(history.Gpu().front(), 5.0f);
    EXPECT_EQ(history.Passes()[0].ms.size(), FrameHistory::kLength);
}

TEST(SampleRate, IsThatOfTheLastSeconds) {
    SampleRate rate;
    EXPECT_FALSE(rate.PerSecond());
    for (int i = 0; i <= 100; ++i) rate.Add(0.1 * i, 0.5 * i);  // 5 per second
    EXPECT_NEAR(*rate.PerSecond(), 5.0, 1e-9);
    for (int i = 1; i <= 100; ++i) rate.Add(10.0 + 0.1 * i, 50.0 + 2.0 * i);  // then 20 per second
    EXPECT_NEAR(*rate.PerSecond(), 20.0, 1e-6) << "what was before is forgotten";
    rate.Add(20.1, 0.0);
    EXPECT_FALSE(rate.PerSecond()) << "accumulation restarted";
}

TEST(TimeLeft, FallsWithTheSquareOfTheError) {
    EXPECT_NEAR(SecondsLeft(0.02, 0.01, 100.0, 10.0), 30.0, 1e-9) << "400 samples are needed";
    EXPECT_EQ(SecondsLeft(0.005, 0.01, 100.0, 10.0), 0.0);
}

}  // namespace raygraph::editor::frame_history_test

// Tests the positions in the drawing of a plan.
namespace raygraph::editor::graph_layout_test {

namespace {

// The plan is Draw -> a -> Blur -> b -> Show, a pass that nothing needs, and one that updates a persistent
// resource.
class GraphLayoutTest : public ::testing::Test {
  protected:
    GraphLayoutTest() {
        graph.Begin(1);
        const auto texture = [&](const char* name, Origin origin = Origin::Transient) {
            return graph.Add<ResourceKind::Texture>(
                {.name = name, .origin = origin, .extent = {8, 8}, .format = rhi::Format::Rgba8Unorm});
        };
        TextureId a = texture("a"), unused = texture("unused"), b = texture("b");
        TextureId kept = texture("kept", Origin::Persistent);
        const BufferId table = graph.Add<ResourceKind::Buffer>(
            {.name = "table", .origin = Origin::Imported, .bytes = 64, .version = 1});
        graph.AddPass("Draw", PassKind::Compute);
        std::ignore = graph.Use(table, Access::StorageRead);
        a = graph.Use(a, Access::StorageWrite);
        graph.AddPass("Waste", PassKind::Compute);
        std::ignore = graph.Use(a, Access::Sampled);
        unused = graph.Use(unused, Access::StorageWrite);
        graph.AddPass("Blur", PassKind::Compute);
        std::ignore = graph.Use(a, Access::Sampled);
        b = graph.Use(b, Access::StorageWrite);
        graph.AddPass("Keep", PassKind::Compute);
        std::ignore = graph.Use(b, Access::Sampled);
        kept = graph.Use(kept, Access::StorageWrite);
        graph.AddPass("Mend", PassKind::Compute);
        kept = graph.Use(kept, Access::StorageUpdate);
        graph.Present(kept);
        plan = Compile(graph);
    }
    const GraphLane& LaneOf(const GraphLayout& layout, const std::string& name) const {
        return *std::ranges::find_if(
            layout.lanes, [&](const GraphLane& lane) { return graph.resources[lane.resource].name == name; });
    }
    std::string BoxNames(const GraphLayout& layout) const {
        std::string names;
        for (const GraphBox& box : layout.boxes) {
            const std::string name(graph.passes[box.pass].name);
            names += (box.isCulled ? "(" + name + ")" : name) + " ";
        }
        return names;
    }

    FrameGraph graph;
    Plan plan;
};

}  // namespace

TEST_F(GraphLayoutTest, BoxesAreInOrderWithCulledOnesWhereTheyWereDeclared) {
    EXPECT_EQ(BoxNames(LayOut(graph, plan, true)), "Draw (Waste) Blur Keep Mend ");
    const GraphLayout executed = LayOut(graph, plan, false);
    EXPECT_EQ(BoxNames(executed), "Draw Blur Keep Mend ");
    for (size_t i = 1; i < executed.boxes.size(); ++i)
        EXPECT_GT(executed.boxes[i].x, executed.boxes[i - 1].x + GraphLayout::kBoxWidth);
    EXPECT_GE(executed.size.x, executed.boxes.back().x + GraphLayout::kBoxWidth);
}

TEST_F(GraphLayoutTest, MarksSayWhoReadsWritesAndWaits) {
    const GraphLayout layout = LayOut(graph, plan, true);
    const GraphLane& a = LaneOf(layout, "a");
    ASSERT_EQ(a.marks.size(), 3u);
    EXPECT_TRUE(a.marks[0].isWritten && !a.marks[0].isRead);
    EXPECT_TRUE(a.marks[1].isRead && a.marks[1].barriers.empty()) << "culled: it waits for nothing";
    ASSERT_EQ(a.marks[2].barriers.size(), 1u);
    EXPECT_EQ(plan.barriers[a.marks[2].barriers[0]].resource, a.resource);
    const GraphLane& kept = LaneOf(layout, "kept");
    ASSERT_EQ(kept.marks.size(), 2u);
    EXPECT_TRUE(kept.marks[1].isRead && kept.marks[1].isWritten) << "an update is both";
    EXPECT_EQ(kept.marks[1].box, 4u);
}

TEST_F(GraphLayoutTest, LanesOfOneRowDoNotTouch) {
    const GraphLayout layout = LayOut(graph, plan, true);
    for (const GraphLane& one : layout.lanes)
        for (const GraphLane& other : layout.lanes) {
            if (&one == &other || one.row != other.row) continue;
            const bool isBefore =
                layout.CenterOf(one.marks.back().box) < layout.CenterOf(other.marks.front().box);
            const bool isAfter =
                layout.CenterOf(other.marks.back().box) < layout.CenterOf(one.marks.front().box);
            EXPECT_TRUE(isBefore || isAfter);
        }
    const auto isMade = [](const GraphLane& lane) {
        return std::ranges::any_of(lane.marks, [](const GraphMark& mark) { return mark.isWritten; });
    };
    EXPECT_TRUE(std::ranges::is_partitioned(layout.lanes, isMade)) << "what is only read lies below";
    EXPECT_FALSE(isMade(layout.lanes.back()));
    EXPECT_LT(layout.rowCount, layout.lanes.size()) << "a and kept follow each other";
    const GraphLayout nothing = LayOut({}, {}, true);
    EXPECT_TRUE(nothing.boxes.empty() && nothing.lanes.empty());
}

}  // namespace raygraph::editor::graph_layout_test

namespace raygraph::editor::memory_rows_test {
namespace {

std::string Lines(const std::vector<MemoryRow>& rows) {
    std::string text;
    for (const MemoryRow& row : rows) text += row.name + ": " + row.value + "\n";
    return text;
}

TEST(MemoryRows, SayWhatIsTakenOfWhatThereIs) {
    const std::vector<rhi::MemoryHeap> heaps{
        {true, 8192u << 20ull, uint64_t{6144} << 20, uint64_t{512} << 20},
        {false, 0, uint64_t{1024} << 20, uint64_t{3} << 19}};
    EXPECT_EQ(Lines(MemoryRows({.usedBytes = 5 << 20, .peakBytes = 7 << 20}, heaps)),
              "memory: 5 MiB, peak 7 MiB\n"
              "device heap: 512 MiB of 6 GiB\n"
              "host heap: 1.5 MiB of 1 GiB\n");
}

TEST(MemoryRows, SayWhatIsInTheHostsMemoryForWantOfTheDevices) {
    EXPECT_EQ(Lines(MemoryRows({.usedBytes = 5 << 20, .peakBytes = 5 << 20, .fallbackBytes = 2 << 20}, {})),
              "memory: 5 MiB, peak 5 MiB\n"
              ": 2 MiB in the host's memory: the device's is full\n");
}

}  // namespace
}  // namespace raygraph::editor::memory_rows_test

namespace raygraph::editor::real_time_errors_test {

TEST(RealTimeErrorHistory, SaysAgainstHowManySamplesAndWhatIsNotKnown) {
    RealTimeErrorHistory history;
    EXPECT_TRUE(history.Curves().empty());
    history.Add({.referenceSamples = 1, .relativeSquaredError = 2.0, .flip = 0.5});
    std::vector<RealTimeErrorHistory::Curve> curves = history.Curves();
    ASSERT_EQ(curves.size(), 4u);
    EXPECT_EQ(curves[0].text, "        2 relMSE against 1 sample");
    EXPECT_EQ(curves[1].text, "        - of this, noise of the reference");
    history.Add({.referenceSamples = 57,
                 .relativeSquaredError = 0.0125,
                 .referenceNoise = 0.004,
                 .flip = 0.031,
                 .flicker = 1.3e-5});
    curves = history.Curves();
    EXPECT_EQ(curves[0].text, "    0.013 relMSE against 57 samples");
    EXPECT_EQ(curves[1].text, "    0.004 of this, noise of the reference");
    EXPECT_EQ(curves[2].text, "    0.031 FLIP against 57 samples");
    EXPECT_EQ(curves[3].text, "  1.3e-05 flicker of the last second");
    EXPECT_EQ(curves[3].values, (std::vector<std::optional<float>>{std::nullopt, 1.3e-5f}));
    EXPECT_EQ(curves[0].values, (std::vector<std::optional<float>>{2.0f, 0.0125f}));
    for (size_t i = 0; i < RealTimeErrorHistory::kLength; ++i) history.Add({.referenceSamples = 9});
    EXPECT_EQ(history.Curves()[0].values.size(), RealTimeErrorHistory::kLength);
    EXPECT_EQ(history.Curves()[0].values.front(), 0.0f);
}

TEST(OnLogAxis, PutsDecadesAtEqualDistances) {
    EXPECT_FLOAT_EQ(OnLogAxis(1e-3f, 1e-6f, 1.0f), 0.5f);
    EXPECT_EQ(OnLogAxis(5.0f, 1e-6f, 1.0f), 1.0f);
    for (const float low : {1e-7f, 0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN()})
        EXPECT_EQ(OnLogAxis(low, 1e-6f, 1.0f), 0.0f);
}

}  // namespace raygraph::editor::real_time_errors_test

// Tests the editor's stored settings.
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
    settings.panelSizes = {.left = 210.0f, .right = 330.0f, .lower = 280.0f, .inspector = 0.4f};
    settings.window = {1234, 777};
    settings.view = viewport::View::Wipe;
    settings.show.compared = viewport::Compared::RealTime;
    settings.show.isDenoised = true;
    settings.whileMoving = viewport::MotionView::Raster;
    settings.show.wipePosition = 0.3f;
    settings.show.tonemap.exposureEv = -1.5f;
    settings.whitePoint = 3400;
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
    expected.view = viewport::View::Raster;
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
    EXPECT_EQ(read.view, std::nullopt);
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
