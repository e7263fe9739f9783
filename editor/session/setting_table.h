// The settings that change a render's picture, each as one entry of a table. The table is what a command line
// offers, what a render's file records and what a resumed or merged render is compared by: a setting that is
// added to it is added to all three.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "editor/session/picture_settings.h"

namespace raygraph::session {

struct PictureSetting {
    const char* name;                                                  // option without dashes
    const char* operand;                                               // "WxH"
    std::string help;                                                  // "{}" stands for the default
    std::function<void(PictureSettings&, std::string_view text)> set;  // Error{Usage} quoting the text
    std::function<std::string(const PictureSettings&)> text;  // what `set` reads back to the same value
    bool isList = false;                      // may be given several times: its texts are joined by ';'
    std::vector<std::string_view> choices{};  // the names that it takes, if it takes names alone

    std::string HelpWith(const PictureSettings& defaults) const;
};

std::span<const PictureSetting> PictureSettingTable();
bool IsSetting(std::string_view name);

}  // namespace raygraph::session
