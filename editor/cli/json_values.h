// Values as JSON, for the commands that print it.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "editor/session/settings/parse.h"

namespace raygraph::cli {

// Returns the shortest decimal that reads back as this float; a double's digits would show its rounding.
// JSON has no number that is not finite: null.
inline nlohmann::ordered_json ValueJson(float value) {
    return std::isfinite(value) ? nlohmann::ordered_json(std::stod(session::ToText(value)))
                                : nlohmann::ordered_json();
}
inline nlohmann::ordered_json ValueJson(bool value) {
    return value;
}
inline nlohmann::ordered_json ValueJson(uint32_t value) {
    return value;
}
template <int Length>
nlohmann::ordered_json ValueJson(const glm::vec<Length, float>& value) {
    nlohmann::ordered_json json = nlohmann::ordered_json::array();
    for (int i = 0; i < Length; ++i) json.push_back(ValueJson(value[i]));
    return json;
}

}  // namespace raygraph::cli
