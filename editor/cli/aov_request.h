// What --aov asks for.
#pragma once

#include <string_view>

#include "editor/session/aovs.h"

namespace raygraph::cli {

struct AovRequest {
    session::AovSet named;
    bool isAll = false;  // whatever the picture can have
};

// Names in any order, "samples" and "variance" among them, or "all".
AovRequest ParseAovs(std::string_view text);

// What a picture of these settings is to have. Error{Usage} naming an AOV that was asked for by name and that
// it cannot have.
session::AovSet AovsFor(const AovRequest& request, const session::PictureSettings& settings);

}  // namespace raygraph::cli
