// Lists the settings that change a render's picture, each as one entry of a table. Command lines offer this
// table, files of renders record it, and resumed or merged renders are compared by it: a new entry is used by
// all three.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "editor/session/settings/picture_settings.h"

namespace raygraph::session {

struct PictureSetting {
    const char* name;     // option without dashes
    const char* operand;  // e.g. "WxH"
    std::string help;     // "{}" is replaced by the default
    std::function<void(PictureSettings&, std::string_view text)>
        set;                                                  // throws Error{Usage} that quotes the text
    std::function<std::string(const PictureSettings&)> text;  // `set` reads it back to the same value
    bool isList = false;                                      // may be repeated: its texts are joined by ';'
    std::vector<std::string_view> choices{};                  // accepted names, if only names are accepted

    std::string HelpWith(const PictureSettings& defaults) const;
};

std::span<const PictureSetting> PictureSettingTable();
bool IsSetting(std::string_view name);

}  // namespace raygraph::session
