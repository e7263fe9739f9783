#include "editor/session/file/sample_ranges.h"

#include "tests/cli/cli_test.h"

namespace raygraph::session::sample_ranges_test {

TEST(SampleRanges, TextReadsBack) {
    const SampleRanges ranges{{0, 64}, {128, 1}, {200, 0xFFFFFFFFu - 199}};
    EXPECT_EQ(ToText(ranges), "0-63 128-128 200-4294967295");
    EXPECT_EQ(ParseSampleRanges(ToText(ranges)), ranges);
    EXPECT_EQ(SampleCount(ranges), 65u + 0xFFFFFFFFull - 199);
}

TEST(SampleRanges, MalformedTextIsBadInput) {
    for (const char* text : {"", "-", "5", "5-", "-5", "5-4", "0-3 2-5", "4-5 0-1", "0-1  2-3", "0-1 ", "a-b",
                             "0-4294967295", "0-4294967296"})
        test::ExpectError(
            ErrorKind::BadInput, [&] { ParseSampleRanges(text); }, "sample ranges");
}

TEST(SampleRanges, NeighborsDoNotOverlapAndAreJoined) {
    const SampleRanges a{{0, 10}}, b{{10, 5}}, c{{20, 5}};
    EXPECT_FALSE(Overlap(a, b));
    EXPECT_EQ(Union(b, a), (SampleRanges{{0, 15}}));
    EXPECT_EQ(Union(c, a), (SampleRanges{{0, 10}, {20, 5}}));
    EXPECT_EQ(Union(Union(c, a), {{10, 10}}), (SampleRanges{{0, 25}}));
}

TEST(SampleRanges, OneSharedSampleIsAnOverlap) {
    EXPECT_TRUE(Overlap({{0, 10}}, {{9, 5}}));
    EXPECT_TRUE(Overlap({{9, 5}}, {{0, 10}}));
    EXPECT_TRUE(Overlap({{0, 100}}, {{200, 5}, {50, 1}}));
    EXPECT_FALSE(Overlap({{0, 10}, {20, 10}}, {{10, 10}, {30, 10}}));
}

}  // namespace raygraph::session::sample_ranges_test
