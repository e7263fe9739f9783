#include "editor/session/settings/light_groups.h"

#include <algorithm>

#include "base/os.h"
#include "base/printable.h"
#include "base/text.h"
#include "editor/session/settings/parse.h"
#include "editor/session/settings/picture_settings.h"

namespace raygraph::session {

namespace {

constexpr const char* kRest = "rest";
constexpr const char* kEnvironment = "environment";

[[noreturn]] void RejectGroup(std::string_view text, const std::string& why) {
    throw MakeError(ErrorKind::Usage, "{}: {}", Quoted(text), why);
}

bool IsNameCharacter(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
}

LightGroupPatterns ParseGroup(std::string_view text) {
    const size_t equals = text.find('=');
    if (equals == std::string_view::npos) RejectGroup(text, "not of the form NAME=PATTERN[,PATTERN...]");
    LightGroupPatterns group{.name = std::string(text.substr(0, equals)), .patterns = {}};
    if (group.name.empty() || !std::ranges::all_of(group.name, IsNameCharacter))
        RejectGroup(text, "the name of a group is of letters, digits, _ and -");
    if (group.name == kRest || group.name == kEnvironment)
        RejectGroup(text, Text("{} is a group of its own already", group.name));
    for (const std::string_view pattern : ParseList(text.substr(equals + 1)))
        group.patterns.emplace_back(pattern);
    return group;
}

// Finds the groups that match each named object of a scene.
class Matcher {
  public:
    Matcher(const std::vector<LightGroupPatterns>& groups, const scene::SceneData& scene)
        : m_groups(groups), m_scene(scene), m_fits(groups.size(), false) {}

    uint32_t OfName(const std::string& name) {
        uint32_t first = gpu::kLightGroupRest;
        for (size_t i = m_groups.size(); i-- > 0;) {
            const bool fits = std::ranges::any_of(m_groups[i].patterns, [&](const std::string& pattern) {
                return os::MatchesPattern(name, pattern);
            });
            if (!fits) continue;
            m_fits[i] = true;
            first = gpu::kLightGroupNamed + static_cast<uint32_t>(i);
        }
        return first;
    }
    // Returns the first group that the node or one of its ancestors is in.
    uint32_t OfNode(uint32_t node) {
        uint32_t first = gpu::kLightGroupRest;
        for (; node != scene::kNone; node = m_scene.nodes[node].parent)
            first = FirstLightGroup(first, OfName(m_scene.nodes[node].name));
        return first;
    }
    void RequireAllMatched() const {
        for (size_t i = 0; i < m_groups.size(); ++i)
            if (!m_fits[i])
                throw SettingError(
                    ErrorKind::Usage,
                    Text("light-group {}: no material, light or node of the scene is called so",
                         Printable(ToText({m_groups[i]}))));
    }

  private:
    const std::vector<LightGroupPatterns>& m_groups;
    const scene::SceneData& m_scene;
    std::vector<bool> m_fits;
};

}  // namespace

std::vector<LightGroupPatterns> ParseLightGroups(std::string_view text) {
    std::vector<LightGroupPatterns> groups;
    while (!text.empty()) {
        const size_t end = std::min(text.find(';'), text.size());
        LightGroupPatterns group = ParseGroup(text.substr(0, end));
        if (std::ranges::any_of(groups, [&](const auto& other) { return other.name == group.name; }))
            RejectGroup(text, Text("there are two groups of the name {}", group.name));
        groups.push_back(std::move(group));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    if (groups.size() > gpu::kMaxNamedLightGroups)
        throw MakeError(ErrorKind::Usage, "{} groups; at most {} can be told apart", groups.size(),
                        gpu::kMaxNamedLightGroups);
    return groups;
}

std::string ToText(const std::vector<LightGroupPatterns>& groups) {
    std::string text;
    for (const LightGroupPatterns& group : groups) {
        if (!text.empty()) text += ';';
        text += group.name;
        for (size_t i = 0; i < group.patterns.size(); ++i) text += (i == 0 ? '=' : ',') + group.patterns[i];
    }
    return text;
}

std::vector<std::string> LightGroupNames(const std::vector<LightGroupPatterns>& groups) {
    static_assert(gpu::kLightGroupRest == 0 && gpu::kLightGroupEnvironment == 1 &&
                  gpu::kLightGroupNamed == 2);
    if (groups.empty()) return {};
    std::vector<std::string> names{kRest, kEnvironment};
    for (const LightGroupPatterns& group : groups) names.push_back(group.name);
    return names;
}

LightGroups MatchLightGroups(const std::vector<LightGroupPatterns>& groups, const scene::SceneData& scene) {
    LightGroups found;
    found.namedCount = static_cast<uint32_t>(groups.size());
    if (groups.empty()) return found;
    Matcher matcher(groups, scene);
    for (const scene::Instance& instance : scene.instances)
        found.instances.push_back(matcher.OfNode(instance.node));
    for (const scene::Material& material : scene.materials)
        found.materials.push_back(matcher.OfName(material.name));
    for (const scene::Light& light : scene.lights)
        found.lights.push_back(FirstLightGroup(matcher.OfName(light.name), matcher.OfNode(light.node)));
    matcher.RequireAllMatched();
    return found;
}

}  // namespace raygraph::session
