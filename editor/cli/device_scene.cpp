#include "editor/cli/device_scene.h"

#include "renderer/gpu_scene/camera_record.h"
#include "renderer/scene/camera_view.h"

namespace raygraph::cli {

namespace {

passes::TraceSettings TraceSettingsFrom(const PictureSettings& settings, const scene::SceneData& data) {
    const float aspect = static_cast<float>(settings.size.width) / static_cast<float>(settings.size.height);
    return {.extent = {settings.size.width, settings.size.height},
            .camera = ToRecord(scene::ChooseView(data, settings.camera, aspect)),
            .sampler = settings.sampler,
            .seed = settings.seed,
            .maxDepth = settings.maxDepth.value_or(passes::kNoDepthLimit),
            .rouletteStart = settings.rouletteStart};
}

}  // namespace

DeviceScene::DeviceScene(rhi::Device& device, SceneInput& input, const PictureSettings& settings)
    : m_renderer(device), m_scene(m_renderer), m_settings(TraceSettingsFrom(settings, input.data)) {
    m_scene.SetScene(std::move(input.data));
    const bool hasMap = !input.environment.rgba.empty();
    const auto& background = settings.background;
    m_scene.SetEnvironment(
        {.radiance = hasMap ? glm::vec3(1.0f) : glm::vec3(background[0], background[1], background[2]),
         .rotation = glm::radians(settings.environmentRotation)});
    if (!hasMap) return;
    m_scene.SetEnvironmentMap(input.environment);
    input.environment = {};
}

passes::TraceSettings DeviceScene::SettingsFor(uint32_t sampleIndex) const {
    passes::TraceSettings settings = m_settings;
    settings.sampleIndex = sampleIndex;
    return settings;
}

}  // namespace raygraph::cli
