// The extension of a file's name, by which formats are told apart. Threads: any.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>

namespace raygraph {

// Returns the extension with its dot, in lower case: ".png" for "A.PNG"; "" if there is none.
inline std::string LowerExtension(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    std::ranges::transform(extension, extension.begin(),
                           [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    return extension;
}

}  // namespace raygraph
