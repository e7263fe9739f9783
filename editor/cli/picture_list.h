// Lists the pictures of one `render`, one per frame and camera, with the files to which they are written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace raygraph::cli {

struct RenderArguments;

// Holds the values for the placeholders in the last part of a file's name.
struct PictureName {
    std::optional<int64_t> number;      // for the run of '#'
    std::optional<std::string> camera;  // for {camera}
};

// Fills in the placeholders. Those without a value are left as they are.
std::filesystem::path Named(const std::filesystem::path& path, const PictureName& name);

// Returns whether the name has a placeholder for the camera.
bool HasCameraPlaceholder(const std::filesystem::path& path);

// Returns the camera for names of files. A name or an index is used as text, with '_' for each character
// other than letters, digits, '-' and '_'; a camera of ten numbers is named by its index in the list.
std::string CameraFileName(const std::string& camera, size_t index);

struct PlannedPicture {
    PictureName name;
    std::optional<double> at;           // time of the frame; none: the settings' time
    std::optional<std::string> camera;  // none: the settings' camera
    std::string label;                  // e.g. "frame 2 of 10, camera top"; "": the only picture
};

// Returns at least one picture, ordered by frame and then by camera.
std::vector<PlannedPicture> PicturesToRender(const RenderArguments& arguments);

}  // namespace raygraph::cli
