#include "editor/app/log_panel.h"

#include <gtest/gtest.h>

#include <thread>

namespace raygraph::editor::log_history_test {
namespace {

LogEntry Entry(LogLevel level, const char* category, const char* text) {
    return {.time = "12:00:00", .level = level, .category = category, .text = text};
}

TEST(LogFilter, LetsThroughByLevelCategoryAndText) {
    const LogEntry entry = Entry(LogLevel::Warning, "shaders", "Tonemap.comp:12: 'lumi'");
    EXPECT_TRUE(LogFilter{}.Lets(entry));
    EXPECT_TRUE(LogFilter{.minLevel = LogLevel::Warning}.Lets(entry));
    EXPECT_FALSE(LogFilter{.minLevel = LogLevel::Error}.Lets(entry));
    EXPECT_TRUE(LogFilter{.category = "shaders"}.Lets(entry));
    EXPECT_FALSE(LogFilter{.category = "shader"}.Lets(entry)) << "categories are whole";
    EXPECT_TRUE(LogFilter{.text = "tonemap.COMP"}.Lets(entry)) << "case does not matter";
    EXPECT_TRUE(LogFilter{.text = "shad"}.Lets(entry)) << "the category is text, too";
    EXPECT_FALSE(LogFilter{.text = "Tonemap.frag"}.Lets(entry));
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
