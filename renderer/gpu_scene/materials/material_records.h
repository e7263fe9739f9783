// Materials as the device reads them. For renderer/gpu_scene alone. Threads: pure functions, for any thread.
#pragma once

#include <span>
#include <vector>

#include "renderer/scene/model/scene_data.h"
#include "shaders/shared/scene_records.h"

namespace raygraph {

// `values` with the texture fields of `textures`.
gpu::MaterialRecord ToRecord(const scene::Material& values, const gpu::MaterialRecord& textures);

// That the material reads, each once, ascending.
std::vector<uint32_t> TexturesOf(const scene::Material& material);

// Of these materials; `slots` are those of the textures that they name, or none if these are not uploaded
// yet.
std::vector<gpu::MaterialRecord> MaterialRecords(std::span<const scene::Material> materials,
                                                 std::span<const uint32_t> slots);

}  // namespace raygraph
