// The settings that change a render's picture, each as one entry of a table. The table is what the command
// line offers, what a render's file records and what a resumed or merged render is compared by: a setting
// that is added to it is added to all three.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "editor/cli/light_groups.h"
#include "editor/cli/parse.h"
#include "passes/trace.h"
#include "passes/views.h"

namespace raygraph::cli {

using passes::View;  // what the picture's RGB shows

struct PictureSettings {
    ImageSize size{640, 360};
    View view = View::PathTraced;
    std::string camera;  // as given: name, index or "eye target up fov"; "": the file's first, else framing
    std::string scene;   // glTF scene by name or index; "": the file's default
    float aperture = 0.0f;       // lens radius, metres; 0: a pinhole
    float focusDistance = 0.0f;  // metres; 0: to what is seen in the middle of the scene's bounds
    passes::PathSettings paths{};
    passes::RasterSettings raster{};
    float environmentRotation = 0.0f;  // degrees about +y
    std::array<float, 3> environmentTint{1.0f, 1.0f, 1.0f};
    std::array<float, 3> background{0.0f, 0.0f, 0.0f};
    std::vector<LightGroupPatterns> lightGroups;
};

struct PictureSetting {
    const char* name;     // option without dashes
    const char* operand;  // "WxH"
    std::string help;
    std::function<void(PictureSettings&, std::string_view text)> set;  // Error{Usage} quoting the text
    std::function<std::string(const PictureSettings&)> text;  // what `set` reads back to the same value
    bool isList = false;                      // may be given several times: its texts are joined by ';'
    std::vector<std::string_view> choices{};  // the names that it takes, if it takes names alone
};

std::span<const PictureSetting> PictureSettingTable();

// Settings as the texts of their options, by name.
using SettingTexts = std::map<std::string, std::string, std::less<>>;

// Every setting of the table.
SettingTexts Texts(const PictureSettings& settings);

// Defaults, overridden by the texts. Error{Usage} "--seed: ..." for a text that is no value of its setting; a
// name that is not in the table is left alone.
PictureSettings SettingsFrom(const SettingTexts& texts);

// The first setting of the table whose texts differ: "seed: 1 against 2"; empty when all agree. A setting
// that one side lacks has its default there.
std::string FirstDifference(const SettingTexts& a, const SettingTexts& b);

}  // namespace raygraph::cli
