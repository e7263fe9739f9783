// The file behind what the editor shows: which scene was read and whether the file still has that content,
// and the render that a picture of it is saved as.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "base/log.h"
#include "editor/session/session.h"
#include "editor/viewport/capture.h"
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

// --- A render of a viewport's picture: its .exr is as `render` writes it, and can be resumed ---

// Names what a picture shows, in the terms of a render.
struct ShownScene {
    session::SceneInput input;  // without the data
    std::string camera;         // session::CameraText, of which the picture's view was read
    bool hasGround = false;     // in path-traced pictures
    std::optional<double> at;   // time of the animations; none: the rest pose
    std::string clips;          // the clips in effect, see scene::FindClips
};

// Returns the settings of a render of what the picture shows; its values are not read.
session::PictureSettings SettingsOf(const viewport::CaptureResult& picture, const ShownScene& shown);

// Returns the picture with the settings that reproduce it on the command line, since the camera was moved by
// hand. Albedo and normals are those of the pixels' centers, and have no sums.
session::RenderFile RenderOf(viewport::CaptureResult&& picture, const ShownScene& shown,
                             const rhi::DeviceInfo& device);

}  // namespace raygraph::editor
