// The pictures of a glTF file. Internal to renderer/scene.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/gltf_buffers.h"
#include "renderer/scene/gltf_context.h"
#include "renderer/scene/scene_data.h"

namespace raygraph::scene {

// Decodes those of the file's `sources` that `images` lists, in that order, on LoadOptions::maxThreads
// threads. What comes out does not depend on how many: a failure is that of the first image in the list that
// has one.
std::vector<ImageData> DecodeImages(GltfContext& context, const std::vector<ImageSource>& sources,
                                    const std::vector<uint32_t>& images, GltfBuffers& buffers);

}  // namespace raygraph::scene
