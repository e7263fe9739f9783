// Alias tables: a choice by weight in constant time. The slots' meaning is that of gpu::AliasEntry.
#pragma once

#include <span>

#include "shaders/shared/light_records.h"

namespace raygraph {

// Fills one slot for each weight, in linear time (Vose 1991, "A Linear Algorithm for Generating Random
// Numbers with a Given Distribution"). Weights are finite and not negative. A weight of 0 is never chosen,
// unless all are 0: then every slot stays itself and has probability 0. Returns the sum of the weights.
double BuildAliasTable(std::span<const double> weights, std::span<gpu::AliasEntry> slots);

}  // namespace raygraph
