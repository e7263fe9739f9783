// Alias tables: a choice by weight in constant time. The slots are gpu::AliasEntry. Threads: pure functions.
#pragma once

#include <span>

#include "shaders/shared/light_records.h"

namespace raygraph {

// Fills one slot for each weight, in linear time (Vose 1991, "A Linear Algorithm for Generating Random
// Numbers with a Given Distribution"). Weights are finite and not negative. An outcome with a weight of 0 is
// never chosen, unless all weights are 0: then every slot chooses itself with probability 0. Returns the sum
// of the weights.
double BuildAliasTable(std::span<const double> weights, std::span<gpu::AliasEntry> slots);

}  // namespace raygraph
