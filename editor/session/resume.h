// Resuming a render from its file. Threads: plain values and functions of files, for any thread.
#pragma once

#include <filesystem>
#include <string>

#include "base/api.h"
#include "editor/session/render_file.h"
#include "editor/session/run.h"

namespace raygraph::session {

struct ResumedRender {
    std::filesystem::path path;
    RenderFile render;
};

// Why no render can go on with this one: "" where it is a path-traced render with variance, sums and one
// unbroken range of samples, of a scene that is in a file, and its planes have its size.
RAYGRAPH_API std::string WhyNotResumable(const RenderFile& render);

// Error{BadInput} naming the path where there is such a reason.
RAYGRAPH_API void RequireResumable(const ResumedRender& resumed);

// Whether a run by this rule of samples and error would have nothing left to do.
RAYGRAPH_API bool IsComplete(const RenderFile& render, const StopRule& rule);

// Reads one, and requires the same.
RAYGRAPH_API ResumedRender ReadResumedRender(const std::filesystem::path& path, const Log& log = {});

}  // namespace raygraph::session
