// Computes, without drawing, how the inspector shows the fields of materials and lights, which values edits
// give them, and a transform as numbers to edit. Threads: pure functions.
#pragma once

#include <glm/glm.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/scene/model/fields.h"

namespace raygraph::editor {

// Returns the label of a field: "base color" for "baseColorFactor".
std::string LabelOf(std::string_view name);

// Returns whether the field with this place and name affects the material.
bool Counts(const scene::Material& material, std::string_view object, std::string_view key,
            std::string_view name);

// Returns the group under which the inspector lists a field: "Base", "Emission", or that of an extension,
// "Clearcoat".
std::string GroupOf(std::string_view object, std::string_view name);
// Returns whether the material's fields of a group are all at their defaults, so that the group is shown
// closed.
bool IsUnused(const scene::Material& material, std::string_view group);

// Returns the channels that a material reads of a texture, by the texture's field; "" for no such field.
const char* ChannelsOf(std::string_view field);

// A color as a user sees and picks it, encoded in sRGB and at most 1, and its brightness above that: linear =
// brightness * decoded.
struct PickedColor {
    glm::vec3 encoded{0.0f};
    float brightness = 1.0f;
};
PickedColor ToPicked(const glm::vec3& linear);
glm::vec3 ToLinear(const PickedColor& color);

// A value as text for the clipboard: its numbers, which read back as the same, with spaces between them.
std::string ValueText(std::span<const float> value);
// Returns the numbers of such a text, also with commas or brackets; none if there is anything else.
std::vector<float> NumbersFrom(std::string_view text);

// Describes the widget of a number.
struct NumberStyle {
    float min = 0.0f, max = 0.0f;  // limits for dragging and typing
    bool isSlider = false;         // true: a slider; false: dragged at a speed
    bool isAngle = false;          // stored in radians, shown in degrees
    bool isInfinite = false;       // the format shows a word instead of a number, and nothing can be dragged
    std::string format;            // for printf
};
NumberStyle StyleOf(float value, const scene::FieldRange& range, std::string_view unit, bool zeroIsInfinite);

// Returns the value that replaces an infinite one: that of a new object, or 1 if that is infinite, too.
template <typename Owner>
float FiniteValue(const scene::Field<Owner, float>& field) {
    const float ofNew = Owner().*field.member;
    return ofNew != 0.0f ? ofNew : 1.0f;
}

// Returns `asked` clamped to the range; above the offered maximum, it can be no larger than `before`.
template <int Length>
glm::vec<Length, float> Bounded(const glm::vec<Length, float>& before, const glm::vec<Length, float>& asked,
                                const scene::FieldRange& range) {
    using Vector = glm::vec<Length, float>;
    const Vector max = glm::min(glm::max(before, Vector(range.maxOffered)), Vector(range.max));
    return glm::clamp(asked, Vector(range.min), max);
}

// Placement is a local transform as numbers that a user edits.
struct Placement {
    glm::vec3 translation{0.0f};
    glm::vec3 degrees{0.0f};  // rotations about x, then y, then z
    glm::vec3 scale{1.0f};    // lengths of the columns; x is negative for a mirroring transform
};

// For a transform with shear, the rotation is the one of its first axis and of the plane of its first two.
Placement PlacementOf(const glm::mat4x3& local);

// Applies to `local` the differences between `before`, its placement, and `after`. Equal parts of both keep
// their bits in the matrix, and shear is kept. A column of length 0 has none.
glm::mat4x3 Placed(const glm::mat4x3& local, const Placement& before, const Placement& after);

}  // namespace raygraph::editor
