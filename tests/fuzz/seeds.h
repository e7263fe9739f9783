// Provides the inputs from which fuzzing starts: small and valid, from the project's scenes and writers.
#pragma once

#include <string>
#include <vector>

#include "tests/fuzz/target.h"

namespace raygraph::fuzz {

struct Seed {
    std::string name;
    Bytes bytes;
};

// Returns the seeds of a target, each at most Target::maxBytes long. If RAYGRAPH_ASSETS is set, `withAssets`
// adds the malformed files of that folder.
std::vector<Seed> Seeds(const Target& target, bool withAssets);

// Return the seeds by subject.
std::vector<Seed> GltfSeeds(std::string_view target);
std::vector<Seed> CompressedSeeds();
std::vector<Seed> ImageSeeds();
std::vector<Seed> EnvironmentSeeds();
std::vector<Seed> RenderFileSeeds();
std::vector<Seed> ProfileSeeds();
std::vector<Seed> ScriptSeeds();
std::vector<Seed> SettingsSeeds();
std::vector<Seed> TextSeeds();
std::vector<Seed> GraphFileSeeds();

}  // namespace raygraph::fuzz
