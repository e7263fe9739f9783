// What is wrong with a render that no reader of files has checked. For editor/session/ alone. Threads: pure
// functions.
#pragma once

#include <string>

#include "editor/session/render_file.h"

namespace raygraph::session {

// SettingError of kind Usage for settings whose texts could not be read back: of values that no option takes.
void RequireReadable(const PictureSettings& settings);

// "it has no samples": the first thing for which a file of it could not be read back; empty when it could.
std::string FirstFlaw(const RenderFile& render);

// Of its counts of samples alone, if it is adaptive.
std::string FlawOfCounts(const RenderFile& render);

}  // namespace raygraph::session
