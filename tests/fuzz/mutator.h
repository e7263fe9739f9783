// Changes of inputs as a fuzzer makes them, the same in every run.
#pragma once

#include <random>

#include "tests/fuzz/seeds.h"

namespace raygraph::fuzz {

// A changed copy of one of the inputs, spliced with another now and then. `inputs` must not be empty.
Bytes Mutate(std::span<const Seed> inputs, size_t maxBytes, std::mt19937& random);

}  // namespace raygraph::fuzz
