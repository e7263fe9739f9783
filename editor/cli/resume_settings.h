// Checks the options that are given beside --resume.
#pragma once

#include "editor/cli/arguments.h"
#include "editor/session/file/resume.h"

namespace raygraph::cli {

// Returns the file's settings, with which the render continues. Throws Error{Usage} that names an option if
// it differs from the file, if the AOVs do, or if there is nothing left to render.
PictureSettings SettingsOf(const ResumedRender& resumed, const RenderArguments& arguments);

}  // namespace raygraph::cli
