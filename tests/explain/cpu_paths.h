// Follows the paths of a picture on the device and on the host (editor/session/cpu/trace.h), and compares them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <iosfwd>

#include "editor/session/settings/picture_settings.h"
#include "editor/session/settings/scene_input.h"
#include "rhi/device.h"

namespace raygraph::testing {

struct ComparedPaths {
    size_t paths = 0;
    size_t vertices = 0;
    size_t lit = 0;  // paths that bring light, on the host
    // Paths that meet other surfaces, draw other lobes or end otherwise.
    size_t different = 0;
    // Of the others: those whose values differ by more than rounding; and the median of the relative
    // differences of those that bring light.
    size_t apart = 0;
    double medianDifference = 0.0;
    glm::dvec3 deviceMean{0.0}, cpuMean{0.0};
};

// Follows one sample of each pixel.
ComparedPaths ComparePaths(rhi::Device& device, session::SceneInput input, session::PictureSettings settings,
                           uint32_t sample);

inline constexpr double kMostPathsApart = 0.01;

// Expects that at most this share of the paths differs, as where a random number is at a threshold, that the
// values of the others agree to rounding (but for the same share), and that the means of the pictures do.
void ExpectSamePaths(const ComparedPaths& compared, double mostApart = kMostPathsApart);

std::ostream& operator<<(std::ostream& out, const ComparedPaths& compared);

}  // namespace raygraph::testing
