#include "editor/app/settings.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>

#include "base/atomic_file.h"
#include "base/error.h"
#include "base/printable.h"
#include "editor/app/input.h"

namespace raygraph::editor {

namespace {

using Json = nlohmann::json;

constexpr const char* kFile = "editor.json";
constexpr uintmax_t kMostBytes = 1 << 20;

// Reads members that are there, and fails for those of another type.
class Reader {
  public:
    explicit Reader(const Json& json) : m_json(json) {
        if (!json.is_object()) throw Error(ErrorKind::BadInput, "is no object");
    }
    Reader In(const char* key) const {
        static const Json kEmpty = Json::object();
        const auto found = m_json.find(key);
        return Reader(found == m_json.end() ? kEmpty : *found);
    }
    void Flag(const char* key, bool& value) const {
        if (const Json* json = Find(key, &Json::is_boolean, "true or false")) value = json->get<bool>();
    }
    void Number(const char* key, float& value, float least, float most) const {
        const Json* json = Find(key, &Json::is_number, "a number");
        if (json && std::isfinite(json->get<double>()))
            value = std::clamp(static_cast<float>(json->get<double>()), least, most);
    }
    // By name; one that is not known leaves it as it is: it may be a newer program's.
    template <typename Enum>
    void Choice(const char* key, Enum& value) const {
        const Json* json = Find(key, &Json::is_string, "a text");
        for (const Enum known : Values<Enum>())
            if (json && IsSameName(json->get_ref<const std::string&>(), Name(known))) value = known;
    }
    const Json* Find(const char* key, bool (Json::*isRight)() const noexcept, const char* what) const {
        const auto found = m_json.find(key);
        if (found == m_json.end()) return nullptr;
        if (!((*found).*isRight)()) throw Error(ErrorKind::BadInput, std::string(key) + ": must be " + what);
        return &*found;
    }

  private:
    const Json& m_json;
};

Settings FromJson(const Json& json) {
    Settings settings;
    const Reader reader(json);
    const Reader panels = reader.In("panels");
    panels.Flag("hierarchy", settings.panels.hierarchy);
    panels.Flag("inspector", settings.panels.inspector);
    panels.Flag("statistics", settings.panels.statistics);
    panels.Flag("graph", settings.panels.graph);
    panels.Flag("help", settings.panels.help);
    const auto side = [&](const char* key, uint32_t& value) {
        auto length = static_cast<float>(value);
        reader.In("window").Number(key, length, 320.0f, 16384.0f);
        value = static_cast<uint32_t>(length);
    };
    side("width", settings.window.width);
    side("height", settings.window.height);
    const Reader view = reader.In("view");
    view.Choice("view", settings.show.view);
    view.Choice("tonemap", settings.show.tonemap.tonemapOperator);
    view.Number("exposure", settings.show.tonemap.exposureEv, -8.0f, 8.0f);
    view.Number("wipe", settings.show.wipePosition, 0.0f, 1.0f);
    view.Number("greatestError", settings.show.greatestError, 0.01f, 2.0f);
    const Reader gizmo = reader.In("gizmo");
    gizmo.Choice("tool", settings.tool);
    gizmo.Choice("space", settings.toolSpace);
    gizmo.Choice("pivot", settings.pivot);
    if (const Json* recent = reader.Find("recent", &Json::is_array, "a list"))
        for (const Json& file : *recent)
            if (file.is_string() && settings.recent.size() < Settings::kMostRecent)
                settings.recent.emplace_back(file.get<std::string>());
    return settings;
}

Json ToJson(const Settings& settings) {
    Json recent = Json::array();
    for (const std::filesystem::path& file : settings.recent) recent.push_back(file.string());
    const viewport::ShowSettings& show = settings.show;
    return {{"panels",
             {{"hierarchy", settings.panels.hierarchy},
              {"inspector", settings.panels.inspector},
              {"statistics", settings.panels.statistics},
              {"graph", settings.panels.graph},
              {"help", settings.panels.help}}},
            {"window", {{"width", settings.window.width}, {"height", settings.window.height}}},
            {"view",
             {{"view", Name(show.view)},
              {"tonemap", Name(show.tonemap.tonemapOperator)},
              {"exposure", show.tonemap.exposureEv},
              {"wipe", show.wipePosition},
              {"greatestError", show.greatestError}}},
            {"gizmo",
             {{"tool", Name(settings.tool)},
              {"space", Name(settings.toolSpace)},
              {"pivot", Name(settings.pivot)}}},
            {"recent", recent}};
}

std::string WithoutCode(std::string what) {
    if (const size_t end = what.find("] "); what.starts_with('[') && end != what.npos) what.erase(0, end + 2);
    return what;
}

}  // namespace

void Settings::NoteOpened(const std::filesystem::path& file) {
    std::error_code error;
    const std::filesystem::path whole = std::filesystem::absolute(file, error).lexically_normal();
    std::erase(recent, whole);
    recent.insert(recent.begin(), whole);
    if (recent.size() > kMostRecent) recent.resize(kMostRecent);
}

std::filesystem::path ConfigFolder() {
    // A relative one is to be ignored, says the standard
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
        if (!std::filesystem::is_regular_file(file) || std::filesystem::file_size(file) > kMostBytes)
            throw Error(ErrorKind::BadInput, "is no file of settings");
        std::ifstream stream(file, std::ios::binary);
        std::ostringstream text;
        text << stream.rdbuf();
        if (!stream) throw Error(ErrorKind::Io, "cannot be read");
        return FromJson(Json::parse(text.str()));
    } catch (const std::exception& failure) {
        message = file.string() + ": " + Printable(WithoutCode(failure.what())) + "; left aside";
        return {};
    }
}

void WriteSettings(const std::filesystem::path& folder, const Settings& settings) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) throw Error(ErrorKind::Io, folder.string() + ": " + error.message());
    // A path may hold any bytes
    const std::string text = ToJson(settings).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
    AtomicFile file(folder / kFile);
    file.Write(std::as_bytes(std::span(text)));
    file.Commit();
}

}  // namespace raygraph::editor
