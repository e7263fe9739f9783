// A scene by its file: which one was read, and whether that is still what is in it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "base/log.h"
#include "renderer/scene/round_primitives.h"
#include "renderer/scene/scene_data.h"

namespace raygraph::editor {

// Detects that a file has been written since it was read.
struct FileStamp {
    std::filesystem::file_time_type time;
    uintmax_t bytes = 0;
    bool operator==(const FileStamp&) const = default;
};
std::optional<FileStamp> StampOf(const std::filesystem::path& file);  // nothing: it cannot be asked

// What a picture that was saved of a scene is resumed with.
struct FileContent {
    std::filesystem::path file;  // "": there is none, or the scene differs from what is in it
    std::filesystem::path root;  // as of scene::LoadOptions
    std::optional<FileStamp> stamp;
    uint32_t variant = scene::kNone;            // in which it is shown
    std::string hash;                           // of what is in it, so shown (session::HashOf); "": not known
    scene::PointsAndLines pointsAndLines = {};  // radii of what is in it
};
// With the hash, for which the file is read if it is not known; "": the file has been written since, or
// cannot be read. Threads: any.
FileContent WithHash(FileContent content, const Log& log = {});

}  // namespace raygraph::editor
