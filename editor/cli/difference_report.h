// The numbers of a difference of two pictures, for people and as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "editor/session/verify/difference.h"

namespace raygraph::cli {

// Returns one line for each number.
std::string DescribeDifference(const session::PictureDifference& difference);
nlohmann::ordered_json DifferenceJson(const session::PictureDifference& difference);
// Returns the result of `compare`, schema 1.
std::string CompareJson(const session::Picture& reference, const session::Picture& picture,
                        const session::PictureDifference& difference);

}  // namespace raygraph::cli
