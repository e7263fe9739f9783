// The pictures of one `render`: for each frame, and each camera. Which files they are written to.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace raygraph::cli {

struct RenderArguments;

// What replaces the places in a file's name, of its last part.
struct PictureName {
    std::optional<int64_t> number;      // the run of '#'
    std::optional<std::string> camera;  // {camera}
};

// The name with them in their places. What is not given leaves its place as it is.
std::filesystem::path Named(const std::filesystem::path& path, const PictureName& name);

// Whether there is a place for the camera.
bool HasCameraPlace(const std::filesystem::path& path);

// A camera as it is in names of files: its text where that is a name or an index, with '_' for what is no
// letter, digit, '-' or '_'; its number in the list where it is ten numbers.
std::string CameraInNames(const std::string& camera, size_t index);

struct PlannedPicture {
    PictureName name;
    std::optional<double> at;           // of the frame; none: the settings'
    std::optional<std::string> camera;  // none: the settings'
    std::string label;                  // "frame 2 of 10, camera top"; "": there is one picture
};

// At least one. Frame by frame, and in each camera by camera.
std::vector<PlannedPicture> PicturesToRender(const RenderArguments& arguments);

}  // namespace raygraph::cli
