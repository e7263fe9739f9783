// The text of the Error{Usage} that a call throws.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "base/error.h"

namespace raygraph::rhi {

// "accepted" when it throws none; an Error of another kind fails the test.
template <typename Call>
std::string UsageErrorOf(Call&& call) {
    try {
        call();
    } catch (const Error& error) {
        EXPECT_EQ(error.Kind(), ErrorKind::Usage);
        return error.what();
    }
    return "accepted";
}

}  // namespace raygraph::rhi
