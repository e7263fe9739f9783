// A choice is one of several things under one name. It is stated once, as a list of lines:
//   #define RAYGRAPH_FRUITS(X, Of) X(Of, Apple, 0, "apple", "") X(Of, PlumTree, 1, "plum-tree", "sour")
// An enumerator, its number (counted from 0), what users call it (options, files, reports, the editor), and a
// note for the help. From the list follow
//   RAYGRAPH_CHOICE(Fruit, RAYGRAPH_FRUITS)
//       C++: enum class Fruit, Texts(Fruit{}), Notes(Fruit{}), Name(Fruit::Apple); Values<Fruit>()
//   RAYGRAPH_CHOICE_CONSTANTS(Fruit, RAYGRAPH_FRUITS)
//       GLSL, and C++ in namespace shading: kFruitApple, an unsigned number
// so that no code over a choice can lack one of its values. Threads: constants.
#ifndef RAYGRAPH_SHARED_CHOICE_H
#define RAYGRAPH_SHARED_CHOICE_H

#ifdef __cplusplus

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>

namespace raygraph {

constexpr bool IsCountedFromZero(std::initializer_list<uint32_t> values) {
    uint32_t count = 0;
    for (const uint32_t value : values)
        if (value != count++) return false;
    return true;
}

// All values of a choice, in their order.
template <typename Choice>
constexpr auto Values() {
    std::array<Choice, Texts(Choice{}).size()> values{};
    for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<Choice>(i);
    return values;
}

}  // namespace raygraph

// clang-format off
#define RAYGRAPH_CHOICE_ENUMERATOR_(Of, name, value, text, note) name = value,
#define RAYGRAPH_CHOICE_VALUE_(Of, name, value, text, note) value,
#define RAYGRAPH_CHOICE_TEXT_(Of, name, value, text, note) text,
#define RAYGRAPH_CHOICE_NOTE_(Of, name, value, text, note) note,
#define RAYGRAPH_CHOICE_CONSTANT_(Of, name, value, text, note) inline constexpr uint32_t k##Of##name = value;
// clang-format on

// Texts and Notes are by number; their argument only says of which choice.
#define RAYGRAPH_CHOICE(Enum, LIST)                                                     \
    enum class Enum : uint32_t { LIST(RAYGRAPH_CHOICE_ENUMERATOR_, Enum) };             \
    static_assert(::raygraph::IsCountedFromZero({LIST(RAYGRAPH_CHOICE_VALUE_, Enum)})); \
    constexpr auto Texts(Enum) {                                                        \
        return std::to_array<const char*>({LIST(RAYGRAPH_CHOICE_TEXT_, Enum)});         \
    }                                                                                   \
    constexpr auto Notes(Enum) {                                                        \
        return std::to_array<const char*>({LIST(RAYGRAPH_CHOICE_NOTE_, Enum)});         \
    }                                                                                   \
    constexpr const char* Name(Enum value) {                                            \
        return Texts(value)[static_cast<size_t>(value)];                                \
    }

#define RAYGRAPH_CHOICE_CONSTANTS(Of, LIST) \
    namespace shading {                     \
    LIST(RAYGRAPH_CHOICE_CONSTANT_, Of)     \
    }

#else

#define RAYGRAPH_CHOICE_CONSTANT_(Of, name, value, text, note) const uint k##Of##name = value;
#define RAYGRAPH_CHOICE_CONSTANTS(Of, LIST)                    LIST(RAYGRAPH_CHOICE_CONSTANT_, Of)

#endif

#endif
