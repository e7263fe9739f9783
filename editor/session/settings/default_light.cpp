#include "editor/session/settings/default_light.h"

#include <span>

#include "renderer/scene/model/check.h"

namespace raygraph::session {

namespace {

DefaultLight Decide(const SceneInput& input, const PictureSettings& settings, const ResumedRender* resumed) {
    if (resumed != nullptr) return SettingsFrom(resumed->render.settings).light;
    const bool hasMap = !input.environment.rgba.empty();
    if (settings.background || hasMap || input.data.environment.IsPresent() ||
        !passes::ShowsLight(settings.view))
        return DefaultLight::None;
    scene::Check(input.data, "Session");
    return HasOwnLight(input.data) ? DefaultLight::None : DefaultLight::Studio;
}

}  // namespace

DefaultLight ChooseLight(const SceneInput& input, const PictureSettings& settings,
                         const ResumedRender* resumed, ProcessGroup* group) {
    DefaultLight light = settings.light;
    if (light != DefaultLight::Auto) return light;
    if (group == nullptr || group->IsRoot()) light = Decide(input, settings, resumed);
    if (group != nullptr) group->Broadcast(std::as_writable_bytes(std::span(&light, 1)));
    return light;
}

}  // namespace raygraph::session
