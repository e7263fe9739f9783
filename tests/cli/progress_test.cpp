#include "editor/cli/progress.h"

#include "tests/cli/cli_test.h"

namespace raygraph::cli {
namespace {

TEST(Progress, LineShowsWhatIsKnown) {
    EXPECT_EQ(FormatProgress({128, 256, 1.234e6, 0.0179, 12.2}),
              "  128/256 samples  1.23 Msamples/s  error 1.8 %  12 s left");
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

}  // namespace
}  // namespace raygraph::cli
