#include "editor/app/settings.h"

#include <cstdlib>
#include <system_error>

#include "base/text.h"
#include "editor/app/settings_json.h"

namespace raygraph::editor {

namespace {

constexpr const char* kFile = "editor.json";
constexpr Range kWindowRange{320.0f, 16384.0f};

// Visits each stored member with its name, and with its range where it has one; reading and writing share
// this list. Visitor is SettingsReader or SettingsWriter; Kept is Settings, const for writing.
template <typename Visitor, typename Kept>
void Visit(const Visitor& visitor, Kept& settings) {
    visitor.In("panels", [&](const Visitor& panels) {
        for (const PanelName& panel : kPanels) panels.Flag(panel.name, settings.panels.*panel.isShown);
        panels.Number("leftWidth", settings.panelSizes.left, kPanelRange);
        panels.Number("rightWidth", settings.panelSizes.right, kPanelRange);
        panels.Number("lowerHeight", settings.panelSizes.lower, kPanelRange);
        panels.Number("inspectorShare", settings.panelSizes.inspector, kInspectorRange);
    });
    visitor.In("window", [&](const Visitor& window) {
        window.Number("width", settings.window.width, kWindowRange);
        window.Number("height", settings.window.height, kWindowRange);
    });
    visitor.In("view", [&](const Visitor& view) {
        view.Choice("view", settings.view);
        view.Choice("compared", settings.show.compared);
        view.Flag("denoise", settings.show.isDenoised);
        view.Choice("whileMoving", settings.whileMoving);
        view.Choice("tonemap", settings.show.tonemap.tonemapOperator);
        view.Number("exposure", settings.show.tonemap.exposureEv, kExposureRange);
        view.Number("whitePoint", settings.whitePoint, kWhitePointRange);
        view.Number("wipe", settings.show.wipePosition, kWipeRange);
        view.Number("maxError", settings.show.maxError, kErrorRange);
    });
    visitor.Keys("keys", settings.keys);
    visitor.In("gizmo", [&](const Visitor& gizmo) {
        gizmo.Choice("tool", settings.tool);
        gizmo.Choice("space", settings.toolSpace);
        gizmo.Choice("pivot", settings.pivot);
    });
    visitor.Files("recent", settings.recent);
}

}  // namespace

void Settings::AddRecentFile(const std::filesystem::path& file) {
    std::error_code error;
    const std::filesystem::path whole = std::filesystem::absolute(file, error).lexically_normal();
    std::erase(recent, whole);
    recent.insert(recent.begin(), whole);
    if (recent.size() > kMaxRecent) recent.resize(kMaxRecent);
}

std::filesystem::path ConfigFolder() {
    // The XDG standard says that a relative path is to be ignored
    if (const char* config = std::getenv("XDG_CONFIG_HOME"); config && config[0] == '/')
        return std::filesystem::path(config) / "raygraph";
    if (const char* home = std::getenv("HOME"); home && home[0] == '/')
        return std::filesystem::path(home) / ".config" / "raygraph";
    return {};
}

Settings ReadSettings(const std::filesystem::path& folder, std::string& message) {
    Settings settings;
    const auto take = [&](const SettingsReader& reader) { Visit(reader, settings); };
    return ReadSettingsFile(folder / kFile, message, take) ? settings : Settings();
}

void WriteSettings(const std::filesystem::path& folder, const Settings& settings) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw MakeError(ErrorKind::Io, "{}: {}", folder, error.message());
    WriteSettingsFile(folder / kFile, [&](const SettingsWriter& writer) { Visit(writer, settings); });
}

}  // namespace raygraph::editor
