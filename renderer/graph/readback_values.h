// Values that were read back from the device. Threads: as Readback.
#pragma once

#include <cstddef>
#include <span>
#include <type_traits>
#include <vector>

#include "renderer/graph/renderer.h"

namespace raygraph {

// Returns all values. T is a channel of the texture's format, a whole texel, or a record of the buffer, and
// Values is a vector of these. Throws Error{Usage} if the readback is not ready.
template <typename T, typename Values = std::vector<T>>
Values ValuesOf(const Readback& readback) {
    static_assert(std::is_trivially_copyable_v<T>);
    const std::span<const std::byte> bytes = readback.Bytes();
    const auto* const first = reinterpret_cast<const T*>(bytes.data());
    return Values(first, first + bytes.size() / sizeof(T));
}

// Waits for the readback and returns its values.
template <typename T, typename Values = std::vector<T>>
Values WaitForValues(const Readback& readback) {
    readback.Wait();
    return ValuesOf<T, Values>(readback);
}

// Returns one channel of texels with four channels.
template <typename T>
std::vector<T> ChannelOf(const std::vector<T>& texels, size_t channel) {
    std::vector<T> values(texels.size() / 4);
    for (size_t i = 0; i < values.size(); ++i) values[i] = texels[4 * i + channel];
    return values;
}

}  // namespace raygraph
