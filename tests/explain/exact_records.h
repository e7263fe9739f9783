// Checks that the records of a scene's paths are of the paths that its picture has.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>

#include "rhi/device.h"

namespace raygraph::testing {

struct RecordedPaths {
    size_t paths = 0;
    size_t vertices = 0;
    size_t lit = 0;  // paths that bring light
};

// Traces a sample of a picture of 16x12 pixels, and records the paths of nine of them: expects that the
// contributions of each sum to the pixel's value, to the bit.
RecordedPaths ExpectExactRecords(rhi::Device& device, const std::filesystem::path& scene, uint32_t sample);

}  // namespace raygraph::testing
