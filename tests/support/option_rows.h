// Keeps a table of options complete: a row for each field of a struct of settings, and for each value of its
// enumerations.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

namespace raygraph::testing {

// Returns whether an enumeration has a name for this value.
template <auto value>
constexpr bool IsEnumerator() {
    // GCC and Clang write a value without a name as a cast: "= (Kind)7"
    const std::string_view text = __PRETTY_FUNCTION__;
    return text[text.rfind("= ") + 2] != '(';
}

// Returns how many of the values 0 to 31 an enumeration names.
template <typename Enum>
constexpr size_t EnumeratorCount() {
    return []<size_t... value>(std::index_sequence<value...>) {
        return (size_t{0} + ... + size_t{IsEnumerator<static_cast<Enum>(value)>()});
    }
    (std::make_index_sequence<32>());
}

// Records which fields the rows of a table have changed. `fields` binds a Settings& to a tuple of references
// by structured bindings: a field added to the struct does not compile there until it is named.
template <typename Settings, typename Fields>
class OptionRows {
  public:
    explicit OptionRows(Fields fields) : m_fields(fields) {}

    // A row, as the settings before and after it: it changes one field.
    void Add(const std::string& name, Settings before, Settings after) {
        auto a = m_fields(before), b = m_fields(after);
        size_t changed = 0;
        ForEachField([&](auto index) {
            auto &valueBefore = std::get<index>(a), &valueAfter = std::get<index>(b);
            Note(m_values[index], valueBefore);
            Note(m_values[index], valueAfter);
            if (IsSame(valueBefore, valueAfter)) return;
            ++changed;
            ++m_rowCounts[index];
        });
        EXPECT_EQ(changed, 1u) << "the row \"" << name << "\" is to change one field";
    }

    // Every field has a row, and every enumeration has been seen with each of its values.
    void ExpectComplete() {
        ForEachField([&](auto index) {
            using Field = std::remove_reference_t<std::tuple_element_t<index, Tuple>>;
            EXPECT_GT(m_rowCounts[index], 0u) << "field " << index << " has no row";
            if constexpr (std::is_enum_v<Field>) {
                EXPECT_EQ(m_values[index].size(), EnumeratorCount<Field>())
                    << "field " << index << ": a value has no row";
            }
        });
    }

  private:
    using Tuple = decltype(std::declval<Fields>()(std::declval<Settings&>()));
    static constexpr size_t kCount = std::tuple_size_v<Tuple>;

    template <typename Visit>
    static void ForEachField(Visit&& visit) {
        [&]<size_t... index>(std::index_sequence<index...>) {
            (visit(std::integral_constant<size_t, index>()), ...);
        }
        (std::make_index_sequence<kCount>());
    }
    template <typename T>
    static void Note(std::set<int64_t>& values, const T& value) {
        if constexpr (std::is_enum_v<T>) values.insert(static_cast<int64_t>(value));
    }
    template <typename T>
    static bool IsSame(const T& a, const T& b) {
        if constexpr (requires { a == b; })
            return a == b;
        else
            return std::memcmp(&a, &b, sizeof(T)) == 0;
    }

    Fields m_fields;
    std::array<size_t, kCount> m_rowCounts{};
    std::array<std::set<int64_t>, kCount> m_values;
};

template <typename Settings, typename Fields>
OptionRows<Settings, Fields> OptionRowsOf(Fields fields) {
    return OptionRows<Settings, Fields>(fields);
}

}  // namespace raygraph::testing
