// Identifies a scene by its file: which one was read, and whether the file still has that content.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "base/log.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::editor {

// Detects that a file has been written since it was read.
struct FileStamp {
    std::filesystem::file_time_type time;
    uintmax_t bytes = 0;
    bool operator==(const FileStamp&) const = default;
};
std::optional<FileStamp> StampOf(const std::filesystem::path& file);  // nothing: the file cannot be queried

// A saved picture is resumed with this scene.
struct FileContent {
    std::filesystem::path file;  // "": there is none, or the scene differs from it
    std::filesystem::path root;  // see scene::LoadOptions
    std::optional<FileStamp> stamp;
    uint32_t variant = scene::kNone;  // the one that is shown
    std::string hash;                 // session::HashOf the file's scene in this variant; "": unknown
    scene::PointsAndLines pointsAndLines = {};  // radii for the file's points and lines
};
// Fills in the hash; if it is unknown, the file is read. The hash is "" if the file was written since, or
// cannot be read. Threads: any.
FileContent WithHash(FileContent content, const Log& log = {});

}  // namespace raygraph::editor
