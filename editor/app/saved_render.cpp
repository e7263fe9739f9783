#include "editor/app/saved_render.h"

#include <utility>

namespace raygraph::editor {

session::RenderFile RenderOf(viewport::CaptureResult&& picture, const ShownScene& shown,
                             const rhi::DeviceInfo& device) {
    session::SceneInput source = shown.input;
    source.isAnimated = shown.at.has_value();
    session::PictureSettings settings;
    settings.size = picture.extent;
    settings.view = picture.isRaster ? session::View::Raster : session::View::PathTraced;
    settings.variant = source.variant;
    settings.at = shown.at;
    if (shown.at) settings.clips = shown.clips;
    settings.pointsAndLines = source.pointsAndLines;
    settings.camera = session::CameraText(picture.camera);
    if (picture.lens.radius > 0.0f) {
        settings.aperture = picture.lens.radius;
        settings.focusDistance = picture.lens.focusDistance;
    }
    settings.paths = picture.paths;
    settings.raster = picture.raster;
    settings.environmentRotation = glm::degrees(picture.environment.rotation);
    settings.light = picture.environment.defaultLight;
    const glm::vec3& radiance = picture.environment.radiance;
    const std::array<float, 3> rgb{radiance.x, radiance.y, radiance.z};
    if (!source.environmentFile.empty() || picture.environment.usesScene)
        settings.environmentTint = rgb;
    else
        settings.background = rgb;

    session::RenderFile render = session::DescribeRender(source, settings, device);
    render.radiance = std::move(picture.mean);
    render.variance = std::move(picture.variance);
    render.sums.radiance = std::move(picture.sums);
    render.albedo = std::move(picture.albedo);
    render.normal = std::move(picture.normal);
    render.depth = std::move(picture.depth);
    render.instance = std::move(picture.instance);
    render.material = std::move(picture.material);
    render.samples = {{0, picture.sampleCount}};
    return render;
}

}  // namespace raygraph::editor
