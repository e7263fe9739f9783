#include "editor/cli/progress.h"

#include <pty.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <thread>

#include "tests/cli/cli_test.h"

namespace raygraph::cli {
namespace {

TEST(Progress, LineShowsWhatIsKnown) {
    EXPECT_EQ(FormatProgress({128, 256, 1.234e6, 0.0179, 12.2}),
              "  128/256 samples  1.23 Msamples/s  error 1.8 %  12 s left");
    ProgressState restoring{128, 256, 1.234e6, 0.0179, 12.2};
    restoring.samplesRestored = 12;
    EXPECT_EQ(FormatProgress(restoring), "  restoring albedo and normals  12/128 samples");
    EXPECT_EQ(FormatProgress({3, std::nullopt, 0.0, std::nullopt, std::nullopt}), "  3 samples");
}

TEST(Progress, WritesNothingToAFile) {
    std::FILE* file = std::tmpfile();
    ASSERT_NE(file, nullptr);
    {
        Progress progress(file, false);
        EXPECT_FALSE(progress.IsOn());
        EXPECT_FALSE(progress.IsDue());
        progress.Show("x");
    }
    EXPECT_EQ(std::ftell(file), 0);
    std::fclose(file);
}

// A terminal of 40 columns that remembers what was written to it.
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
    // What was written since the last call, as the eye sees it: lines, each with what overwrote it. What has
    // been written comes through in pieces, some of them later: a mark behind it tells that all is here.
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
    progress.PrintAbove("first\n");
    EXPECT_EQ(terminal.Shown(), "first\n") << "there is no line yet";
    progress.Show("  3 samples");
    progress.PrintAbove("second\n");
    progress.PrintAbove("third\n");
    EXPECT_EQ(terminal.Shown(), "second\nthird\n  3 samples");
    progress.Show("  4");
    EXPECT_EQ(terminal.Shown(), "  4") << "nothing is left of the longer one";
    progress.Clear();
    progress.PrintAbove("fourth\n");
    EXPECT_EQ(terminal.Shown(), "fourth\n");
}

TEST(Progress, LineThatIsWiderThanTheTerminalIsCut) {
    Terminal terminal;
    ASSERT_NE(terminal.Stream(), nullptr);
    Progress progress(terminal.Stream(), false);
    progress.Show(std::string(100, 'x'));
    EXPECT_EQ(terminal.Shown(), std::string(39, 'x'));
    progress.PrintAbove("above\n");
    EXPECT_EQ(terminal.Shown(), "above\n" + std::string(39, 'x'));
}

TEST(Progress, IsDueFiveTimesASecondAtMost) {
    Terminal terminal;
    ASSERT_NE(terminal.Stream(), nullptr);
    Progress progress(terminal.Stream(), false);
    EXPECT_TRUE(progress.IsDue());
    const auto since = [](const auto& start) { return std::chrono::steady_clock::now() - start; };
    bool wasInTime = false;
    while (!wasInTime) {  // on a busy machine the answer may come too late to be told from a later one
        const auto start = std::chrono::steady_clock::now();
        progress.Show("x");
        const bool isDue = progress.IsDue();
        wasInTime = since(start) < std::chrono::milliseconds(200);
        EXPECT_FALSE(wasInTime && isDue);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(210));
    EXPECT_TRUE(progress.IsDue());
}

TEST(Progress, QuietMeansOffOnATerminalToo) {
    Terminal terminal;
    ASSERT_NE(terminal.Stream(), nullptr);
    Progress progress(terminal.Stream(), true);
    progress.Show("x");
    progress.PrintAbove("above\n");
    EXPECT_EQ(terminal.Shown(), "above\n");
}

}  // namespace
}  // namespace raygraph::cli
