// A glTF file again, with some of its values changed: what an editor saves. Threads: any, also several at
// once for different targets.
#pragma once

#include <filesystem>

#include "base/api.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Writes the scene file `source` to `target` with the values of `edited`: what LoadGltf made of `source`, or
// of a file that this wrote from it, by the same options, and has been edited since. Vertices and texels may
// be missing. What has not been edited stays as the file has it: its JSON values in their order, extensions
// and extras that nothing here knows, buffers and images. Loaded again, `target` gives the scene of `edited`
// as far as it is written: values bit for bit, edited rotations and scales to rounding. Saved twice, it is
// the same bytes.
//
// Written, where they differ from the file's: the nodes' local transforms and visibility; the materials'
// factors, alpha mode and cutoff, flags, ior, volume and priority, but for normalScale and occlusionStrength
// of a material without that texture, which have no place; color, intensity, range and cone angles of the
// light of a node.
// Refused, as Usage: other parents, textures of materials, types of lights; whether a material is one of
// KHR_materials_pbrSpecularGlossiness, and fields that such a material does not have. Ignored without a
// word: all else, as names, cameras, meshes and what nodes place (Node::mesh), instances, textures and
// images, which variant is shown.
//
// The target's extension says what is written, .glb or .gltf. The BIN chunk of a .glb that becomes a .gltf is
// put beside it as NAME.bin. What `buffers` and `images` name is copied into the target's folder, as far as
// it is not there: buffers, images that were read, others that are of a known format. What extensions name
// by a `uri` of their own is not. A file of the same name and other content is never overwritten, and a
// hidden one (".name") never made. Nothing is written outside of the target's folder ("../name"): such a file
// has to exist already. All files appear whole or not at all, the scene file last.
//
// A light that several nodes share and that only some of them have edited becomes two, a default material
// that was edited becomes one of the file's.
//
// Throws raygraph::Error, one line each:
//   Io        a file cannot be read or written, or the target's folder has another file of a name;
//   BadInput  `source` cannot be loaded (any more), is not what `edited` was made of, or names a hidden file
//             or one outside of its folder that would have to be copied;
//   Usage     the target's extension is neither, `options.scene` does not exist, something was edited that
//             is refused, or a material's extras that are no object would have to hold its priority.
RAYGRAPH_API void SaveGltf(const std::filesystem::path& source, const SceneData& edited,
                           const std::filesystem::path& target, const LoadOptions& options = {});

}  // namespace raygraph::scene
