// Groups of lights whose radiance is told apart. A group is a name and patterns of names. Threads: plain
// values and pure functions, for any thread.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "renderer/gpu_scene/light_groups.h"
#include "renderer/scene/scene_data.h"

namespace raygraph::session {

struct LightGroupPatterns {
    std::string name;                   // letters, digits, '_' and '-'
    std::vector<std::string> patterns;  // as those of a shell: * ? [a-z]

    bool operator==(const LightGroupPatterns&) const = default;
};

// "NAME=PATTERN[,PATTERN...]", several with ';' between them; "" for none. Error{Usage}.
RAYGRAPH_API std::vector<LightGroupPatterns> ParseLightGroups(std::string_view text);
RAYGRAPH_API std::string ToText(const std::vector<LightGroupPatterns>& groups);

// Of every group that the picture has, in the order of the device's: "rest", "environment", then those given.
// Empty for none.
RAYGRAPH_API std::vector<std::string> LightGroupNames(const std::vector<LightGroupPatterns>& groups);

// A pattern is tried on the name of a material, of a punctual light, and of a node that places either or is
// above such a node. The first group that fits has the light. SettingError of kind Usage for a group that
// fits nothing.
RAYGRAPH_API LightGroups MatchLightGroups(const std::vector<LightGroupPatterns>& groups,
                                          const scene::SceneData& scene);

}  // namespace raygraph::session
