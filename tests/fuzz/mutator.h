// Mutates inputs as a fuzzer does, equally in every run.
#pragma once

#include <random>

#include "tests/fuzz/seeds.h"

namespace raygraph::fuzz {

// Returns a mutated copy of one of the inputs, sometimes spliced with another. `inputs` must not be empty.
Bytes Mutate(std::span<const Seed> inputs, size_t maxBytes, std::mt19937& random);

}  // namespace raygraph::fuzz
