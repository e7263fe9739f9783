// The form of the integrator as text: "auto", "loop", "wavefront:4".
#pragma once

#include <string>
#include <string_view>

#include "passes/trace.h"

namespace raygraph::session {

// "wavefront" alone has the default number of steps. Error{Usage} for any other text.
passes::FormSettings ParseForm(std::string_view text);
std::string FormText(const passes::FormSettings& form);

}  // namespace raygraph::session
