// The tables of shaders/shared/energy_tables.h, for upload and for tests on the CPU. Threads: pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "shaders/shared/energy_tables.h"

namespace raygraph {

// Numbers in [0, 1], in units of 1 / 65535.
using EnergyEntryBits = std::array<uint16_t, kEnergyEntrySize>;

// Returns kEnergyEntryCount entries, which live as long as the program.
std::span<const EnergyEntryBits> EnergyTables();

}  // namespace raygraph
