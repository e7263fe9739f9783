// Resuming a render from its file. Threads: plain values and functions of files, for any thread.
#pragma once

#include <filesystem>

#include "base/api.h"
#include "editor/session/render_file.h"

namespace raygraph::session {

struct ResumedRender {
    std::filesystem::path path;
    RenderFile render;
};

// Reads it. Error{BadInput} unless it is a path-traced render with variance and one unbroken sample range.
RAYGRAPH_API ResumedRender ReadResumedRender(const std::filesystem::path& path);

}  // namespace raygraph::session
