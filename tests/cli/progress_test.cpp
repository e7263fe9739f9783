#include "editor/cli/progress.h"

#include <pty.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <thread>

#include "tests/cli/cli_test.h"

namespace raygraph::cli::progress_test {
namespace {

TEST(Progress, LineShowsWhatIsKnown) {
    EXPECT_EQ(FormatProgress({128, 256, 1.234e6, 0.0179, 12.2}),
              "  128/256 samples  1.23 Msamples/s  error 1.8 %  12 s left");
    ProgressState restoring{128, 256, 1.234e6, 0.0179, 12.2};
    restoring.samplesRestored = 12;
    EXPECT_EQ(FormatProgress(restoring), "  restoring albedo and normals  12/128 samples");
    EXPECT_EQ(FormatProgress({1, 1, 0.0, std::nullopt, std::nullopt}), "  1/1 sample");
    EXPECT_EQ(FormatProgress({1, 2, 0.0, std::nullopt, std::nullopt}), "  1/2 samples");
    EXPECT_EQ(FormatProgress({1, std::nullopt, 0.0, std::nullopt, std::nullopt}), "  1 sample");
    EXPECT_EQ(FormatProgress({3, std::nullopt, 0.0, std::nullopt, std::nullopt}), "  3 samples");
}

TEST(Progress, WritesNothingToAFile) {
    std::FILE* file = std::tmpfile();
    ASSERT_NE(file, nullptr);
    {
        Progress progress(file, false);
        EXPECT_FALSE(progress.IsOn());
        progress.ShowStep("x");
    }
    EXPECT_EQ(std::ftell(file), 0);
    std::fclose(file);
}

// Simulates a terminal of 40 columns that records what was written to it.
class Terminal {
  public:
    Terminal() {
        const winsize size{.ws_row = 10, .ws_col = 40, .ws_xpixel = 0, .ws_ypixel = 0};
        int inside = -1;
        if (openpty(&m_outside, &inside, nullptr, nullptr, &size) == 0) m_stream = fdopen(inside, "w");
    }
    ~Terminal() {
        if (m_stream) std::fclose(m_stream);
        close(m_outside);
    }
    Terminal(const Terminal&) = delete;
    Terminal& operator=(const Terminal&) = delete;

    std::FILE* Stream() const { return m_stream; }
    // Returns what was written since the last call as lines, each with what overwrote it. Text arrives in
    // pieces with a delay, so a mark after it tells that everything is here.
    std::string Shown() {
        constexpr char kMark = '\x1f';
        std::fputc(kMark, m_stream);
        std::fflush(m_stream);
        std::string text;
        std::array<char, 4096> buffer{};
        while (!text.ends_with(kMark)) {
            const ssize_t count = read(m_outside, buffer.data(), buffer.size());
            if (count <= 0) return text + " and no more";
            text.append(buffer.data(), static_cast<size_t>(count));
        }
        text.pop_back();
        std::string shown, line;
        size_t column = 0;
        for (const char c : text) {
            if (c == '\r') {
                column = 0;
            } else if (c == '\n') {
                shown += Trimmed(line) + "\n";
                line.clear();
            } else {
                line.resize(std::max(line.size(), column + 1), ' ');
                line[column++] = c;
            }
        }
        return shown + Trimmed(line);
    }

  private:
    static std::string Trimmed(const std::string& line) {
        return line.substr(0, line.find_last_not_of(' ') + 1);
    }

    int m_outside = -1;
    std::FILE* m_stream = nullptr;
};

TEST(Progress, LineIsBelowWhatIsPrintedAboveIt) {
    Terminal terminal;
    ASSERT_NE(terminal.Stream(), nullptr);
    Progress progress(terminal.Stream(), false);
    ASSERT_TRUE(progress.IsOn());
    progress.PrintAboveProgress("first\n");
    EXPECT_EQ(terminal.Shown(), "first\n") << "there is no line yet";
    progress.ShowSamples("", {.samplesDone = 3});
    progress.PrintAboveProgress("second\n");
    progress.PrintAboveProgress("third\n");
    EXPECT_EQ(terminal.Shown(), "second\nthird\n  3 samples");
    progress.ShowStep("4");
    EXPECT_EQ(terminal.Shown(), "  4") << "nothing is left of the longer one";
    progress.Clear();
    progress.PrintAboveProgress("fourth\n");
    EXPECT_EQ(terminal.Shown(), "fourth\n");
}

TEST(Progress, LineThatIsWiderThanTheTerminalIsCut) {
    Terminal terminal;
    ASSERT_NE(terminal.Stream(), nullptr);
    Progress progress(terminal.Stream(), false);
    progress.ShowStep(std::string(100, 'x'));
    EXPECT_EQ(terminal.Shown(), "  " + std::string(37, 'x'));
    progress.PrintAboveProgress("above\n");
    EXPECT_EQ(terminal.Shown(), "above\n  " + std::string(37, 'x'));
}

TEST(Progress, IsRedrawnFiveTimesASecondAtMost) {
    Terminal terminal;
    ASSERT_NE(terminal.Stream(), nullptr);
    Progress progress(terminal.Stream(), false);
    const auto since = [](const auto& start) { return std::chrono::steady_clock::now() - start; };
    bool wasInTime = false;
    while (!wasInTime) {  // on a busy machine, the second state may come too late
        progress.Clear();
        const auto start = std::chrono::steady_clock::now();
        progress.ShowLoading("meshes", 0.1f);
        progress.ShowLoading("meshes", 0.2f);
        wasInTime = since(start) < std::chrono::milliseconds(200);
        const std::string shown = terminal.Shown();
        EXPECT_TRUE(shown == "  loading meshes  10 %" || !wasInTime) << shown;
    }
    progress.ShowLoading("images", 0.5f);
    EXPECT_EQ(terminal.Shown(), "  loading images  50 %") << "another stage is shown at once";
    std::this_thread::sleep_for(std::chrono::milliseconds(210));
    progress.ShowLoading("images", 0.6f);
    EXPECT_EQ(terminal.Shown(), "  loading images  60 %");
}

TEST(Progress, QuietMeansOffOnATerminalToo) {
    Terminal terminal;
    ASSERT_NE(terminal.Stream(), nullptr);
    Progress progress(terminal.Stream(), true);
    progress.ShowStep("x");
    progress.PrintAboveProgress("above\n");
    EXPECT_EQ(terminal.Shown(), "above\n");
}

// Returns what `show` makes a Progress of this style write to a file.
template <typename Show>
std::string WrittenBy(ProgressStyle style, Show&& show) {
    std::FILE* file = std::tmpfile();
    {
        Progress progress(file, false, style);
        EXPECT_EQ(progress.IsOn(), style != ProgressStyle::None);
        show(progress);
    }
    std::string text(static_cast<size_t>(std::ftell(file)), '\0');
    std::rewind(file);
    text.resize(std::fread(text.data(), 1, text.size(), file));
    std::fclose(file);
    return text;
}

// Shows two runs of 40 samples in less time than the interval between two lines.
void ShowTwoRuns(Progress& progress) {
    progress.ShowLoading("file", 0.0f);
    for (const char* picture : {"  frame 1 of 2", "  frame 2 of 2"}) {
        for (uint32_t i = 1; i <= 40; ++i) {
            ProgressState state{i, 40, 0.0, std::nullopt, std::nullopt};
            if (i > 1) state = {i, 40, 2e6, 0.25, 0.5 * (40 - i)};
            progress.ShowSamples(picture, state);
        }
        progress.Clear();
        const std::filesystem::path files[] = {"a.png", "b.exr"};
        progress.ShowWritten(picture, files);
    }
    progress.ShowStep("  tidying up");
}

TEST(Progress, JsonHasTheFirstAndTheLastStateOfEachRun) {
    EXPECT_EQ(WrittenBy(ProgressStyle::Json, ShowTwoRuns),
              R"({"event":"loading","stage":"file","fraction":0.0}
{"event":"progress","picture":"frame 1 of 2","samples":1,"samples_wanted":40,"samples_per_second":null,"relative_error":null,"seconds_left":null}
{"event":"progress","picture":"frame 1 of 2","samples":40,"samples_wanted":40,"samples_per_second":2000000.0,"relative_error":0.25,"seconds_left":0.0}
{"event":"written","picture":"frame 1 of 2","files":["a.png","b.exr"]}
{"event":"progress","picture":"frame 2 of 2","samples":1,"samples_wanted":40,"samples_per_second":null,"relative_error":null,"seconds_left":null}
{"event":"progress","picture":"frame 2 of 2","samples":40,"samples_wanted":40,"samples_per_second":2000000.0,"relative_error":0.25,"seconds_left":0.0}
{"event":"written","picture":"frame 2 of 2","files":["a.png","b.exr"]}
{"event":"step","step":"tidying up"}
)");
}

TEST(Progress, PlainLinesAreForPeopleWhoReadALog) {
    EXPECT_EQ(WrittenBy(ProgressStyle::Plain, ShowTwoRuns),
              "raygraph: loading file, 0 %\n"
              "raygraph: frame 1 of 2, 1/40 samples\n"
              "raygraph: frame 1 of 2, 40/40 samples, 2 Msamples/s, error 25 %\n"
              "raygraph: frame 2 of 2, 1/40 samples\n"
              "raygraph: frame 2 of 2, 40/40 samples, 2 Msamples/s, error 25 %\n"
              "raygraph: tidying up\n");
    EXPECT_EQ(WrittenBy(ProgressStyle::None, ShowTwoRuns), "");
}

TEST(Progress, TheLastStateOfAStageStandsBeforeTheNext) {
    const auto show = [](Progress& progress) {
        for (const float fraction : {0.25f, 0.5f, 1.0f}) progress.ShowLoading("images", fraction);
        progress.ShowStep("  building");
    };
    EXPECT_EQ(WrittenBy(ProgressStyle::Plain, show),
              "raygraph: loading images, 25 %\nraygraph: loading images, 100 %\nraygraph: building\n");
}

TEST(Progress, JsonIsWrittenOnceASecond) {
    const auto start = std::chrono::steady_clock::now();
    const auto seconds = [&] {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    const std::string text = WrittenBy(ProgressStyle::Json, [&](Progress& progress) {
        for (uint32_t i = 1; seconds() < 1.3; ++i) {
            progress.ShowSamples("", {.samplesDone = i});
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
    });
    const auto count = static_cast<double>(std::ranges::count(text, '\n'));
    EXPECT_GE(count, 3.0) << "the first, one after a second, the last\n" << text;
    EXPECT_LE(count, 2.0 + seconds()) << text;
}

TEST(Progress, JsonIsUtf8WhateverTheNamesAre) {
    const std::string text = WrittenBy(ProgressStyle::Json, [](Progress& progress) {
        const std::filesystem::path files[] = {"a\xff \"b\".png"};
        progress.ShowWritten("", files);
    });
    EXPECT_EQ(text, "{\"event\":\"written\",\"files\":[\"a\xEF\xBF\xBD \\\"b\\\".png\"]}\n");
}

TEST(Progress, RestoringIsAnEventOfItsOwn) {
    EXPECT_EQ(WrittenBy(ProgressStyle::Json,
                        [](Progress& progress) {
                            ProgressState state{.samplesDone = 16};
                            state.samplesRestored = 3;
                            progress.ShowSamples("", state);
                        }),
              "{\"event\":\"restoring\",\"samples\":3,\"samples_wanted\":16}\n");
}

}  // namespace
}  // namespace raygraph::cli::progress_test
