// glTF 2.0 files (.gltf with its buffers and images, .glb) to SceneData.
//
// Read: the core, with animations, skins and morph targets, which pose.h and deform.h apply, and the
// extensions that docs/gltf.md lists. Not read: other extensions (one warning each; an error if the file
// requires them), points and lines unless they are given a radius (one warning each). Threads: any, also
// several at once; none of them touches a device.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "base/api.h"
#include "base/log.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/gltf/file_access.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Bounds on what a file may make the process read and allocate. Beyond any of them: Error{BadInput}.
struct LoadLimits {
    uint64_t maxFileBytes = uint64_t{16} << 30;  // the scene file, its buffers and images together
    uint64_t maxJsonBytes = uint64_t{256} << 20;
    uint32_t maxJsonDepth = 64;  // Nested arrays and objects; glTF itself needs about ten.
    // Decoded vertices, indices, keys and joints: this many bytes, plus 64 for each byte of file read; and
    // before them the model of the document: this many, plus 64 for each byte of its JSON. Stops a small
    // file that claims a billion vertices, draws one accessor a million times or lists a million empty
    // materials.
    uint64_t maxGeometryBytes = uint64_t{1} << 30;
    uint32_t maxImageExtent = 16384;              // texels a side
    uint64_t maxImageTexels = uint64_t{1} << 28;  // an image
    // All images; four bytes a texel. Of those that are decoded at once, a quarter of it or one image: a
    // decoder takes up to nine bytes a texel more.
    uint64_t maxAllImageTexels = uint64_t{1} << 31;
};

struct LoadOptions {
    // Chooses one of the file's scenes, by its name or by its index as decimal digits. Empty: the file's
    // default scene, else its first; all root nodes if the file has none.
    std::string scene;
    LoadLimits limits;
    // The radii of points and lines, which become spheres and capsules. By default they are left out.
    PointsAndLines pointsAndLines = {};
    // Called on the loading thread with the current stage and the completed part of the whole, 0 to 1.
    std::function<void(std::string_view stage, float fraction)> progress;
    // The scene may also name files below this folder, as "../textures/wood.png"; "": only those below its
    // own.
    std::filesystem::path root = {};
    FileReader* reader = nullptr;  // nullptr: the disk
    // Images are decoded on so many threads, which end before the call does; 0: as many as there are cores.
    // The scene, or the error, is the same for any number.
    uint32_t maxThreads = 0;
    // Receives warnings, as in SceneData::warnings, the time that loading took, and for debugging the time
    // for each image.
    Log log = {};
};

// Loads a scene. Throws raygraph::Error, one line each:
//   Io           the scene file itself cannot be read, or the root is no folder;
//   BadInput     the file is malformed or hostile, requires an unsupported extension, or uses a file that is
//                missing or outside its folder and the root: "scene.gltf: accessors[3].count: 12 elements
//                exceed bufferViews[1] (64 bytes)";
//   Usage        there is no scene `options.scene`;
//   OutOfMemory  host memory is exhausted.
// Everything is checked before it is decoded. May be called from several threads at once. Peak host memory:
// the file, the external files, the JSON text once more and its tree (up to forty times that, of nothing but
// empty objects), tinygltf's model (LoadLimits::maxGeometryBytes), what decoders take and the returned data.
RAYGRAPH_API SceneData LoadGltf(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace raygraph::scene
