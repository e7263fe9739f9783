// The fields of a struct, each stated once: its name, where glTF has it, and which numbers it may hold. Lists
// of them: scene_fields.h has all, of them those with places in scene_fields.h, scene_fields.h and
// scene_fields.h. For this project's own files; not installed. Threads: constants.
#pragma once

#include <algorithm>
#include <limits>
#include <string_view>
#include <tuple>
#include <type_traits>

#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

inline constexpr float kUnboundedField = std::numeric_limits<float>::max();

// Returns the nearest finite float.
inline float ToFloat(double number) {
    return static_cast<float>(std::clamp<double>(number, -kUnboundedField, kUnboundedField));
}

// Numbers of a field, of a vector each.
struct FieldRange {
    float min = 0.0f, max = 0.0f;
    bool mayBeZero = false;  // though it is below the minimum
    // The maximum that an editor offers, where a field itself has no limit or a higher one. Larger values of
    // files are kept.
    float maxOffered = kUnboundedField;

    constexpr bool HasMin() const { return min > -kUnboundedField; }
    constexpr bool HasMax() const { return max < kUnboundedField; }
};
inline constexpr FieldRange kShare{0.0f, 1.0f};
inline constexpr FieldRange kNotNegative{0.0f, kUnboundedField};
inline constexpr FieldRange kColorBesideStrength{0.0f, kUnboundedField, false, 1.0f};
inline constexpr FieldRange kAnyNumber{-kUnboundedField, kUnboundedField};

// The way in which the hash of a scene includes a field. Renders of scenes of equal hash are resumed and
// merged.
enum class Hashed : uint8_t {
    // Where it is not at its default, with a label before it: a struct may get such a field, and the hashes
    // of scenes without it stay. A flag with a label of its own is that label alone.
    IfChanged,
    Always,  // without a label, before all others of the struct
    Never,   // No picture depends on it, or it follows from others.
};

// Describes a field that has no place of its own in a file.
template <typename Owner, typename T, Hashed how>
struct NamedField {
    using Value = T;
    static constexpr Hashed kHashed = how;

    T Owner::*member;
    const char* name;
    const char* label;  // "": none. The name, unless older versions had another

    constexpr std::string_view Label() const { return label; }
};
template <Hashed how, typename Owner, typename T>
constexpr NamedField<Owner, T, how> Named(T Owner::*member, const char* name, const char* label = "") {
    return {member, name, label};
}

// Describes a field's name, and where it is. Its default is that of the struct.
template <typename Owner, typename T>
struct FieldPlace {
    using Value = T;
    static constexpr Hashed kHashed = Hashed::IfChanged;

    T Owner::*member;
    const char* name;
    // Where it is in the object that glTF has for an Owner: `key` of `object`, which is "" (that object), one
    // in it, an extension, or "extras". Of a flag without a key: whether the object is there. A key may go
    // down a level, to what is in a texture of an extension: "clearcoatNormalTexture.scale".
    const char* object;
    const char* key;

    constexpr std::string_view Label() const { return name; }
};

template <typename Owner, typename T>
struct Field : FieldPlace<Owner, T> {
    FieldRange range = {};   // of float and vectors
    const char* unit = "";   // "": a pure number
    bool omitsZero = false;  // glTF has no number for what 0 means here

    constexpr bool ZeroIsInfinite() const { return omitsZero || range.mayBeZero; }
};

// Holds the parts of a key: "a" and "b" of "a.b"; "" and "b" of "b".
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

// Converts to any type, without a definition: it serves to count fields.
struct AnyValue {
    template <typename T>
    operator T() const;
};

// Returns how many fields a struct without constructors has.
template <typename T, typename... Values>
constexpr size_t FieldCount() {
    if constexpr (requires { T{Values{}..., AnyValue{}}; })
        return FieldCount<T, Values..., AnyValue>();
    else
        return sizeof...(Values);
}

// Tells whether these are all fields of T.
template <typename T, typename... Members>
constexpr bool IsEachFieldOf(Members... members) {
    const auto isSame = [](auto a, auto b) {
        if constexpr (std::is_same_v<decltype(a), decltype(b)>)
            return a == b;
        else
            return false;
    };
    const auto listedCount = [&](auto member) { return (size_t{isSame(member, members)} + ...); };
    return sizeof...(Members) == FieldCount<T>() && ((listedCount(members) == 1) && ...);
}

}  // namespace raygraph::scene
