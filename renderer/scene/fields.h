// The fields of a struct, each stated once: its name, where glTF has it, and which numbers it may hold. Lists
// of them: material_fields.h, light_fields.h. For this project's own files; not installed. Threads:
// constants.
#pragma once

#include <limits>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "renderer/scene/scene_data.h"

namespace raygraph::scene {

inline constexpr float kUnboundedField = std::numeric_limits<float>::max();

// Numbers of a field, of a vector each.
struct FieldRange {
    float min = 0.0f, max = 0.0f;
    bool mayBeZero = false;  // though it is below the minimum
    // What an editor offers, where more has a field of its own; a file's more is kept.
    float maxOffered = kUnboundedField;

    constexpr bool HasMin() const { return min > -kUnboundedField; }
    constexpr bool HasMax() const { return max < kUnboundedField; }
};
inline constexpr FieldRange kShare{0.0f, 1.0f};
inline constexpr FieldRange kNotNegative{0.0f, kUnboundedField};
inline constexpr FieldRange kColorBesideStrength{0.0f, kUnboundedField, false, 1.0f};
inline constexpr FieldRange kAnyNumber{-kUnboundedField, kUnboundedField};

// A field's name, and where it is. Its default is that of the struct.
template <typename Owner, typename T>
struct FieldPlace {
    using Value = T;

    T Owner::*member;
    const char* name;
    // Where it is in the object that glTF has for an Owner: `key` of `object`, which is "" (that object), one
    // in it, an extension, or "extras". Of a flag without a key: whether the object is there. A key may go
    // down a level, to what is in a texture of an extension: "clearcoatNormalTexture.scale".
    const char* object;
    const char* key;
};

template <typename Owner, typename T>
struct Field : FieldPlace<Owner, T> {
    FieldRange range = {};       // of float and vectors
    const char* unit = "";       // "": a pure number
    bool zeroIsLeftOut = false;  // glTF has no number for what 0 means here

    constexpr bool ZeroIsInfinite() const { return zeroIsLeftOut || range.mayBeZero; }
};

// The parts of a key: "a" and "b" of "a.b"; "" and "b" of "b".
struct KeyParts {
    std::string_view object, key;
};
constexpr KeyParts KeyPartsOf(std::string_view key) {
    const size_t dot = key.find('.');
    if (dot == key.npos) return {"", key};
    return {key.substr(0, dot), key.substr(dot + 1)};
}

// The one of a member in a list, which is a tuple. No constant if there is none. (Not consteval: clang 14
// does not compile the temporaries of such functions.)
template <typename Owner, typename T, typename List>
constexpr auto FindField(T Owner::*member, const List& list) {
    return std::apply(
        [&](const auto&... fields) {
            using Found = typename std::tuple_element_t<
                0, decltype(std::tuple_cat(
                       std::conditional_t<std::is_same_v<decltype(fields.member), T Owner::*>,
                                          std::tuple<std::decay_t<decltype(fields)>>, std::tuple<>>{}...))>;
            const Found* found = nullptr;
            const auto look = [&](const auto& field) {
                if constexpr (std::is_same_v<decltype(field.member), T Owner::*>)
                    if (field.member == member) found = &field;
            };
            (look(fields), ...);
            return *found;
        },
        list);
}

}  // namespace raygraph::scene
