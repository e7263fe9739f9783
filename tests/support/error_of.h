// The raygraph::Error that a call throws.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "base/error.h"

namespace raygraph::testing {

// Fails the test if the call throws none.
template <typename Call>
Error ErrorOf(Call&& call) {
    try {
        call();
    } catch (const Error& error) {
        return error;
    }
    ADD_FAILURE() << "no Error was thrown";
    return Error(ErrorKind::Usage, "");
}

// Returns the error's text, which must be one line; "accepted" if nothing is thrown. An Error of another kind
// fails the test.
template <typename Call>
std::string ErrorTextOf(Call&& call, ErrorKind kind = ErrorKind::Usage) {
    try {
        call();
    } catch (const Error& error) {
        const std::string text = error.what();
        EXPECT_EQ(static_cast<int>(error.Kind()), static_cast<int>(kind)) << text;
        EXPECT_EQ(text.find('\n'), std::string::npos) << text;
        return text;
    }
    return "accepted";
}

}  // namespace raygraph::testing
