// Files of light profiles: IES LM-63, of 1995, 2002 and 2019, and the older ones of 1986 and 1991. Internal
// to renderer/scene. Threads: a pure function.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "renderer/scene/model/light_profile.h"

namespace raygraph::scene {

struct IesFile {
    LightProfile profile;               // without a name
    std::vector<std::string> warnings;  // what was repaired, without the file's name
};

// Intensities are the file's times its multiplier and its ballast factor (and the ballast-lamp factor, which
// files before 1995 have); symmetric halves and quarters are completed. Keywords and all that is about tilt,
// lamps and the housing are skipped. Input is hostile: memory is at most some tens of bytes a character of
// the text. Throws Error{BadInput}, one line, without the file's name: "line 12: ...".
IesFile ParseIes(std::string_view text);

}  // namespace raygraph::scene
