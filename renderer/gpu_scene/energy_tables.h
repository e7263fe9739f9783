// The tables of shaders/shared/energy_tables.h as floats, for upload and for tests on the CPU.
#pragma once

#include <span>

namespace raygraph {

// kEnergyTableSize floats; they live as long as the program. Any thread.
std::span<const float> EnergyTables();

}  // namespace raygraph
