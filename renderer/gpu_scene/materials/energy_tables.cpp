#include "renderer/gpu_scene/materials/energy_tables.h"

#include "base/embed_file.h"

// Little-endian numbers, written by raygraph_bake_energy_tables.
RAYGRAPH_EMBED_FILE(raygraph_energy_tables, __FILE__ ".bin");

namespace raygraph {

std::span<const EnergyEntryBits> EnergyTables() {
    return {reinterpret_cast<const EnergyEntryBits*>(raygraph_energy_tables), kEnergyEntryCount};
}

}  // namespace raygraph
