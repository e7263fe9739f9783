#include "editor/session/settings/parse.h"

#include <cmath>
#include <functional>

#include "base/error.h"
#include "editor/session/file/sample_ranges.h"
#include "editor/session/settings/light_groups.h"
#include "tests/cli/cli_test.h"

namespace raygraph::session::parse_test {

using test::ExpectError;

TEST(Parse, CountIsDigitsAloneAndInRange) {
    EXPECT_EQ(ParseCount("0"), 0u);
    EXPECT_EQ(ParseCount("4294967295"), 4294967295u);
    for (const char* text : {"", " 1", "1 ", "+1", "-1", "1.0", "0x10", "1e3", "4294967296", "64spp"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseCount(text); }, std::string("\"") + text + "\"", "whole number");
    ExpectError(
        ErrorKind::Usage, [] { ParseCount("0", 1, 8); }, "from 1 to 8");
    ExpectError(
        ErrorKind::Usage, [] { ParseCount("9", 1, 8); }, "from 1 to 8");
}

// Such texts may also come from stored renders.
TEST(Parse, RefusalsQuoteTheTextWithoutControlCharacters) {
    for (const auto& parse : {std::function<void()>([] { ParseCount("\x1b[31m"); }),
                              std::function<void()>([] { ParseSampleRanges("0-\x1b[31m"); }),
                              std::function<void()>([] { ParseLightGroups("a\x1b[31m=b"); })}) {
        try {
            parse();
            ADD_FAILURE() << "is read";
        } catch (const Error& error) {
            EXPECT_EQ(std::string(error.what()).find('\x1b'), std::string::npos) << error.what();
        }
    }
}

TEST(Parse, NumberIsFiniteWholeTextAndInRange) {
    EXPECT_EQ(ParseNumber("-1.5"), -1.5);
    EXPECT_EQ(ParseNumber("2e3"), 2000.0);
    for (const char* text : {"", "nan", "inf", "-inf", "1,5", "1.5x", " 1", "1e999"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseNumber(text); }, "is not a number");
    ExpectError(
        ErrorKind::Usage, [] { ParseNumber("-0.1", 0.0); }, "at least 0");
    ExpectError(
        ErrorKind::Usage, [] { ParseNumber("101", -100.0, 100.0); }, "from -100 to 100");
}

TEST(Parse, SizeIsTwoSidesOfAtLeastOnePixel) {
    EXPECT_EQ(ParseSize("640x360"), (Extent2D{640, 360}));
    EXPECT_EQ(ParseSize("1x16384"), (Extent2D{1, 16384}));
    for (const char* text : {"", "x", "640", "640x", "x360", "640X360", "640x360x1", "0x10", "10x0",
                             "640*360", "16385x1", "-1x2", "99999999999x1"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseSize(text); }, "640x360");
}

TEST(Parse, BudgetIsASizeInMemoryOrAutomatic) {
    EXPECT_EQ(ParseBudget("auto"), 0u);
    EXPECT_EQ(ParseBudget("1"), 1u);
    EXPECT_EQ(ParseBudget("64K"), 65536u);
    EXPECT_EQ(ParseBudget("512M"), uint64_t{512} << 20);
    EXPECT_EQ(ParseBudget("1.5G"), uint64_t{1536} << 20);
    for (const char* text :
         {"", "0", "K", "0.5", "-1M", "1T", "1m", "1MB", "2e15", "1048577G", "nan", "Auto"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseBudget(text); }, "is not auto or a size like 512M or 1.5G");
    for (const uint64_t bytes : {0ull, 1ull, 1000ull, 1024ull, 1536ull << 20, 3ull << 30, (3ull << 30) + 1})
        EXPECT_EQ(ParseBudget(BudgetText(bytes)), bytes);
    EXPECT_EQ(BudgetText(uint64_t{1536} << 20), "1536M");
    EXPECT_EQ(BudgetText(0), "auto");
}

TEST(Parse, RadianceIsThreeNumbersThatAreNotNegative) {
    EXPECT_EQ(ParseRadiance("0,0.5,2e1"), (std::array<float, 3>{0.0f, 0.5f, 20.0f}));
    for (const char* text :
         {"", "1", "1,2", "1,2,3,4", "1,,3", "1,2,", "a,b,c", "-1,0,0", "nan,0,0", "1 2 3", "1e39,0,0"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseRadiance(text); }, "three numbers");
}

TEST(Parse, ListHasNoEmptyParts) {
    EXPECT_EQ(ParseList("a,bc"), (std::vector<std::string_view>{"a", "bc"}));
    for (const char* text : {"", ",", "a,", ",a", "a,,b"})
        ExpectError(
            ErrorKind::Usage, [&] { ParseList(text); }, "list");
}

TEST(Parse, ChoiceNamesWhatThereIs) {
    EXPECT_EQ(ParseChoice("pcg", {"sobol", "pcg", "tea"}), 1u);
    ExpectError(
        ErrorKind::Usage,
        [] {
            ParseChoice("Sobol", {"sobol", "pcg", "tea"});
        },
        "\"Sobol\"", "one of sobol, pcg or tea");
}

TEST(Parse, TextOfANumberReadsBackAsTheSameNumber) {
    for (const float value : {0.0f, -1.5f, 0.1f, 1.0f / 3.0f, 3.4e38f, 1.17549435e-38f})
        EXPECT_EQ(static_cast<float>(ParseNumber(ToText(value))), value);
    EXPECT_EQ(ParseSize(ToText(Extent2D{12, 7})), (Extent2D{12, 7}));
    const std::array<float, 3> radiance{0.1f, 7.0f, 1e-20f};
    EXPECT_EQ(ParseRadiance(ToText(radiance)), radiance);
}

}  // namespace raygraph::session::parse_test
