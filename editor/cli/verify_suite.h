// A list of scenes and pictures for `verify`: verify.json.
#pragma once

#include <filesystem>
#include <vector>

#include "editor/cli/arguments.h"

namespace raygraph::cli {

// Returns the file with the accepted difference of a picture of the case; "": there is no folder for it.
std::filesystem::path AcceptedFile(const VerifyCase& one, const std::filesystem::path& picture);
// Throws Error{Usage} that names both for two pictures with one such file.
void RequireDistinctAccepted(const std::vector<VerifyCase>& cases);

// Reads {"cases": [{"scene": "a.gltf", "pictures": ["a.png"], ...}]}. A case may have `name`, `env`, `root`,
// `mask`, `accepted`, `transfer`, `exposure`, `spp`, `picture_spp`, `against`, `tolerance`
// {"relative": 0.05, ...}, `regions` ["object:PATTERN=X"] and `settings` {"camera": "front", ...}; `defaults`
// beside `cases` has the same keys for all. Paths are relative to the folder of the file; accepted
// differences are in its folder `accepted` by default. Throws Error{BadInput} of one line that names the file
// and the key, or the line that is no JSON.
std::vector<VerifyCase> ReadSuite(const std::filesystem::path& path);

}  // namespace raygraph::cli
