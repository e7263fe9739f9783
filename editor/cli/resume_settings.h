// What the command line may say beside --resume.
#pragma once

#include "editor/cli/arguments.h"
#include "editor/session/resume.h"

namespace raygraph::cli {

// The settings to go on with: those of the file. Error{Usage} naming the option when one that was given says
// otherwise, the AOVs are others than the file's, or there is nothing left to render.
PictureSettings SettingsOf(const ResumedRender& resumed, const RenderArguments& arguments);

}  // namespace raygraph::cli
