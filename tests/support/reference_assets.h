// The folder of the reference assets, which are no part of the source tree: RAYGRAPH_ASSETS of the
// environment.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>

namespace raygraph::test {

// Returns nothing if the variable is not set or empty.
inline std::optional<std::filesystem::path> ReferenceAssets() {
    const char* folder = std::getenv("RAYGRAPH_ASSETS");
    if (folder == nullptr || *folder == '\0') return std::nullopt;
    return std::filesystem::path(folder);
}

}  // namespace raygraph::test

// Call it at the start of a test, or of a fixture's SetUp.
#define RAYGRAPH_SKIP_WITHOUT_ASSETS() \
    if (!raygraph::test::ReferenceAssets()) GTEST_SKIP() << "RAYGRAPH_ASSETS is not set"
// Does so for tests that read scenes: the packed assets have none (tests/runner/pack_tests).
#define RAYGRAPH_SKIP_WITHOUT_ASSET_SCENES()                                           \
    RAYGRAPH_SKIP_WITHOUT_ASSETS();                                                    \
    if (!std::filesystem::is_directory(*raygraph::test::ReferenceAssets() / "scenes")) \
    GTEST_SKIP() << "RAYGRAPH_ASSETS is a folder without scenes"
