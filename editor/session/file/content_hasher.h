// ContentHasher hashes the contents of a scene for content_hash.h. Not installed. Whoever changes what is
// hashed raises kFormat in render_file_parts.h. Threads: exclusive access.
#pragma once

#include <concepts>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <vector>

#include "renderer/scene/model/scene_fields.h"

namespace raygraph::session {

// Accepts a number, or a vector or matrix of numbers: it has no padding.
template <typename T>
concept Plain = std::is_arithmetic_v<T> || std::is_enum_v<T> || requires {
    typename T::value_type;
    { T::length() } -> std::convertible_to<int>;
};

class ContentHasher {
  public:
    ContentHasher();
    ~ContentHasher();

    // Returns sixteen hexadecimal digits.
    std::string Text() const;

    void Add(const Plain auto& value) { AddBytes(&value, sizeof value); }
    void Add(std::string_view text) { AddRun(std::span(text)); }
    template <typename T>
    void Add(const std::optional<T>& value) {
        Add(value.has_value());
        if (value) Add(*value);
    }
    template <typename T>
    void Add(const std::vector<T>& values) {
        if constexpr (Plain<T>) {
            AddRun(std::span(values));
        } else {
            Add(uint64_t{values.size()});
            for (const T& value : values) Add(value);
        }
    }

    // Hashes a struct of a scene by the list of its fields (scene::Hashed).
    template <scene::HasFields Owner>
    void Add(const Owner& owner) {
        scene::ForEachField<Owner>([&](const auto& field) {
            if constexpr (std::decay_t<decltype(field)>::kHashed == scene::Hashed::Always)
                Add(owner.*field.member);
        });
        AddChanged(owner, scene::Fields<Owner>::kAll);
        if constexpr (std::is_same_v<Owner, scene::Primitive>)
            if (owner.hasFlatNormals && (!owner.influences.IsEmpty() || !owner.targets.empty()))
                Add(std::string_view("flat"));
    }

    // Hashes those fields of a list that differ from their defaults. An empty label ends a list that has
    // fields of a file.
    template <typename Owner, typename... Fields>
    void AddChanged(const Owner& owner, const std::tuple<Fields...>& fields) {
        std::apply([&](const auto&... field) { (AddIfChanged(owner, field), ...); }, fields);
        if constexpr ((requires { Fields::object; } || ...)) Add(std::string_view());
    }

    // Hashes the label and the field if it is hashed this way and is not at its default.
    template <typename Owner, typename Field>
    void AddIfChanged(const Owner& owner, const Field& field) {
        static const Owner kDefault;
        if constexpr (Field::kHashed == scene::Hashed::IfChanged) {
            const auto& value = owner.*field.member;
            if (IsAtDefault(value, kDefault.*field.member)) return;
            const std::string_view label = field.Label();
            if (!label.empty()) Add(label);
            if (!std::is_same_v<typename Field::Value, bool> || label == field.name) Add(value);
        }
    }

  private:
    // Returns whether a list or a nested object is at its default, which means empty.
    template <typename T>
    static bool IsAtDefault(const T& value, const T& atDefault) {
        if constexpr (requires { value.empty(); })
            return value.empty();
        else if constexpr (requires { value.IsEmpty(); })
            return value.IsEmpty();
        else if constexpr (requires { value == atDefault; })
            return value == atDefault;
        else
            return !value.IsPresent();
    }

    // Hashes the length, too, so that values cannot move between adjacent lists unnoticed.
    template <typename T>
    void AddRun(std::span<T> values) {
        Add(uint64_t{values.size()});
        AddBytes(values.data(), values.size_bytes());
    }

    void AddBytes(const void* bytes, size_t size);

    struct State;
    std::unique_ptr<State> m_state;
};

}  // namespace raygraph::session
