#include "tests/support/source_file.h"

namespace raygraph::test {

std::filesystem::path SourceFile(std::string_view name) {
    return std::filesystem::path(EnvironmentOr("RAYGRAPH_SOURCES", RAYGRAPH_SOURCE_DIR)) / name;
}

std::filesystem::path CacheFolder() {
    return RAYGRAPH_TEST_CACHE;
}

}  // namespace raygraph::test
