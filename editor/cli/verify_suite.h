// A list of scenes and pictures for `verify`: verify.json.
#pragma once

#include <filesystem>
#include <vector>

#include "editor/cli/arguments.h"

namespace raygraph::cli {

// Reads {"cases": [{"scene": "a.gltf", "pictures": ["a.png"], ...}]}. A case may have `name`, `env`, `root`,
// `mask`, `accepted`, `transfer`, `exposure`, `spp`, `against`, `tolerance` {"relative": 0.05, ...},
// `regions` ["object:PATTERN=X"] and `settings` {"camera": "front", ...}; `defaults` beside `cases` has the
// same keys for all. Paths are relative to the folder of the file; accepted differences are in its folder
// `accepted` by default. Throws Error{BadInput} of one line that names the file and the key.
std::vector<VerifyCase> ReadSuite(const std::filesystem::path& path);

}  // namespace raygraph::cli
