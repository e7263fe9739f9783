// PictureDifference says how two pictures of one view differ: in numbers that the field uses, and as
// pictures.
//
// Threads: that of the Renderer, and pure functions where there is none.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "base/api.h"
#include "editor/session/verify/picture.h"
#include "renderer/graph/renderer.h"
#include "renderer/image/image.h"

namespace raygraph::session {

// Scores picture - reference against the noise of both. Where noise is all that they differ by, and has the
// stated variance, `rms` is 1, `beyondThree` 0.0027, and `ofMean` is normal with deviation 1. Variances are
// those of independent samples: of Sobol points, `rms` is below 1.
struct ZScores {
    double rms = 0.0;                  // over the values with noise, R, G and B of all pixels
    double beyondThree = 0.0;          // share of |z| > 3 of these
    uint64_t differsWithoutNoise = 0;  // values that differ although neither picture has noise there
    bool isOfBoth = true;              // the variances of both pictures are known
    std::array<double, 3> ofMean{};    // of the mean over the picture
};

struct PictureDifference {
    // Mean of (picture - reference)^2 / (reference^2 + 0.01) over pixels and channels, and what the noise of
    // both pictures adds to it, as far as their variances are known.
    double relMse = 0.0, relMseOfNoise = 0.0;
    double flip = 0.0;  // passes::Flip: mean over the picture
    double ssim = 0.0;  // Wang et al. 2004, of luminance in sRGB, Gaussian windows of sigma 1.5
    // Means over the picture, linear.
    std::array<double, 3> meanOfReference{}, mean{};
    std::optional<ZScores> z;    // if a variance is known
    std::vector<float> flipMap;  // of each pixel
};

// FLIP and SSIM are those of the pictures on a display, both with this exposure, cut at 1 and encoded in
// sRGB. Where the picture has a `white`, both are cut there. Means are over the pixels that `counts` has;
// empty: over all. Throws as RequireComparable does, and Error{BadInput} for a pixel that is NaN or infinite.
RAYGRAPH_API PictureDifference Difference(Renderer& renderer, const Picture& reference,
                                          const Picture& picture, float exposureEv = 0.0f,
                                          const std::vector<bool>& counts = {});

// Throws Error{BadInput} that names both for pictures of two sizes, of no pixel, or larger than the device's
// textures.
RAYGRAPH_API void RequireComparable(const Renderer& renderer, const Picture& reference,
                                    const Picture& picture);

// Returns the radiance with everything above `white` cut.
RAYGRAPH_API Texels CutAt(Texels radiance, float white);

struct FlipOfPictures {
    std::vector<float> map;
    double mean = 0.0;
};
RAYGRAPH_API FlipOfPictures FlipOf(Renderer& renderer, const Texels& reference, const Texels& picture,
                                   Extent2D size, float exposureEv, const std::vector<bool>& counts = {});
RAYGRAPH_API double SsimOf(const Texels& reference, const Texels& picture, Extent2D size, float exposureEv,
                           const std::vector<bool>& counts = {});

// --- Pictures for people: opaque, sRGB ---

RAYGRAPH_API image::Image8 ShowRadiance(Renderer& renderer, const Texels& radiance, Extent2D size,
                                        float exposureEv);
// Shows values by HeatColor (shaders/core/ramp.glsl): 0 is dark, `maximum` and above light.
RAYGRAPH_API image::Image8 ShowHeat(Renderer& renderer, const std::vector<float>& values, Extent2D size,
                                    float maximum);
// Returns log2 of the luminance of the picture over that of the reference, both at least `floor`.
RAYGRAPH_API std::vector<float> StopsBetween(const Texels& reference, const Texels& picture, float floor);
// Shows stops: white where there is no difference, red where the picture is brighter, blue where it is
// darker, dark at `maximum` and beyond.
RAYGRAPH_API image::Image8 ShowStops(const std::vector<float>& stops, Extent2D size, float maximum);

// Returns the luminance of Rec. 709 of a texel.
inline float LuminanceOf(const float* texel) {
    return 0.2126f * texel[0] + 0.7152f * texel[1] + 0.0722f * texel[2];
}

}  // namespace raygraph::session
