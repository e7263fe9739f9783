// Sums of samples that several devices or files have, as one. Threads: pure functions.
#pragma once

#include "editor/session/render_file.h"

namespace raygraph::session {

// Adds to sums that may be of no part yet.
void Add(RenderSums& sums, RenderSums&& others);

// Sets all means and variances to what the sums say; there are samples.
void TakeMeans(RenderFile& render);

// All sums, in one order for renders of the same settings; those that are not rendered are empty.
std::vector<passes::ExactSums*> AllOf(RenderSums& sums);

}  // namespace raygraph::session
