// AovRequest is the parsed operand of --aov. Threads: plain values and pure functions, for any thread.
#pragma once

#include <string_view>

#include "editor/session/settings/aovs.h"

namespace raygraph::cli {

struct AovRequest {
    session::AovSet named;
    bool isAll = false;  // every AOV that the picture can have
};

// Parses names in any order, "samples" and "variance" among them, or "all".
AovRequest ParseAovs(std::string_view text);

// Returns the AOVs of a picture with these settings. Throws Error{Usage} that names an AOV which was asked
// for by name and which the picture cannot have.
session::AovSet AovsFor(const AovRequest& request, const session::PictureSettings& settings);

}  // namespace raygraph::cli
