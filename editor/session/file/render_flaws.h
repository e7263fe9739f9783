// Finds flaws of a render that was not checked by reading a file. For editor/session/ alone. Threads: pure
// functions.
#pragma once

#include <string>

#include "editor/session/file/render_file.h"

namespace raygraph::session {

// Throws SettingError of kind Usage for settings whose texts could not be read back: no option takes their
// values.
void RequireReadable(const PictureSettings& settings);

// Returns the first reason for which its file could not be read back, e.g. "it has no samples"; empty if
// there is none.
std::string FirstFlaw(const RenderFile& render);

// Checks the sample counts of an adaptive render alone.
std::string FlawOfCounts(const RenderFile& render);

}  // namespace raygraph::session
