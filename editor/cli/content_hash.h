// Tells whether a scene or a picture is still the one that a render was made of. Not for security.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "renderer/image/image.h"
#include "renderer/scene/scene_data.h"

namespace raygraph::cli {

class ContentHash {
  public:
    void AddBytes(std::span<const std::byte> bytes);

    // Values without padding: vectors and matrices of numbers, numbers, enums.
    template <typename T>
    void Add(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        AddBytes(std::as_bytes(std::span(&value, 1)));
    }
    template <typename T>
    void Add(const std::vector<T>& values) {
        static_assert(std::is_trivially_copyable_v<T>);
        Add(uint64_t{values.size()});
        AddBytes(std::as_bytes(std::span(values)));
    }

    // Sixteen hexadecimal digits.
    std::string Text() const;

  private:
    uint64_t m_hash = 0x9E3779B97F4A7C15u;
};

// Of everything that the picture can depend on; not of names.
std::string HashOf(const scene::SceneData& scene);
std::string HashOf(const image::ImageF& image);

}  // namespace raygraph::cli
