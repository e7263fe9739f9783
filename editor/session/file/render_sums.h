// Combines the sums of samples from several devices or files. Threads: pure functions.
#pragma once

#include "editor/session/file/render_file.h"

namespace raygraph::session {

// Adds to sums that may be empty.
void Add(RenderSums& sums, RenderSums&& others);

// Sets all means and variances from the sums; there must be samples.
void TakeMeans(RenderFile& render);

// Returns all sums in an order that depends on the settings alone; those that are not rendered are empty.
std::vector<passes::ExactSums*> AllOf(RenderSums& sums);

}  // namespace raygraph::session
