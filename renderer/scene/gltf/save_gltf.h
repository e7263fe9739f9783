// A glTF file again, with some of its values changed: what an editor saves. Threads: any, also several at
// once for different targets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "base/api.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Describes a file whose picture takes the place of one of the scene's.
struct ReplacedImage {
    uint32_t image = 0;          // index into SceneData::images
    std::filesystem::path file;  // where it was read
    std::span<const std::byte> bytes;

    std::string Name() const { return file.stem().string(); }  // as files name the image
};

// Says where the nodes of an edited scene come from, if some were added or `source` has been written since,
// and which images were replaced.
struct SaveOrigin {
    // The JSON text that `edited` was loaded from; "": that of `source`. A scene that SaveGltf has removed
    // nodes from has other indices than the file that it wrote: who goes on editing keeps this text.
    std::string_view json;
    // By node of `edited` beyond those of that text: the node that it is a copy of, with the extras and
    // extensions of that; kNone: an empty one, with the lights and cameras that `edited` has for it. One that
    // is not in `edited.nodeOrder` is not written.
    std::span<const uint32_t> copiedFrom;
    std::span<const ReplacedImage> images;  // each image at most once
    // The content that `source` had before an image in its BIN chunk was replaced; empty: it still has it.
    std::span<const std::byte> file;
    // Lets `target` need no file outside of its folder: what `source` names there, or by the name of a hidden
    // file, is copied to the target's folder files/.
    bool isSelfContained = false;
};
// Returns the JSON text of a .gltf or .glb file. Throws Error{Io}, Error{BadInput}.
RAYGRAPH_API std::string ReadGltfJson(const std::filesystem::path& source, const LoadOptions& options = {});

// Writes the scene file `source` to `target` with the values of `edited`: what LoadGltf made of `source`, or
// of a file that this wrote from it, by the same options, and has been edited since. Vertices and texels may
// be missing. What has not been edited stays as the file has it: its JSON values in their order, extensions
// and extras that nothing here knows, buffers and images. Loaded again, `target` gives the scene of `edited`
// as far as it is written: values bit for bit, edited rotations and scales to rounding. Saved twice, it is
// the same bytes.
//
// Written, where they differ from the file's: the nodes' names, local transforms and visibility, their
// parents and order; nodes that have come or gone (SaveOrigin); the materials' factors, alpha mode and
// cutoff, flags, ior, volume and priority, but for normalScale and occlusionStrength of a material without
// that texture, which have no place; color, intensity, range and cone angles of the light of a node.
// Refused, as Usage: other textures of materials, types of lights, a skin that would lose a joint; whether a
// material is one of KHR_materials_pbrSpecularGlossiness, and fields that such a material does not have.
// Ignored without a word: all else, as values of cameras, meshes and what nodes place (Node::mesh),
// instances, textures and images, which variant is shown.
//
// A node that is in the file's scene and not in `edited.nodeOrder` is removed, with what is below it, its
// place in lists, and the channels of animations and the unused skins that name it; indices of other nodes
// follow. If the file uses an extension that is not read and may name nodes, the node stays, empty and in no
// scene. What it placed (mesh, light, camera) stays in the file's lists.
//
// An image that was replaced is where it was: in a data URI, in the .glb, or in a file. Such a file keeps its
// path from the target's folder if it is below that, else it is copied there. If another file has its name,
// it gets a number. An image of a buffer becomes a file, unless the target is a .glb with a BIN chunk: there
// it takes the place of the former one's bytes, or comes last if these may have another use. An image that
// has a name, or no file, gets that of the new file.
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
                           const std::filesystem::path& target, const LoadOptions& options = {},
                           const SaveOrigin& origin = {});

}  // namespace raygraph::scene
