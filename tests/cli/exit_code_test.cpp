// Tests that the exit status of each kind of Error is the documented one.
#include "editor/cli/exit_code.h"

#include <gtest/gtest.h>

namespace raygraph::cli::exit_code_test {
namespace {

TEST(ExitStatus, OfEachKindOfError) {
    const auto status = [](ErrorKind kind) { return static_cast<int>(ExitCodeFor(kind)); };
    EXPECT_EQ(status(ErrorKind::Io), 1);
    EXPECT_EQ(status(ErrorKind::Vulkan), 1);
    EXPECT_EQ(status(ErrorKind::Usage), 2);
    EXPECT_EQ(status(ErrorKind::NoDevice), 3);
    EXPECT_EQ(status(ErrorKind::BadInput), 4);
    EXPECT_EQ(status(ErrorKind::DeviceLost), 5);
    EXPECT_EQ(status(ErrorKind::OutOfMemory), 5);
}

}  // namespace
}  // namespace raygraph::cli::exit_code_test
