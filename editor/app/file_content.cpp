#include "editor/app/file_content.h"

#include <utility>

#include "base/error.h"
#include "editor/session/file/content_hash.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/variants.h"

namespace raygraph::editor {

std::optional<FileStamp> StampOf(const std::filesystem::path& file) {
    std::error_code error;
    const FileStamp stamp{std::filesystem::last_write_time(file, error),
                          std::filesystem::file_size(file, error)};
    return error ? std::nullopt : std::optional(stamp);
}

FileContent WithHash(FileContent content, const Log& log) {
    const auto isSame = [&] { return !content.file.empty() && StampOf(content.file) == content.stamp; };
    if (!isSame()) {
        content.hash.clear();
        return content;
    }
    if (!content.hash.empty()) return content;
    try {
        scene::SceneData scene = scene::LoadGltf(
            content.file, {.pointsAndLines = content.pointsAndLines, .root = content.root, .log = log});
        scene::SetVariant(scene, content.variant);
        content.hash = session::HashOf(scene);
    } catch (const Error&) {
        return content;  // the hash stays unknown
    }
    if (!isSame()) content.hash.clear();  // the file was written while it was read
    return content;
}

session::PictureSettings SettingsOf(const viewport::CaptureResult& picture, const ShownScene& shown) {
    const session::SceneInput& source = shown.input;
    session::PictureSettings settings;
    settings.size = picture.extent;
    settings.view = picture.isRaster ? session::View::Raster : session::View::PathTraced;
    settings.variant = source.variant;
    settings.at = shown.at;
    if (shown.at) settings.clips = shown.clips;
    settings.pointsAndLines = source.pointsAndLines;
    settings.camera = shown.camera;
    if (picture.lens.radius > 0.0f) {
        settings.aperture = picture.lens.radius;
        settings.focusDistance = picture.lens.focusDistance;
    }
    settings.paths = picture.paths;
    settings.hasGround = shown.hasGround && !picture.isRaster;
    settings.raster = picture.raster;
    settings.environmentRotation = glm::degrees(picture.environment.rotation);
    settings.light = picture.environment.defaultLight;
    const glm::vec3& radiance = picture.environment.radiance;
    const std::array<float, 3> rgb{radiance.x, radiance.y, radiance.z};
    if (!source.environmentFile.empty() || picture.environment.usesScene)
        settings.environmentTint = rgb;
    else
        settings.background = rgb;
    return settings;
}

session::RenderFile RenderOf(viewport::CaptureResult&& picture, const ShownScene& shown,
                             const rhi::DeviceInfo& device) {
    session::SceneInput source = shown.input;
    source.isAnimated = shown.at.has_value();
    const session::PictureSettings settings = SettingsOf(picture, shown);
    session::RenderFile render = session::DescribeRender(source, settings, device);
    render.radiance = std::move(picture.mean);
    render.variance = std::move(picture.variance);
    render.denoised = std::move(picture.denoised);
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
