// What a picture is rendered of: a scene and an environment, with hashes of them, by which resuming and
// merging see that they are still the same. Threads: plain values and functions of files, for any thread.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "base/log.h"
#include "renderer/image/image.h"
#include "renderer/scene/round_primitives.h"
#include "renderer/scene/scene_data.h"

namespace raygraph::session {

// An animation of the scene's file.
struct AnimationLength {
    std::string name;
    float seconds = 0.0f;
};

struct SceneInput {
    scene::SceneData data;
    scene::SceneStatistics statistics;
    std::string file;     // name without folders
    std::string scene;    // which of the file's scenes `data` is, as it was asked for; "": the default
    std::string variant;  // which variant it shows, likewise; "": none
    // `data` has its animations, skins and morph targets, to be shown at times. Otherwise it is as it stands,
    // and that of a file in its rest pose, without any.
    bool isAnimated = false;
    std::vector<AnimationLength> animations;  // of the file
    scene::PointsAndLines pointsAndLines;     // the radii that the file's were given; off of a host's scene
    std::string hash;                         // of `data`, before it was posed
    image::ImageF environment;                // empty: none but the one in `data`
    std::string environmentFile;              // "": none
    std::string environmentHash;
    double loadMs = 0.0;  // reading and decoding, both files
};

struct InputOptions {
    // Which of the file's scenes, by name or index; "": the default. That of the picture's settings: any
    // other is refused when the input is rendered.
    std::string scene;
    std::string variant;      // of materials, by name or index; "": none. Otherwise as `scene`
    bool isAnimated = false;  // keeps animations: for settings with a time of them
    std::string clips;        // which of them are to be shown (scene::FindClips): refused early if not there
    scene::PointsAndLines pointsAndLines = {};  // radii of the file's; off: left out. Otherwise as `scene`
    std::filesystem::path root = {};            // scene::LoadOptions::root
    std::filesystem::path environment;          // equirectangular .hdr or .exr; "": none
    Log log;                                    // takes warnings
    // Called on the loading thread, `fraction` from 0 to 1.
    std::function<void(std::string_view stage, float fraction)> progress;
};

// SettingError of kind BadInput unless the root is "", which is none, or a folder. The reader of a scene
// would name the root, but not the setting.
RAYGRAPH_API void RequireRoot(const std::filesystem::path& root);

// Error{BadInput} naming the file, also for one that cannot be read; Error{Usage} for a scene that is not
// in it; SettingError of kind BadInput for a root as of RequireRoot, or a variant or an animation that the
// scene does not have.
RAYGRAPH_API SceneInput LoadInput(const std::filesystem::path& path, const InputOptions& options = {});

// A scene that a host has made, which shows the variant that it chose (scene::SetVariant): that of the
// picture's settings, as scene::VariantText has it. `name` stands in files for that of a scene's file.
RAYGRAPH_API SceneInput MakeInput(scene::SceneData data, std::string name);

// Lights the scene by a map, instead of the one that it has: one in a file, as LoadInput reads it, or one
// that a host has made; `name` stands in files for that of a map's file. Error{BadInput} naming the file,
// also for one that cannot be read; Error{Usage} for a name that is empty, or a map without pixels or with
// others than its size says. Then nothing changes.
RAYGRAPH_API void LoadEnvironment(SceneInput& input, const std::filesystem::path& path, const Log& log = {});
RAYGRAPH_API void SetEnvironment(SceneInput& input, image::ImageF map, std::string name);

}  // namespace raygraph::session
