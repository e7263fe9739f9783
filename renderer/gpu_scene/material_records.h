// Materials as the device reads them. For renderer/gpu_scene alone. Threads: pure functions, for any thread.
#pragma once

#include <span>
#include <vector>

#include "renderer/gpu_scene/scene_resources.h"

namespace raygraph {

// `values` with the texture fields of `textures`.
gpu::MaterialRecord ToRecord(const scene::Material& values, const gpu::MaterialRecord& textures);

// Of all materials of a scene; `textures` are those of its textures, or none if they are not uploaded yet.
std::vector<gpu::MaterialRecord> MaterialRecords(std::span<const scene::Material> materials,
                                                 std::span<const TextureResources> textures);

}  // namespace raygraph
