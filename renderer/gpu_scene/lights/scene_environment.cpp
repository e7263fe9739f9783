#include "renderer/gpu_scene/lights/scene_environment.h"

#include <cmath>
#include <utility>

#include "base/error.h"
#include "renderer/gpu_scene/lights/light_set.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/studio.h"

namespace raygraph {

SceneEnvironment::SceneEnvironment(rhi::Device& device, rhi::Uploader& uploader)
    : m_device(device), m_uploader(uploader), m_blank(BlankEnvironment(device, uploader)) {}

bool SceneEnvironment::Set(const EnvironmentSettings& settings) {
    if (m_settings == settings) return false;
    if (!scene::IsFinite(settings.radiance) || glm::any(glm::lessThan(settings.radiance, glm::vec3(0.0f))) ||
        !std::isfinite(settings.rotation))
        throw Error(ErrorKind::Usage,
                    "GpuScene: SetEnvironment: radiance and rotation must be finite, radiance not negative");
    m_settings = settings;
    return true;
}

void SceneEnvironment::SetMap(const image::ImageF& equirectangular) {
    RequireRadiance(equirectangular);
    std::optional<EnvironmentOnDevice> uploaded;
    m_uploader.FlushAfter([&] { uploaded = UploadEnvironment(m_device, m_uploader, equirectangular); });
    m_ofHost = std::move(uploaded);
    ++m_version;
}

bool SceneEnvironment::RemoveMap() {
    if (!m_ofHost) return false;
    m_ofHost.reset();
    ++m_version;
    return true;
}

EnvironmentSettings SceneEnvironment::Shown() const {
    EnvironmentSettings shown = m_settings;
    shown.defaultLight = ShownDefault();
    return shown;
}

void SceneEnvironment::SetScene(std::optional<EnvironmentOnDevice>&& map, bool hasOwnLight) {
    if (map || m_ofScene) ++m_version;
    m_ofScene = std::move(map);
    m_sources = {};
    m_sources.isScene = hasOwnLight;
}

DefaultLight SceneEnvironment::ShownDefault() const {
    if (m_ofHost || !m_settings.usesScene) return DefaultLight::None;
    if (m_settings.defaultLight != DefaultLight::Auto) return m_settings.defaultLight;
    return m_ofScene || m_sources.IsAny() ? DefaultLight::None : DefaultLight::Studio;
}

void SceneEnvironment::Declare(Renderer& renderer, SceneIds& ids, LightSet& lights) {
    EnvironmentOnDevice* map = m_ofHost ? &*m_ofHost : nullptr;
    const bool hasStudio = ShownDefault() == DefaultLight::Studio;
    if (hasStudio && !m_studio)
        m_uploader.FlushAfter(
            [&] { m_studio = UploadEnvironment(m_device, m_uploader, scene::StudioMap()); });
    if (std::exchange(m_hadStudio, hasStudio) != hasStudio) ++m_version;
    if (hasStudio) map = &*m_studio;
    if (!map && m_settings.usesScene && m_ofScene) map = &*m_ofScene;
    const bool isDark = !map && m_settings.usesScene;
    const glm::vec3 radiance = isDark ? glm::vec3(0.0f) : m_settings.radiance;
    EnvironmentOnDevice& shown = map ? *map : m_blank;
    ids.environment = {.radiance = radiance, .rotation = m_settings.rotation, .hasMap = map ? 1u : 0u};
    ids.environmentVersion = m_version;
    ids.environmentMap = renderer.Import("environmentMap", shown.map, shown.mapState);
    ids.environmentTable = renderer.Import("environmentTable", shown.table, shown.tableState);
    lights.SetEnvironment(radiance * shown.meanRadiance, m_settings.rotation, shown.cells);
}

}  // namespace raygraph
