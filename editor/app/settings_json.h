// Stored settings as JSON: a reader and a writer of named members, which share one list of them (Visit), and
// the file that they are in. For the sources of the editor alone.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "base/files.h"
#include "base/printable.h"
#include "base/text.h"
#include "editor/app/actions.h"
#include "editor/app/input.h"
#include "editor/app/settings.h"

namespace raygraph::editor {

// Reads the members that are present, and throws for those of another type.
class SettingsReader {
  public:
    explicit SettingsReader(const nlohmann::json& json) : m_json(json) {
        if (!json.is_object()) throw Error(ErrorKind::BadInput, "is no object");
    }
    template <typename Body>
    void In(const char* key, Body&& body) const {
        if (const auto found = m_json.find(key); found != m_json.end()) body(SettingsReader(*found));
    }
    void Flag(const char* key, bool& value) const {
        if (const nlohmann::json* json = Find(key, &nlohmann::json::is_boolean, "true or false"))
            value = json->get<bool>();
    }
    void String(const char* key, std::string& value) const {
        if (const nlohmann::json* json = Find(key, &nlohmann::json::is_string, "a text"))
            value = json->get<std::string>();
    }
    template <typename T>
    void Number(const char* key, T& value, const Range& range) const {
        const nlohmann::json* json = Find(key, &nlohmann::json::is_number, "a number");
        if (json && std::isfinite(json->get<double>()))
            value = static_cast<T>(std::clamp(static_cast<float>(json->get<double>()), range.min, range.max));
    }
    void Color(const char* key, glm::vec3& rgb, const Range& range) const {
        const nlohmann::json* list = Find(key, &nlohmann::json::is_array, "a list of three numbers");
        for (int i = 0; list && i < 3; ++i)
            rgb[i] = std::clamp(list->at(static_cast<size_t>(i)).get<float>(), range.min, range.max);
    }
    // Reads a choice by name. An unknown name leaves the value as it is, since a newer program may have
    // written it.
    template <typename Enum>
    void Choice(const char* key, Enum& value) const {
        const nlohmann::json* json = Find(key, &nlohmann::json::is_string, "a text");
        for (const Enum known : Values<Enum>())
            if (json && IsSameName(json->get_ref<const std::string&>(), Name(known))) value = known;
    }
    template <typename Enum>
    void Choice(const char* key, std::optional<Enum>& value) const {
        const nlohmann::json* json = Find(key, &nlohmann::json::is_string, "a text");
        for (const Enum known : Values<Enum>())
            if (json && IsSameName(json->get_ref<const std::string&>(), Name(known))) value = known;
    }
    // Reads the preset and the keys that differ from it. Unknown names leave the keys as they are.
    void Keys(const char* key, KeyBindings& keys) const {
        In(key, [&](const SettingsReader& reader) {
            KeyPreset preset = KeyPreset::Raygraph;
            reader.Choice("preset", preset);
            keys = KeyBindings(preset);
            for (const ActionRow& row : Actions()) {
                const nlohmann::json* list =
                    reader.Find(row.name, &nlohmann::json::is_array, "a list of keys");
                if (!list) continue;
                editor::Keys pressed;
                for (size_t i = 0; i < std::min(list->size(), pressed.size()); ++i)
                    pressed[i] = KeyFromText((*list)[i].get<std::string>());
                keys.Bind(row.action, pressed);
            }
        });
    }
    void Files(const char* key, std::vector<std::filesystem::path>& files) const {
        const nlohmann::json* list = Find(key, &nlohmann::json::is_array, "a list");
        if (!list) return;
        for (const nlohmann::json& file : *list)
            if (file.is_string() && files.size() < Settings::kMaxRecent)
                files.emplace_back(file.get<std::string>());
    }

  private:
    const nlohmann::json* Find(const char* key, bool (nlohmann::json::*isRight)() const noexcept,
                               const char* what) const {
        const auto found = m_json.find(key);
        if (found == m_json.end()) return nullptr;
        if (!((*found).*isRight)()) throw MakeError(ErrorKind::BadInput, "{}: must be {}", key, what);
        return &*found;
    }

    const nlohmann::json& m_json;
};

class SettingsWriter {
  public:
    explicit SettingsWriter(nlohmann::json& json) : m_json(json) {}
    template <typename Body>
    void In(const char* key, Body&& body) const {
        m_json[key] = nlohmann::json::object();
        body(SettingsWriter(m_json[key]));
    }
    void Flag(const char* key, bool value) const { m_json[key] = value; }
    void String(const char* key, const std::string& value) const { m_json[key] = value; }
    template <typename T>
    void Number(const char* key, T value, const Range&) const {
        m_json[key] = value;
    }
    void Color(const char* key, const glm::vec3& rgb, const Range&) const {
        m_json[key] = {rgb[0], rgb[1], rgb[2]};
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
        In(key, [&](const SettingsWriter& writer) {
            writer.Choice("preset", keys.Preset());
            for (const Action action : keys.Changed()) {
                nlohmann::json& list = writer.m_json[Row(action).name] = nlohmann::json::array();
                for (const std::optional<KeyPress>& press : keys.Of(action))
                    if (press) list.push_back(KeyText(*press));
            }
        });
    }
    void Files(const char* key, const std::vector<std::filesystem::path>& files) const {
        m_json[key] = nlohmann::json::array();
        for (const std::filesystem::path& file : files) m_json[key].push_back(file.string());
    }

  private:
    nlohmann::json& m_json;
};

// Reads the file by take(SettingsReader). Returns false if there is none, and if it cannot be read: `message`
// then gets one line that says why, and what `take` has read is not to be used.
template <typename Take>
bool ReadSettingsFile(const std::filesystem::path& file, std::string& message, Take&& take) {
    constexpr uintmax_t kMaxBytes = 1 << 20;
    std::error_code error;
    if (!std::filesystem::exists(file, error)) return false;
    try {
        if (!std::filesystem::is_regular_file(file) || std::filesystem::file_size(file) > kMaxBytes)
            throw Error(ErrorKind::BadInput, "is no file of settings");
        std::ifstream stream(file, std::ios::binary);
        std::ostringstream text;
        text << stream.rdbuf();
        if (!stream) throw Error(ErrorKind::Io, "cannot be read");
        take(SettingsReader(nlohmann::json::parse(text.str())));
        return true;
    } catch (const std::exception& failure) {
        std::string what = failure.what();
        // The parser's messages begin with a code in brackets
        if (const size_t end = what.find("] "); what.starts_with('[') && end != what.npos)
            what.erase(0, end + 2);
        message = Text("{}: {}; ignored", file, Printable(what));
        return false;
    }
}

// Writes the file with what write(SettingsWriter) writes. Throws Error{Io}.
template <typename Write>
void WriteSettingsFile(const std::filesystem::path& file, Write&& write) {
    nlohmann::json json = nlohmann::json::object();
    write(SettingsWriter(json));
    // A path may hold any bytes
    const std::string text = json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
    AtomicFile atomic(file);
    atomic.Write(std::as_bytes(std::span(text)));
    atomic.Commit();
}

}  // namespace raygraph::editor
