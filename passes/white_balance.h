// White balance: shows the white of one light as the display's white. Colors are linear, with Rec. 709
// primaries, as everywhere. Threads: pure functions, for any thread.
#pragma once

#include <glm/glm.hpp>

#include "base/api.h"

namespace raygraph::passes {

// The range of WhitePointAt, in kelvin.
inline constexpr double kMinWhitePoint = 1000.0, kMaxWhitePoint = 25000.0;
// The display's white, CIE 1931 x and y of D65 (ITU-R BT.709).
inline constexpr double kDisplayWhitePoint = 6500.0;
inline constexpr double kDisplayWhite[2] = {0.3127, 0.3290};

// Returns CIE 1931 x and y of a light of this temperature: below 4000 K that of a black body, by the
// approximation of M. Krystek, "An Algorithm to Calculate Correlated Colour Temperature", Color Research and
// Application 10 (1985); from 4000 K on that of daylight (CIE 15, "Colorimetry"). kDisplayWhite at
// kDisplayWhitePoint. Error{Usage} beyond the range above.
RAYGRAPH_API glm::dvec2 WhitePointAt(double kelvin);

// Returns CIE 1931 x and y of a linear Rec. 709 color that is not black.
RAYGRAPH_API glm::dvec2 ChromaticityOf(const glm::dvec3& color);

// Returns the matrix for linear Rec. 709 radiance with which a color of the chromaticity `white` becomes
// neutral, with the same luminance: von Kries adaptation to D65 in Bradford's cone responses (K. M. Lam,
// "Metamerism and Colour Constancy", 1985; ISO 15076-1, annex E). The identity for kDisplayWhite.
RAYGRAPH_API glm::mat3 WhiteBalance(const glm::dvec2& white);

}  // namespace raygraph::passes
