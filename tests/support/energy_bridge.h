// The bridge of bxdf/energy.glsl on the CPU: include it before the shading text that asks for it.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>

#include "renderer/gpu_scene/materials/energy_tables.h"

namespace raygraph::shading {

inline glm::uvec4 EnergyEntryAt(glm::uint index) {
    static const std::span<const EnergyEntryBits> kTables = EnergyTables();
    const EnergyEntryBits& entry = kTables[static_cast<size_t>(index)];
    const auto word = [&](size_t i) {
        return glm::uint{entry[2 * i]} | (glm::uint{entry[2 * i + 1]} << 16u);
    };
    return {word(0), word(1), word(2), word(3)};
}

}  // namespace raygraph::shading
