// The fields of a Light that a file has of it and an editor may change, as material_fields.h those of a
// Material: for the importer, the saver, Check, comparisons and the editor's inspector. Threads: constants.
#pragma once

#include <glm/gtc/constants.hpp>
#include <string_view>

#include "renderer/scene/model/fields.h"

namespace raygraph::scene {

namespace light_fields {

using L = Light;
using Number = Field<L, float>;
inline constexpr const char* kSpot = "spot";
// A rounded pi/2 may be a little above it.
inline constexpr FieldRange kConeAngle{0.0f, glm::half_pi<float>() + 1e-5f};

// In the order of Light. What is in an object of its own, `kSpot`, is of spot lights alone.
inline constexpr auto kAll = std::tuple{
    Field<L, glm::vec3>{{&L::color, "color", "", "color"}, kColorBesideStrength},
    Number{{&L::intensity, "intensity", "", "intensity"}, kNotNegative, "cd"},
    Number{{&L::range, "range", "", "range"}, kNotNegative, "m", true},
    Number{{&L::innerConeAngle, "innerConeAngle", kSpot, "innerConeAngle"}, kConeAngle, "rad"},
    Number{{&L::outerConeAngle, "outerConeAngle", kSpot, "outerConeAngle"}, kConeAngle, "rad"},
};

}  // namespace light_fields

// Returns whether a light of `type` has a field. A directional one is at no place that a range could be
// around.
template <typename T>
constexpr bool HasField(LightType type, const Field<Light, T>& field) {
    if constexpr (std::is_same_v<T, float>)
        if (field.member == &Light::range) return type != LightType::Directional;
    return *field.object == 0 || type == LightType::Spot;
}

// Calls visit(field) for each that a light of `type` has, in the order of Light.
template <typename Visit>
constexpr void ForEachLightField(LightType type, Visit&& visit) {
    const auto look = [&](const auto& field) {
        if (HasField(type, field)) visit(field);
    };
    std::apply([&](const auto&... field) { (look(field), ...); }, light_fields::kAll);
}

// Calls visit(field) for each field of a light. A light with a profile has a factor and a color only.
template <typename Visit>
constexpr void ForEachLightField(const Light& light, Visit&& visit) {
    const auto look = [&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), float Light::*>)
            if (light.profile != kNone && field.member == &Light::range) return;
        visit(field);
    };
    ForEachLightField(light.type, look);
}

// The unit of a field of a light of `type`: the intensity of a directional one is what arrives.
template <typename T>
constexpr std::string_view UnitOf(const Field<Light, T>& field, LightType type) {
    const std::string_view unit = field.unit;
    return unit == "cd" && type == LightType::Directional ? "lx" : unit;
}

// The intensity of one with a profile is a factor.
template <typename T>
constexpr std::string_view UnitOf(const Field<Light, T>& field, const Light& light) {
    const std::string_view unit = UnitOf(field, light.type);
    return unit == "cd" && light.profile != kNone ? "" : unit;
}

// The one of a member.
template <typename T>
constexpr auto FieldOf(T Light::*member) {
    return FindField(member, light_fields::kAll);
}

// The rule that ranges cannot express: the outer cone of a spot light contains the inner one.
inline bool HasCone(const Light& light) {
    return light.type != LightType::Spot || light.innerConeAngle < light.outerConeAngle;
}
inline constexpr const char* kConeRule = "innerConeAngle must be below outerConeAngle";

}  // namespace raygraph::scene
