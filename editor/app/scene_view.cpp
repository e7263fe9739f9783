#include "editor/app/scene_view.h"

#include <system_error>

#include "editor/app/settings_json.h"

namespace raygraph::editor {

namespace {

namespace fs = std::filesystem;

constexpr Range kLength{0.0f, 1e9f}, kRadiance{0.0f, 1e6f}, kTurn{-36000.0f, 36000.0f};
constexpr Range kStops{-100.0f, 100.0f};  // as `render --exposure`

// Reading and writing share this list, as in settings.cpp. `environment` is the name in the file.
template <typename Visitor, typename View, typename Name>
void VisitView(const Visitor& visitor, View& view, Name& environment) {
    visitor.In("camera", [&](const Visitor& camera) {
        camera.String("view", view.camera);
        camera.Number("aperture", view.aperture, kLength);
        camera.Number("focus", view.focus, kLength);
    });
    visitor.In("environment", [&](const Visitor& light) {
        light.String("map", environment);
        light.Flag("usesScene", view.usesScene);
        light.Choice("studio", view.light);
        light.Color("radiance", view.radiance, kRadiance);
        light.Number("rotation", view.rotation, kTurn);
    });
    visitor.In("backdrop", [&](const Visitor& behind) {
        behind.String("behind", view.backdrop);
        behind.Flag("ground", view.hasGround);
    });
    visitor.In("display", [&](const Visitor& display) {
        display.Number("exposure", view.exposureEv, kStops);
        display.Number("whitePoint", view.whitePoint, kWhitePointRange);
        display.Choice("tonemap", view.tonemap);
    });
}

fs::path FolderOf(const fs::path& scene) {
    std::error_code error;
    return fs::weakly_canonical(fs::absolute(scene, error), error).parent_path();
}

}  // namespace

fs::path ViewFileOf(const fs::path& scene) {
    fs::path file = scene;
    return file += ".view.json";
}

std::optional<SceneView> ReadView(const fs::path& scene, std::string& message) {
    SceneView view;
    const auto take = [&](const SettingsReader& reader) {
        std::string environment;
        VisitView(reader, view, environment);
        if (!environment.empty()) view.environment = (FolderOf(scene) / environment).lexically_normal();
    };
    return ReadSettingsFile(ViewFileOf(scene), message, take) ? std::optional(view) : std::nullopt;
}

void WriteView(const fs::path& scene, const SceneView& view) {
    std::string environment;
    if (!view.environment.empty()) {
        std::error_code error;
        const fs::path whole = fs::weakly_canonical(fs::absolute(view.environment, error), error);
        environment = whole.lexically_proximate(FolderOf(scene)).string();
    }
    WriteSettingsFile(ViewFileOf(scene),
                      [&](const SettingsWriter& writer) { VisitView(writer, view, environment); });
}

void SceneView::ResetEnvironment() {
    const SceneView plain;
    environment.clear();
    usesScene = plain.usesScene;
    light = plain.light;
    radiance = plain.radiance;
    rotation = plain.rotation;
}

}  // namespace raygraph::editor
