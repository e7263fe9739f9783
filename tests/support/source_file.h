// The files of the source tree that tests read: scenes, shaders, pages of the documentation. And the folder that
// they keep things in.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string_view>

namespace raygraph::test {

// The value of the environment variable, or `otherwise` where it is unset or empty.
inline const char* EnvironmentOr(const char* variable, const char* otherwise) {
    const char* value = std::getenv(variable);
    return value && *value ? value : otherwise;
}

// SourceFile("scenes/cornell.gltf"): in the folder that RAYGRAPH_SOURCES names, so that tests run on machines
// that did not build them, or else in the tree that they were built from.
std::filesystem::path SourceFile(std::string_view name);

// Returns the folder for the pipeline caches of tests' devices. All test programs of a build share it, since
// pipeline compilation takes most of the suite's time on Mesa's CPU driver.
std::filesystem::path CacheFolder();

}  // namespace raygraph::test
