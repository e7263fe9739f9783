// The bridge of bxdf/energy.glsl on the CPU: include it before the shading text that asks for it.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>

#include "renderer/gpu_scene/energy_tables.h"

namespace raygraph::shading {

inline float EnergyTableAt(glm::uint index) {
    static const std::span<const float> kTables = EnergyTables();
    return kTables[static_cast<size_t>(index)];
}

}  // namespace raygraph::shading
