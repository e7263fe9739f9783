// Lookup of one element of a list by the text that a user gives: its name, else its index. Internal to
// renderer/scene.
#pragma once

#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/printable.h"
#include "base/text.h"

namespace raygraph::scene {

// Parses all of `text` as a number; returns false if that fails.
template <typename Number>
bool IsNumber(std::string_view text, Number& value) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size();
}

// Returns the first thing of that name, which is not empty, else that of this index as decimal digits.
// Otherwise Error{BadInput}: "there is no variant "x"; the scene has 0 "red", 1 "blue"", as far as they fit a
// line, or `none` where the list is empty.
template <typename List, typename NameOf>
uint32_t FindNamed(const List& list, std::string_view choice, const char* kind, const char* none,
                   NameOf&& nameOf) {
    for (uint32_t i = 0; i < list.size(); ++i)
        if (!choice.empty() && nameOf(list[i]) == choice) return i;
    uint32_t index = 0;
    if (IsNumber(choice, index) && index < list.size()) return index;
    constexpr size_t kMaxListed = 20, kMaxNameBytes = 60;
    std::string names;
    for (size_t i = 0; i < list.size() && i < kMaxListed; ++i)
        names += Text("{} {} {}", i == 0 ? "" : ",", i, Quoted(nameOf(list[i]), kMaxNameBytes));
    if (list.size() > kMaxListed) names += Text(" and {} more", list.size() - kMaxListed);
    throw MakeError(ErrorKind::BadInput, "there is no {} {}; the scene has{}", kind, Quoted(choice),
                    list.empty() ? none : names);
}

}  // namespace raygraph::scene
