// Tests the program when a Vulkan call fails: one line, the right exit status, and no file.
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <link.h>

#include <algorithm>
#include <cstdlib>

#include "tests/cli/program_runner.h"
#include "tests/support/source_file.h"

namespace raygraph::program_failure_test {
namespace {

// Returns the path of the Vulkan library that this process would load.
std::string SystemVulkan() {
    void* const library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    link_map* map = nullptr;
    if (!library || dlinfo(library, RTLD_DI_LINKMAP, static_cast<void*>(&map)) != 0) return "";
    const std::string file = map->l_name;
    dlclose(library);
    return file;
}

test::ProgramResult RunWithFailure(const test::TemporaryFolder& folder, const std::string& failure,
                                   std::string_view line) {
    std::string folders = test::EnvironmentOr("RAYGRAPH_FAILING_VULKAN", RAYGRAPH_BUILT_FAILING_VULKAN);
    if (const char* others = std::getenv("LD_LIBRARY_PATH")) (folders += ':') += others;
    const test::EnvironmentVariable library("RAYGRAPH_VULKAN_LIBRARY", SystemVulkan());
    const test::EnvironmentVariable fail("RAYGRAPH_FAIL", failure);
    const test::EnvironmentVariable path("LD_LIBRARY_PATH", folders);
    return test::RunProgram(folder, line);
}

class ProgramFailure : public ::testing::TestWithParam<const char*> {};

TEST_P(ProgramFailure, EndsInOneLineAndLeavesNoFile) {
    const test::TemporaryFolder folder;
    const test::ProgramResult result = RunWithFailure(
        folder, GetParam(), "render @cornell.gltf --size 16x16 --spp 2 -o a.exr -o a.png --report a.json");
    EXPECT_EQ(result.exitCode, 5) << result.messages;
    EXPECT_EQ(std::ranges::count(result.messages, '\n'), 1) << result.messages;
    EXPECT_TRUE(result.messages.starts_with("raygraph: ")) << result.messages;
    EXPECT_EQ(result.output, "");
    const bool isLoss = std::string(GetParam()).find("lost") != std::string::npos;
    EXPECT_NE(result.messages.find(isLoss ? "VK_ERROR_DEVICE_LOST" : "VK_ERROR_OUT_OF_DEVICE_MEMORY"),
              std::string::npos)
        << result.messages;
    EXPECT_TRUE(std::filesystem::is_empty(folder.Path()));
}

INSTANTIATE_TEST_SUITE_P(Render, ProgramFailure,
                         ::testing::Values("allocation:4:oom:on", "creation:60:oom", "submission:2:lost",
                                           "wait:5:lost"));

// Otherwise the tests above would prove nothing.
TEST(ProgramFailureLoader, WithoutAFailureItChangesNothing) {
    const test::TemporaryFolder folder;
    const test::ProgramResult result = RunWithFailure(folder, "submission:100000:lost",
                                                      "render @cornell.gltf --size 16x16 --spp 1 -o a.png");
    EXPECT_EQ(result.exitCode, 0) << result.messages;
    EXPECT_TRUE(std::filesystem::exists(folder / "a.png"));
}

}  // namespace
}  // namespace raygraph::program_failure_test
