// The raygraph::Error that a call throws.
#pragma once

#include <gtest/gtest.h>

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

}  // namespace raygraph::testing
