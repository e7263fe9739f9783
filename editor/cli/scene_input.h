// The input files of a picture, loaded and hashed.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "base/log.h"
#include "renderer/image/image.h"
#include "renderer/scene/scene_data.h"

namespace raygraph::cli {

struct SceneInput {
    scene::SceneData data;
    scene::SceneStatistics statistics;
    std::string file;             // name without folders
    std::string hash;             // of `data`
    image::ImageF environment;    // empty: none
    std::string environmentFile;  // "": none
    std::string environmentHash;
    double loadMs = 0.0;  // reading and decoding, both files
};

using LoadProgress = std::function<void(std::string_view stage, float fraction)>;

// `choice`: which of the file's scenes, "" the default. `environment` may be "". Error{BadInput} naming the
// file, also for one that cannot be read; Error{Usage} for a scene that is not in it. Warnings go to `log`.
SceneInput LoadInput(const std::filesystem::path& path, const std::string& choice,
                     const std::filesystem::path& environment, const Log& log, LoadProgress progress = {});

}  // namespace raygraph::cli
