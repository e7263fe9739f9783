// glTF's names of the values of a choice (shaders/shared/choice.h), which are its notes. Internal to
// renderer/scene. Threads: constants and pure functions.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

template <typename Choice>
inline constexpr auto kGltfNames = [] {
    constexpr auto kNotes = Notes(Choice{});
    std::array<std::string_view, kNotes.size()> names;
    for (size_t i = 0; i < names.size(); ++i) names[i] = kNotes[i];
    return names;
}();

template <typename Choice>
constexpr std::string_view GltfName(Choice value) {
    return kGltfNames<Choice>[static_cast<size_t>(value)];
}

// Reads the value of a name; leaves it as it is for a name that is none of them, which the schema rejects.
template <typename Choice>
constexpr void ReadChoice(std::string_view name, Choice& value) {
    for (const Choice known : Values<Choice>())
        if (GltfName(known) == name) value = known;
}

}  // namespace raygraph::scene
