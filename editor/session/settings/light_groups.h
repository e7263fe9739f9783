// Defines groups of lights whose radiance is rendered separately. A group is a name and patterns of names.
// Threads: plain values and pure functions, for any thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "renderer/gpu_scene/lights/light_groups.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::session {

struct LightGroupPatterns {
    std::string name;                   // letters, digits, '_' and '-'
    std::vector<std::string> patterns;  // shell patterns: * ? [a-z]

    bool operator==(const LightGroupPatterns&) const = default;
};

// Parses "NAME=PATTERN[,PATTERN...]", several separated by ';'; "" for none. Throws Error{Usage}.
RAYGRAPH_API std::vector<LightGroupPatterns> ParseLightGroups(std::string_view text);
RAYGRAPH_API std::string ToText(const std::vector<LightGroupPatterns>& groups);

// Returns the names of all groups in the device's order: "rest", "environment", then the given ones. Empty
// without groups.
RAYGRAPH_API std::vector<std::string> LightGroupNames(const std::vector<LightGroupPatterns>& groups);

// A pattern is matched with the name of a material, of a punctual light, and of a node that places either, or
// of such a node's ancestors. The first matching group has the light. Throws SettingError of kind Usage for a
// group that matches nothing.
RAYGRAPH_API LightGroups MatchLightGroups(const std::vector<LightGroupPatterns>& groups,
                                          const scene::SceneData& scene);

}  // namespace raygraph::session
