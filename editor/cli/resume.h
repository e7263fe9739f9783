// Resuming a render from its .exr.
#pragma once

#include "editor/cli/arguments.h"
#include "editor/cli/render_file.h"

namespace raygraph::cli {

struct ResumedRender {
    std::filesystem::path path;
    RenderFile render;
};

// Reads it. Error{BadInput} unless it is a path-traced render with variance and one unbroken sample range.
ResumedRender ReadResumedRender(const std::filesystem::path& path);

// The settings to go on with: those of the file. Error{Usage} naming the option when one that was given says
// otherwise, the AOVs are others than the file's, or there is nothing left to render.
PictureSettings SettingsOf(const ResumedRender& resumed, const RenderArguments& arguments);

}  // namespace raygraph::cli
