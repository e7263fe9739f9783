// What the inspector shows of the fields of materials and lights, and what it makes of edits. Threads: pure
// functions.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <string_view>

#include "renderer/scene/fields.h"

namespace raygraph::editor {

// "baseColorFactor" as "base color".
std::string LabelOf(std::string_view name);

// Whether a material as it is shows what a field of this place and name says.
bool Counts(const scene::Material& material, std::string_view object, std::string_view key,
            std::string_view name);

// The widget of a number.
struct NumberStyle {
    float min = 0.0f, max = 0.0f;  // that it can be dragged or typed to
    bool isSlider = false;         // else it is dragged at a speed
    bool isAngle = false;          // the number in radians, shown in degrees
    bool isInfinite = false;       // not a number: the format shows a word, and there is nothing to drag
    std::string format;            // as of printf
};
NumberStyle StyleOf(float value, const scene::FieldRange& range, std::string_view unit, bool zeroIsInfinite);

// What a number that was infinite becomes: that of a new object, or 1 if that is infinite, too.
template <typename Owner>
float FiniteValue(const scene::Field<Owner, float>& field) {
    const float ofNew = Owner().*field.member;
    return ofNew != 0.0f ? ofNew : 1.0f;
}

// A vector that was asked for in the place of another: within the range, and above what is offered no more
// than it was.
template <int Length>
glm::vec<Length, float> Bounded(const glm::vec<Length, float>& before, const glm::vec<Length, float>& asked,
                                const scene::FieldRange& range) {
    using Vector = glm::vec<Length, float>;
    const Vector max = glm::min(glm::max(before, Vector(range.maxOffered)), Vector(range.max));
    return glm::clamp(asked, Vector(range.min), max);
}

}  // namespace raygraph::editor
