// Tonemap: converts linear radiance to display values. White balance: the matrix with which it shows the
// white of one light as the display's white. Threads: Tonemap: that of the Renderer; white balance: pure
// functions, for any thread.
#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <optional>

#include "base/api.h"
#include "passes/backdrop.h"
#include "passes/tiles.h"
#include "renderer/graph/renderer.h"
#include "shaders/shared/choice.h"

namespace raygraph::passes {

struct TonemapSettings {
    float exposureEv = 0.0f;  // stops: radiance is multiplied with 2^exposureEv
    TonemapOperator tonemapOperator = TonemapOperator::Neutral;
    bool isOpaque = false;  // alpha is 1, not the radiance's
    // The color shown is that of what alpha covers: radiance, which is 0 for the rest of the pixel, is
    // divided by it. For formats whose alpha is not associated, as PNG.
    bool isUnassociated = false;
    glm::mat3 whiteBalance{1.0f};  // on the radiance: WhiteBalance

    bool operator==(const TonemapSettings&) const = default;
};

// Reads any float texture and returns rgba8, display-encoded (see shaders/core/tonemap.glsl for each
// operator), alpha passed through or 1. NaN and negative radiance show as black. With a backdrop, the picture
// is over it, opaque, mixed in linear light after the curve; the settings are taken as isUnassociated.
[[nodiscard]] RAYGRAPH_API TextureId Tonemap(Renderer& renderer, TextureId radiance,
                                             const TonemapSettings& settings = {},
                                             const std::optional<Backdrop>& backdrop = {});

// Writes into a region of `display`, rgba8; the rest of it stays. `radiance` may be of another extent: then
// it is scaled to that of the display, each pixel from the texel that it lies in. `onSubmitted` runs when the
// pass has been submitted, and never if it is culled or its frame dropped; it must not throw. Error{Usage}
// for another format, and a region outside of the display.
[[nodiscard]] RAYGRAPH_API TextureId TonemapInto(Renderer& renderer, TextureId radiance, TextureId display,
                                                 const Region& region, const TonemapSettings& settings = {},
                                                 std::function<void()> onSubmitted = {},
                                                 const std::optional<Backdrop>& backdrop = {});

// --- White balance ---
// Colors are linear, with Rec. 709 primaries, as everywhere.

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
