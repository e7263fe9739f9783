// SceneInput is what a picture is rendered of: a scene and an environment. Resuming and merging compare their
// hashes. Threads: plain values and functions of files, for any thread.
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
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::session {

// Describes an animation of the scene's file.
struct AnimationLength {
    std::string name;
    float seconds = 0.0f;
};

struct SceneInput {
    scene::SceneData data;
    scene::SceneStatistics statistics;
    std::string file;     // file name without folders
    std::string scene;    // requested scene of the file, by name or index; "": the default
    std::string variant;  // active variant, as requested; "": none
    // If true, `data` has its animations, skins and morph targets, to be shown at times. If false, it has
    // none, and a file's scene is in its rest pose.
    bool isAnimated = false;
    std::vector<AnimationLength> animations;  // animations in the file
    scene::PointsAndLines pointsAndLines;     // radii of the file's points and lines; off for a host's scene
    std::string hash;                         // hash of `data` before it was posed
    image::ImageF environment;                // empty: none but the one in `data`
    std::string environmentFile;              // "": none
    std::string environmentHash;
    double loadMs = 0.0;  // duration of reading and decoding both files
};

struct PictureSettings;

struct InputOptions {
    // Selects a scene of the file by name or index; "": the default. It must be the scene in the picture's
    // settings: an input with another one is refused when it is rendered.
    std::string scene;
    // Variant of the materials, by name or index; "": none. It must equal that of the settings.
    std::string variant;
    bool isAnimated = false;  // loads animations, for settings with a time
    std::string clips;        // animations to be shown (scene::FindClips); a missing one is refused early
    scene::PointsAndLines pointsAndLines =
        {};                             // radii of the file's; off: left out; must equal the settings', too
    std::filesystem::path root = {};    // scene::LoadOptions::root
    std::filesystem::path environment;  // equirectangular .hdr or .exr; "": none
    Log log;                            // receives warnings
    // Is called on the loading thread, with `fraction` from 0 to 1.
    std::function<void(std::string_view stage, float fraction)> progress;
};

// Returns the options for a picture with these settings. What is no setting is left to the caller: root,
// environment, log and progress.
RAYGRAPH_API InputOptions InputOptionsFor(const PictureSettings& settings);

// Throws SettingError of kind BadInput unless the root is a folder, or "" for none. The reader of a scene
// would name the root, but not the setting.
RAYGRAPH_API void RequireRoot(const std::filesystem::path& root);

// Throws Error{BadInput} that names the file, also if it cannot be read; Error{Usage} for a missing scene;
// SettingError of kind BadInput as RequireRoot does, and for a missing variant or animation.
RAYGRAPH_API SceneInput LoadInput(const std::filesystem::path& path, const InputOptions& options = {});

// Takes a scene made by the host, with the variant that it chose (scene::SetVariant): the one in the
// picture's settings, in the form of scene::VariantText. Files store `name` as the name of the scene's file.
RAYGRAPH_API SceneInput MakeInput(scene::SceneData data, std::string name);

// Replaces the scene's environment by a map: one in a file, as LoadInput reads it, or one made by the host;
// files store `name` as the name of the map's file. Throws Error{BadInput} that names the file, also if it
// cannot be read; Error{Usage} for an empty name, or a map without pixels or with a wrong number of them.
// Then nothing changes.
RAYGRAPH_API void LoadEnvironment(SceneInput& input, const std::filesystem::path& path, const Log& log = {});
RAYGRAPH_API void SetEnvironment(SceneInput& input, image::ImageF map, std::string name);

}  // namespace raygraph::session
