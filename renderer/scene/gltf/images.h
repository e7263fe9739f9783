// The pictures of a glTF file, and the third channel of normal maps that are stored with two. Internal to
// renderer/scene.
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

// Gives normal maps that are stored as x and y alone (BC5, red and green of KTX2), whose blue is 0 in all
// texels, their third channel: z of a unit vector that points up. Their blocks are dropped, except those of
// BC5, to which shaders give it. Images that have another use as well stay as they are. Threads: exclusive
// access to the scene.
void CompleteNormalMaps(SceneData& scene);

}  // namespace raygraph::scene
