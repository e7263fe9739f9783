#include "editor/cli/edit_picture.h"

#include <utility>

#include "editor/cli/version.h"

namespace raygraph::cli {

using namespace session;  // NOLINT

RenderFile RenderFileOf(editor::SavedRender&& saved) {
    viewport::CaptureResult& picture = saved.picture;
    PictureSettings settings;
    settings.size = {picture.extent.width, picture.extent.height};
    settings.view = picture.isRaster ? View::Raster : View::PathTraced;
    settings.camera = CameraText(picture.camera);
    settings.paths = picture.paths;
    settings.environmentRotation = glm::degrees(picture.environment.rotation);
    const glm::vec3& radiance = picture.environment.radiance;
    (saved.environmentFile.empty() ? settings.background : settings.environmentTint) = {
        radiance.x, radiance.y, radiance.z};

    RenderFile render;
    render.size = settings.size;
    render.radiance = std::move(picture.mean);
    render.variance = std::move(picture.variance);
    render.albedo = std::move(picture.albedo);
    render.normal = std::move(picture.normal);
    render.depth = std::move(picture.depth);
    render.instance = std::move(picture.instance);
    render.material = std::move(picture.material);
    render.samples = {{0, picture.sampleCount}};
    render.settings = Texts(settings);
    render.sceneFile = std::move(saved.sceneFile);
    render.environmentFile = std::move(saved.environmentFile);
    render.version = kVersion;
    render.device = std::move(saved.device);
    render.driver = std::move(saved.driver);
    return render;
}

}  // namespace raygraph::cli
