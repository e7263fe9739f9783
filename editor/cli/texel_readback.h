// What was read back from the device, as values.
#pragma once

#include <cstring>
#include <vector>

#include "renderer/graph/renderer.h"

namespace raygraph::cli {

// Waits for it. T is the format's channel.
template <typename T>
std::vector<T> ValuesOf(const Readback& readback) {
    readback.Wait();
    const std::span<const std::byte> bytes = readback.Bytes();
    std::vector<T> values(bytes.size() / sizeof(T));
    std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
}

}  // namespace raygraph::cli
