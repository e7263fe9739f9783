// Materials as the device reads them. For renderer/gpu_scene alone. Threads: pure functions.
#pragma once

#include <span>
#include <vector>

#include "renderer/scene/model/scene_data.h"
#include "shaders/shared/scene_records.h"

namespace raygraph {

// Returns `values` as a record with the texture fields of `textures`.
gpu::MaterialRecord ToRecord(const scene::Material& values, const gpu::MaterialRecord& textures);

// Returns the textures that the material reads, each once, ascending.
std::vector<uint32_t> TexturesOf(const scene::Material& material);

// Returns the records of these materials. `slots` are those of the textures that they name; it is empty if
// these have not been uploaded.
std::vector<gpu::MaterialRecord> MaterialRecords(std::span<const scene::Material> materials,
                                                 std::span<const uint32_t> slots);

}  // namespace raygraph
