#include "editor/cli/edit_picture.h"

#include <charconv>
#include <utility>

#include "editor/cli/version.h"

namespace raygraph::cli {

namespace {

// With the digits of a float where that is the number.
std::string NumberText(double value) {
    if (static_cast<double>(static_cast<float>(value)) == value) return ToText(static_cast<float>(value));
    char digits[32];
    return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

// "eye target up fov" or "eye target up HEIGHTm", which reads back as the same view but for rounding.
std::string CameraText(const scene::CameraView& view) {
    std::string text;
    for (const glm::dvec3& place : {view.eye, view.eye + glm::dvec3(view.forward), glm::dvec3(view.up)})
        for (int i = 0; i < 3; i++) text.append(NumberText(place[i])).append(1, ' ');
    if (view.projection == scene::Projection::Orthographic)
        return text.append(ToText(view.height)).append("m");
    return text.append(ToText(glm::degrees(view.yFov)));
}

}  // namespace

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
