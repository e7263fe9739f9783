// Declares what tests of the program share.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "editor/session/file/render_file.h"
#include "tests/support/error_of.h"

namespace raygraph::test {

// Expects an Error of this kind whose one-line message contains all of these texts.
template <typename Run, typename... Texts>
void ExpectError(ErrorKind kind, Run&& run, const Texts&... texts) {
    const Error error = testing::ErrorOf(run);
    const std::string message = error.what();
    EXPECT_EQ(static_cast<int>(error.Kind()), static_cast<int>(kind)) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    for (const std::string& text : {std::string(texts)...})
        EXPECT_NE(message.find(text), std::string::npos) << message << "\n  lacks " << text;
}

// Splits a command line at its spaces; single quotes enclose one word.
std::vector<std::string> Words(std::string_view line);

// Makes a render with every channel, from made-up samples that depend on the pixel and on `salt`.
session::RenderFile MakeRender(uint32_t firstSample, uint32_t sampleCount, float salt = 0.0f);

// Returns the sum of R, G and B over all pixels.
inline double SumOf(const session::Texels& texels) {
    double sum = 0.0;
    for (size_t i = 0; i < texels.size(); ++i)
        if (i % 4 != 3) sum += texels[i];
    return sum;
}

}  // namespace raygraph::test
