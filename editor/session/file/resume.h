// Resuming a render from its file. Threads: plain values and functions of files, for any thread.
#pragma once

#include <filesystem>
#include <string>

#include "base/api.h"
#include "editor/session/file/render_file.h"
#include "editor/session/run.h"

namespace raygraph::session {

struct ResumedRender {
    std::filesystem::path path;
    RenderFile render;
};

// Returns why the render cannot be resumed; "" for a path-traced render with variance, sums and one
// contiguous range of samples, of a scene in a file, whose planes have its size.
RAYGRAPH_API std::string NotResumableReason(const RenderFile& render);

// Throws Error{BadInput} that names the path if it cannot be resumed.
RAYGRAPH_API void RequireResumable(const ResumedRender& resumed);

// Returns whether a run by this rule of samples and error would have nothing left to do.
RAYGRAPH_API bool IsComplete(const RenderFile& render, const StopRule& rule);

// Reads a render, and requires that it can be resumed.
RAYGRAPH_API ResumedRender ReadResumedRender(const std::filesystem::path& path, const Log& log = {});

}  // namespace raygraph::session
