// A glTF file again, with some of its values changed: what an editor saves. Threads: any, also several at
// once for different targets.
#pragma once

#include <filesystem>

#include "base/api.h"
#include "renderer/scene/load_gltf.h"
#include "renderer/scene/scene_data.h"

namespace raygraph::scene {

// Writes the scene file `source` to `target` with the values of `edited`: what LoadGltf made of `source` by
// the same options, and has been edited since. Of it, the local transforms of the nodes, the materials'
// numbers and flags, and the lights are looked at; vertices and texels may be missing. What has not been
// edited stays as the file has it: its JSON values in their order, extensions and extras that nothing here
// knows, buffers and images. Loaded again, `target` gives the scene of `edited`: values bit for bit, edited
// rotations and scales to rounding. Saved twice, it is the same bytes.
//
// The target's extension says what is written, .glb or .gltf. The BIN chunk of a .glb that becomes a .gltf is
// put beside it as NAME.bin. Files that the scene names are copied into the target's folder, as far as they
// are not there; one of the same name and other content is never overwritten. All files appear whole or not
// at all, the scene file last.
//
// A light that several nodes share and that only some of them have edited becomes two, a default material
// that was edited becomes one of the file's.
//
// Throws raygraph::Error, one line each:
//   Io        a file cannot be read or written, or the target's folder has another file of a name;
//   BadInput  `source` cannot be loaded (any more), or is not what `edited` was made of;
//   Usage     the target's extension is neither, `options.scene` does not exist, or something else than the
//             above was edited.
RAYGRAPH_API void SaveGltf(const std::filesystem::path& source, const SceneData& edited,
                           const std::filesystem::path& target, const LoadOptions& options = {});

}  // namespace raygraph::scene
