// The pictures of a glTF file. Internal to renderer/scene.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/scene/gltf/accessors.h"
#include "renderer/scene/gltf/context.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Images of the file with the same picture, the best first: the first one that can be read is taken.
using ImageChoice = std::vector<uint32_t>;

// Decodes one of each choice, in that order, on LoadOptions::maxThreads threads. An image in whose place
// another one is taken is a warning, as is what is wrong with a file and takes nothing from its picture. A
// choice of which none can be read fails as its first one does; if it is not `isShown`, that is a warning,
// too, and a white texel takes its place. What comes out does not depend on the number of threads: a failure
// is that of the first choice that has one.
std::vector<ImageData> DecodeImages(GltfContext& context, const std::vector<ImageSource>& sources,
                                    const std::vector<ImageChoice>& choices, const std::vector<bool>& isShown,
                                    GltfBuffers& buffers);

}  // namespace raygraph::scene
