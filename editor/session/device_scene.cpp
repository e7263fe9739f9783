#include "editor/session/device_scene.h"

#include "base/text.h"
#include "editor/session/bias.h"
#include "passes/path_settings.h"
#include "renderer/gpu_scene/camera_record.h"
#include "renderer/scene/camera_view.h"

namespace raygraph::session {

namespace {

// Distance along the view to the middle of the scene, for a lens that was given no focus.
float DefaultFocus(const scene::CameraView& view, const scene::Bounds& bounds) {
    if (bounds.IsEmpty()) return 1.0f;
    const float distance = glm::dot(bounds.Center() - glm::vec3(view.eye), view.forward);
    return distance > 0.0f ? distance : 1.0f;
}

scene::CameraView ViewFrom(const PictureSettings& settings, const scene::SceneData& data, float aspect) {
    try {
        return scene::ChooseView(data, settings.camera, aspect);
    } catch (const Error& error) {
        throw SettingError(error.Kind(), Text("camera: {}", error.what()));
    }
}

passes::TraceSettings TraceSettingsFrom(const PictureSettings& settings, const scene::SceneData& data) {
    const float aspect = static_cast<float>(settings.size.width) / static_cast<float>(settings.size.height);
    const scene::CameraView view = ViewFrom(settings, data, aspect);
    const float focus =
        settings.focusDistance > 0.0f ? settings.focusDistance : DefaultFocus(view, data.bounds);
    return passes::FrameSettings({settings.size.width, settings.size.height}, view,
                                 {settings.aperture, focus}, settings.paths);
}

// Only what reads them needs the levels of textures.
GpuSceneDesc SceneDescFor(const PictureSettings& settings) {
    const bool isDrawn = settings.view == View::Raster;
    return {.textureLevels = isDrawn || IsOn(settings.paths.biases, Bias::TextureLod),
            .textureBudget = settings.textureBudget};
}

}  // namespace

DeviceScene::DeviceScene(rhi::Device& device, SceneInput& input, const PictureSettings& settings)
    : m_renderer(device),
      m_scene(m_renderer, SceneDescFor(settings)),
      m_settings(TraceSettingsFrom(settings, input.data)) {
    LightGroups groups = MatchLightGroups(settings.lightGroups, input.data);
    const bool hasMap = !input.environment.rgba.empty();
    const bool usesScene = !hasMap && !settings.background && input.data.environment.IsPresent();
    m_scene.SetScene(std::move(input.data));
    m_scene.SetViewpoint(EyeOf(m_settings.camera));
    m_scene.SetLightGroups(std::move(groups));
    const std::array<float, 3> radiance =
        hasMap || usesScene ? settings.environmentTint : settings.background.value_or(std::array<float, 3>{});
    m_scene.SetEnvironment({.radiance = glm::vec3(radiance[0], radiance[1], radiance[2]),
                            .rotation = glm::radians(settings.environmentRotation),
                            .usesScene = usesScene});
    if (!hasMap) return;
    m_scene.SetEnvironmentMap(input.environment);
    input.environment = {};
}

passes::TraceSettings DeviceScene::SettingsFor(uint32_t sampleIndex) const {
    passes::TraceSettings settings = m_settings;
    settings.sampleIndex = sampleIndex;
    return settings;
}

}  // namespace raygraph::session
