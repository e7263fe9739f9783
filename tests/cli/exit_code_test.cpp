// Tests that the exit status of each kind of Error is the one in docs/cli.md.
#include "editor/cli/exit_code.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "tests/support/source_file.h"

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

TEST(ExitStatus, DocsHaveARowForEach) {
    std::ifstream file(test::SourceFile("docs/cli.md"));
    const std::string page{std::istreambuf_iterator<char>(file), {}};
    const std::string title = "| exit status | |\n|---|---|\n";
    const size_t table = page.find(title);
    ASSERT_NE(table, std::string::npos);
    std::istringstream rows(page.substr(table + title.size()));
    std::string row;
    for (const auto& [code, text] : kExitCodes) {
        std::getline(rows, row);
        EXPECT_EQ(row.rfind("| " + std::to_string(static_cast<int>(code)) + " | ", 0), 0u) << row;
    }
    EXPECT_FALSE(std::getline(rows, row) && row.starts_with("|")) << row;
}

}  // namespace
}  // namespace raygraph::cli::exit_code_test
