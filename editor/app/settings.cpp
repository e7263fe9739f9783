#include "editor/app/settings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>

#include "base/files.h"
#include "base/printable.h"
#include "base/text.h"
#include "editor/app/input.h"

namespace raygraph::editor {

namespace {

using Json = nlohmann::json;

constexpr const char* kFile = "editor.json";
constexpr uintmax_t kMaxSettingsBytes = 1 << 20;

constexpr Range kWindowRange{320.0f, 16384.0f};

// Visits each stored member with its name, and with its range where it has one; reading and writing share
// this list. Visitor is Reader or Writer; Kept is Settings, const for writing.
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

// Reads the members that are present, and throws for those of another type.
class Reader {
  public:
    explicit Reader(const Json& json) : m_json(json) {
        if (!json.is_object()) throw Error(ErrorKind::BadInput, "is no object");
    }
    template <typename Body>
    void In(const char* key, Body&& body) const {
        if (const auto found = m_json.find(key); found != m_json.end()) body(Reader(*found));
    }
    void Flag(const char* key, bool& value) const {
        if (const Json* json = Find(key, &Json::is_boolean, "true or false")) value = json->get<bool>();
    }
    template <typename T>
    void Number(const char* key, T& value, const Range& range) const {
        const Json* json = Find(key, &Json::is_number, "a number");
        if (json && std::isfinite(json->get<double>()))
            value = static_cast<T>(std::clamp(static_cast<float>(json->get<double>()), range.min, range.max));
    }
    // Reads a choice by name. An unknown name leaves the value as it is, since a newer program may have
    // written it.
    template <typename Enum>
    void Choice(const char* key, Enum& value) const {
        const Json* json = Find(key, &Json::is_string, "a text");
        for (const Enum known : Values<Enum>())
            if (json && IsSameName(json->get_ref<const std::string&>(), Name(known))) value = known;
    }
    template <typename Enum>
    void Choice(const char* key, std::optional<Enum>& value) const {
        const Json* json = Find(key, &Json::is_string, "a text");
        for (const Enum known : Values<Enum>())
            if (json && IsSameName(json->get_ref<const std::string&>(), Name(known))) value = known;
    }
    // Reads the preset and the keys that differ from it. Unknown names leave the keys as they are.
    void Keys(const char* key, KeyBindings& keys) const {
        In(key, [&](const Reader& reader) {
            KeyPreset preset = KeyPreset::Raygraph;
            reader.Choice("preset", preset);
            keys = KeyBindings(preset);
            for (const ActionRow& row : Actions()) {
                const Json* list = reader.Find(row.name, &Json::is_array, "a list of keys");
                if (!list) continue;
                editor::Keys pressed;
                for (size_t i = 0; i < std::min(list->size(), pressed.size()); ++i)
                    pressed[i] = KeyFromText((*list)[i].get<std::string>());
                keys.Bind(row.action, pressed);
            }
        });
    }
    void Files(const char* key, std::vector<std::filesystem::path>& files) const {
        const Json* list = Find(key, &Json::is_array, "a list");
        if (!list) return;
        for (const Json& file : *list)
            if (file.is_string() && files.size() < Settings::kMaxRecent)
                files.emplace_back(file.get<std::string>());
    }

  private:
    const Json* Find(const char* key, bool (Json::*isRight)() const noexcept, const char* what) const {
        const auto found = m_json.find(key);
        if (found == m_json.end()) return nullptr;
        if (!((*found).*isRight)()) throw MakeError(ErrorKind::BadInput, "{}: must be {}", key, what);
        return &*found;
    }

    const Json& m_json;
};

class Writer {
  public:
    explicit Writer(Json& json) : m_json(json) {}
    template <typename Body>
    void In(const char* key, Body&& body) const {
        m_json[key] = Json::object();
        body(Writer(m_json[key]));
    }
    void Flag(const char* key, bool value) const { m_json[key] = value; }
    template <typename T>
    void Number(const char* key, T value, const Range&) const {
        m_json[key] = value;
    }
    template <typename Enum>
    void Choice(const char* key, Enum value) const {
        m_json[key] = Name(value);
    }
    template <typename Enum>
    void Choice(const char* key, const std::optional<Enum>& value) const {
        if (value) Choice(key, *value);
    }
    void Keys(const char* key, const KeyBindings& keys) const {
        In(key, [&](const Writer& writer) {
            writer.Choice("preset", keys.Preset());
            for (const Action action : keys.Changed()) {
                Json& list = writer.m_json[Row(action).name] = Json::array();
                for (const std::optional<KeyPress>& press : keys.Of(action))
                    if (press) list.push_back(KeyText(*press));
            }
        });
    }
    void Files(const char* key, const std::vector<std::filesystem::path>& files) const {
        m_json[key] = Json::array();
        for (const std::filesystem::path& file : files) m_json[key].push_back(file.string());
    }

  private:
    Json& m_json;
};

Settings FromJson(const Json& json) {
    Settings settings;
    Visit(Reader(json), settings);
    return settings;
}

Json ToJson(const Settings& settings) {
    Json json = Json::object();
    Visit(Writer(json), settings);
    return json;
}

std::string WithoutCode(std::string what) {
    if (const size_t end = what.find("] "); what.starts_with('[') && end != what.npos) what.erase(0, end + 2);
    return what;
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
    const std::filesystem::path file = folder / kFile;
    std::error_code error;
    if (!std::filesystem::exists(file, error)) return {};
    try {
        if (!std::filesystem::is_regular_file(file) || std::filesystem::file_size(file) > kMaxSettingsBytes)
            throw Error(ErrorKind::BadInput, "is no file of settings");
        std::ifstream stream(file, std::ios::binary);
        std::ostringstream text;
        text << stream.rdbuf();
        if (!stream) throw Error(ErrorKind::Io, "cannot be read");
        return FromJson(Json::parse(text.str()));
    } catch (const std::exception& failure) {
        message = Text("{}: {}; ignored", file, Printable(WithoutCode(failure.what())));
        return {};
    }
}

void WriteSettings(const std::filesystem::path& folder, const Settings& settings) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw MakeError(ErrorKind::Io, "{}: {}", folder, error.message());
    // A path may hold any bytes
    const std::string text = ToJson(settings).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
    AtomicFile file(folder / kFile);
    file.Write(std::as_bytes(std::span(text)));
    file.Commit();
}

}  // namespace raygraph::editor
