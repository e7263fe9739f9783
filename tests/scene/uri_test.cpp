#include "renderer/scene/gltf/container.h"

#include <gtest/gtest.h>

#include "base/printable.h"
#include "tests/scene/gltf_document.h"
#include "tests/support/error_of.h"

namespace raygraph::test::uri_test {
namespace {

std::string Decoded(std::string_view uri) {
    const std::vector<std::byte> bytes = scene::DecodeDataUri(uri, 1000);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string DecodeError(std::string_view uri, uint64_t maxBytes = 1000) {
    return testing::ErrorTextOf([&] { scene::DecodeDataUri(uri, maxBytes); }, ErrorKind::BadInput);
}

TEST(Uri, Base64OfEveryLengthIsDecoded) {
    EXPECT_EQ(Decoded("data:;base64,"), "");
    EXPECT_EQ(Decoded("data:;base64,Zg=="), "f");
    EXPECT_EQ(Decoded("data:;base64,Zm8="), "fo");
    EXPECT_EQ(Decoded("data:;base64,Zm9v"), "foo");
    EXPECT_EQ(Decoded("data:;base64,Zm9vYmFy"), "foobar");
    EXPECT_EQ(Decoded("data:;base64,Zg"), "f") << "padding may be missing";
    EXPECT_EQ(Decoded("DATA:a/b;x=y;BASE64,+/-_"), "\xFB\xFF\xBF");
    EXPECT_EQ(Decoded("data:;base64,Zg%3D%3D"), "f");
}

TEST(Uri, PlainDataIsPercentDecoded) {
    EXPECT_EQ(Decoded("data:text/plain,a%20b%zz"), "a b%zz");
}

TEST(Uri, MalformedDataUrisAreRefused) {
    EXPECT_EQ(DecodeError("data:;base64"), "data URI: it has no comma");
    EXPECT_EQ(DecodeError("data:;base64,Zm9vY"), "data URI: its base64 text is cut short");
    EXPECT_EQ(DecodeError("data:;base64,Zm 9"), "data URI: character 2 of its data is not base64");
    EXPECT_EQ(DecodeError("data:;base64,Z===Zg=="), "data URI: character 1 of its data is not base64");
    EXPECT_EQ(DecodeError("data:;base64,Zm9v", 2), "data URI: 3 bytes exceed the limit of 2");
    EXPECT_EQ(DecodeError("data:,abc", 2), "data URI: 3 bytes exceed the limit of 2");
}

TEST(Uri, SchemesAreTold) {
    EXPECT_EQ(scene::UriScheme("http://x"), "http");
    EXPECT_EQ(scene::UriScheme("a+b-c.d:x"), "a+b-c.d");
    EXPECT_EQ(scene::UriScheme("a/b:c"), std::nullopt);
    EXPECT_EQ(scene::UriScheme("1a:b"), std::nullopt);
    EXPECT_EQ(scene::UriScheme(""), std::nullopt);
    EXPECT_TRUE(scene::IsDataUri("data:,"));
    EXPECT_FALSE(scene::IsDataUri("database.bin"));
}

TEST(Uri, PercentAtTheEndStays) {
    EXPECT_EQ(scene::PercentDecode("a%"), "a%");
    EXPECT_EQ(scene::PercentDecode("a%4"), "a%4");
    EXPECT_EQ(scene::PercentDecode("a%41"), "aA");
}

TEST(Text, PrintableKeepsUtf8AndHidesTheRest) {
    EXPECT_EQ(Printable("gr\xC3\xBC\xC3\x9F \xF0\x9F\x98\x80"), "gr\xC3\xBC\xC3\x9F \xF0\x9F\x98\x80");
    EXPECT_EQ(Printable("a\tb\r\nc\x7F"), "a?b??c?");
    EXPECT_EQ(Printable("\xC2\x9B"
                        "31m"),
              "?31m")
        << "a C1 control starts an escape sequence too";
    EXPECT_EQ(Printable("\xC0\xAF\xED\xA0\x80\xF5"), "??????");
    // The last code point before the surrogates, and the first one after them
    EXPECT_EQ(Printable("\xED\x9F\xBF\xED\xBF\xBF\xEE\x80\x80"), "\xED\x9F\xBF???\xEE\x80\x80");
    EXPECT_EQ(Printable("\xE2\x82"), "??");
    EXPECT_EQ(Printable("abcdef", 3), "abc...");
    EXPECT_EQ(Printable("ab\xC3\xBC", 3), "ab...") << "never half a character";
}

}  // namespace
}  // namespace raygraph::test::uri_test
