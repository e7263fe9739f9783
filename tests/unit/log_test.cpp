#include "base/log.h"

#include <gtest/gtest.h>

#include <vector>

#include <fmt/format.h>

#include "base/text.h"

namespace raygraph::log_test {
namespace {

TEST(Log, MessagesBelowItsLevelAreNotMade) {
    for (const LogLevel least :
         {LogLevel::Debug, LogLevel::Info, LogLevel::Warning, LogLevel::Error, LogLevel::Off}) {
        std::vector<LogLevel> sent;
        const Log log([&](const LogMessage& message) { sent.push_back(message.level); }, least);
        for (const LogLevel level : {LogLevel::Debug, LogLevel::Info, LogLevel::Warning, LogLevel::Error}) {
            EXPECT_EQ(log.IsEnabled(level), level >= least);
            log.Send(level, log_category::kScene, "text");
        }
        EXPECT_FALSE(log.IsEnabled(LogLevel::Off)) << "it is a threshold, and no message's level";
        log.Send(LogLevel::Off, log_category::kScene, "text");
        EXPECT_EQ(sent.size(), size_t(LogLevel::Off) - size_t(least)) << Name(least);
        for (const LogLevel level : sent) EXPECT_GE(level, least);
    }
}

TEST(Log, WithoutACallbackNobodyListens) {
    for (const Log& log : {Log(), Log(Log::Callback(), LogLevel::Debug)}) {
        EXPECT_FALSE(log.IsEnabled(LogLevel::Error));
        log.Send(LogLevel::Error, log_category::kScene, "nobody hears it");
        EXPECT_FALSE(log.IsEnabled(LogLevel::Off));
        log.Send(LogLevel::Off, log_category::kScene, "nor this");
    }
}

TEST(Log, WhatTheCallbackThrowsIsDropped) {
    int calls = 0;
    const Log log(
        [&](const LogMessage&) {
            ++calls;
            throw 17;  // not even an exception
        },
        LogLevel::Info);
    EXPECT_NO_THROW(log.Send(LogLevel::Info, log_category::kScene, "text"));
    EXPECT_NO_THROW(Say(log, LogLevel::Info, log_category::kScene, "number {}", 3));
    EXPECT_EQ(calls, 2);
}

struct Counted {
    int& formatted;
};

}  // namespace
}  // namespace raygraph::log_test

template <>
struct fmt::formatter<raygraph::log_test::Counted> : fmt::formatter<int> {
    auto format(const raygraph::log_test::Counted& value, fmt::format_context& context) const {
        return fmt::formatter<int>::format(++value.formatted, context);
    }
};

namespace raygraph::log_test {
namespace {

TEST(Log, TextsAreFormattedOnlyForWhoListens) {
    std::string heard;
    const Log log(
        [&](const LogMessage& message) {
            heard += std::string(message.category) + ": " + std::string(message.text);
        },
        LogLevel::Info);
    int formatted = 0;
    Say(log, LogLevel::Debug, log_category::kCache, "{}", Counted{formatted});
    EXPECT_EQ(formatted, 0);
    Say(log, LogLevel::Info, log_category::kCache, "number {}", Counted{formatted});
    EXPECT_EQ(heard, "cache: number 1");
}

TEST(Text, ErrorsHaveKindAndFormattedText) {
    const Error error = MakeError(ErrorKind::BadInput, "{}: {} of {}", "a.glb", 3, 2u);
    EXPECT_EQ(error.Kind(), ErrorKind::BadInput);
    EXPECT_STREQ(error.what(), "a.glb: 3 of 2");
}

TEST(Text, BytesHaveUnits) {
    EXPECT_EQ(BytesText(0), "0 B");
    EXPECT_EQ(BytesText(512), "512 B");
    EXPECT_EQ(BytesText(1536), "1.5 KiB");
    EXPECT_EQ(BytesText(uint64_t{24} << 20), "24 MiB");
    EXPECT_EQ(BytesText(uint64_t{3} << 40), "3 TiB");
}

TEST(Text, DurationsHaveUnits) {
    EXPECT_EQ(DurationText(0.00042), "0.4 ms");
    EXPECT_EQ(DurationText(0.0123), "12 ms");
    EXPECT_EQ(DurationText(1.26), "1.3 s");
    EXPECT_EQ(DurationText(59.4), "59 s");
    EXPECT_EQ(DurationText(59.6), "1 min 0 s");
    EXPECT_EQ(DurationText(200.0), "3 min 20 s");
    EXPECT_EQ(DurationText(3723), "1 h 2 min");
}

}  // namespace
}  // namespace raygraph::log_test
