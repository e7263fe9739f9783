// Names biases as the command line and its summary do.
#pragma once

#include <string>

#include "editor/session/settings/bias.h"

namespace raygraph::cli {

std::string Option(session::Bias bias);  // e.g. "--max-depth"

// Returns e.g. "--max-depth removed 25 % +- 0.3 % of the light".
std::string Describe(session::Bias bias, const session::RemovedLight& removed);

}  // namespace raygraph::cli
