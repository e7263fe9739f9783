// Small files that tests of writing put, read as texts and count.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include "base/error.h"
#include "tests/support/error_of.h"

namespace raygraph::test {

namespace fs = std::filesystem;

inline void Put(const fs::path& path, std::string_view text) {
    std::ofstream(path) << text;
}

inline std::string TextOf(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

inline size_t FileCount(const fs::path& folder) {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

// The message of the Error{Io} that `write` must end with.
template <typename Write>
std::string IoError(const Write& write) {
    return testing::ErrorTextOf(write, ErrorKind::Io);
}

}  // namespace raygraph::test
