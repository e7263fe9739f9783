// Tests --frames: times, numbers and names.
#include "editor/cli/picture_list.h"

#include "tests/cli/cli_test.h"

namespace raygraph::cli::frame_range_test {
namespace {

using test::ExpectError;

TEST(FrameRange, TimesFromTheFirstToTheLast) {
    const FrameRange range = ParseFrames("0.5:2:0.25");
    ASSERT_EQ(range.Count(), 7u);
    EXPECT_EQ(range.TimeOf(0), 0.5);
    EXPECT_EQ(range.TimeOf(6), 2.0);
    EXPECT_EQ(ParseFrames("0:1:0.1").Count(), 11u) << "ten tenths are one, but for rounding";
    EXPECT_EQ(ParseFrames("0:1:0.3").Count(), 4u);
    EXPECT_EQ(ParseFrames("2:2:1").Count(), 1u);
    EXPECT_EQ(ParseFrames("-1:1:1").Count(), 3u);
}

TEST(FrameRange, PartsOfASequenceHaveItsNumbers) {
    const FrameRange whole = ParseFrames("0:9.96:0.04"), part = ParseFrames("4:5.96:0.04");
    for (uint32_t i = 0; i < part.Count(); ++i) {
        EXPECT_EQ(part.NumberOf(i), 100 + i);
        EXPECT_EQ(part.TimeOf(i), whole.TimeOf(100 + i));
    }
}

TEST(FrameRange, WhatIsNoneIsRefused) {
    for (const char* text :
         {"", "1", "0:1", "0:1:", "a:1:1", "0:1:0", "0:1:-1", "1:0:1", "0:1:1:1", "0:1e6:1e-3", "0:nan:1"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseFrames(text); }, "");
    ExpectError(
        ErrorKind::Usage, [] { ParseFrames("2:1:0.5"); }, "\"2:1:0.5\" ends before it begins");
    ExpectError(
        ErrorKind::Usage, [] { ParseFrames("0:1000:0.001"); }, "has more than 100000 frames");
}

TEST(FrameRange, NamesHaveThePlaceOfANumber) {
    EXPECT_TRUE(HasNumberPlaceholder("a/b.####.exr"));
    EXPECT_TRUE(HasNumberPlaceholder("#.png"));
    EXPECT_FALSE(HasNumberPlaceholder("a/b.exr"));
    EXPECT_FALSE(HasNumberPlaceholder("a##/b.exr")) << "in the folder's name";
    EXPECT_FALSE(HasNumberPlaceholder("a#b#.exr"));
    EXPECT_EQ(Numbered("a/b.####.exr", 7), "a/b.0007.exr");
    EXPECT_EQ(Numbered("####.exr", 12345), "12345.exr");
    EXPECT_EQ(Numbered("x##/#", 3), "x##/3");
    EXPECT_EQ(Numbered("", 3), "") << "no file stays none";
    EXPECT_EQ(Numbered("a.####.exr", -2), "a.-002.exr");
}

}  // namespace
}  // namespace raygraph::cli::frame_range_test
