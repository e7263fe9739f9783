#include "editor/cli/picture_list.h"

#include <algorithm>
#include <cctype>

#include "base/text.h"
#include "editor/cli/arguments.h"

namespace raygraph::cli {

namespace {

constexpr std::string_view kCameraPlace = "{camera}";

}  // namespace

bool HasCameraPlaceholder(const std::filesystem::path& path) {
    return path.filename().string().find(kCameraPlace) != std::string::npos;
}

std::filesystem::path Named(const std::filesystem::path& path, const PictureName& name) {
    const std::filesystem::path numbered = name.number ? Numbered(path, *name.number) : path;
    if (!name.camera) return numbered;
    std::string text = numbered.filename().string();
    for (size_t at = text.find(kCameraPlace); at != text.npos;
         at = text.find(kCameraPlace, at + name.camera->size()))
        text.replace(at, kCameraPlace.size(), *name.camera);
    return numbered.parent_path() / text;
}

std::string CameraFileName(const std::string& camera, size_t index) {
    if (camera.empty() || camera.find_first_of(" ,") != camera.npos) return std::to_string(index);
    std::string text = camera;
    for (char& c : text)
        if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_') c = '_';
    return text;
}

std::vector<PlannedPicture> PicturesToRender(const RenderArguments& arguments) {
    const uint32_t frameCount = arguments.frames ? arguments.frames->Count() : 1;
    const size_t cameraCount = std::max<size_t>(arguments.cameras.size(), 1);
    std::vector<PlannedPicture> pictures;
    pictures.reserve(frameCount * cameraCount);
    for (uint32_t frame = 0; frame < frameCount; ++frame) {
        for (size_t camera = 0; camera < cameraCount; ++camera) {
            PlannedPicture picture;
            if (arguments.frames) {
                picture.name.number = arguments.frames->NumberOf(frame);
                picture.at = arguments.frames->TimeOf(frame);
                picture.label = Text("frame {} of {}", frame + 1, frameCount);
            }
            if (!arguments.cameras.empty()) {
                picture.camera = arguments.cameras[camera];
                picture.name.camera = CameraFileName(*picture.camera, camera);
                picture.label +=
                    Text("{}camera {} of {}", picture.label.empty() ? "" : ", ", camera + 1, cameraCount);
            }
            pictures.push_back(std::move(picture));
        }
    }
    return pictures;
}

}  // namespace raygraph::cli
