// Holds a picture beside the reference, with the noise of both and what is allowed, as the checks of the
// verdict see them. For editor/session/verify/ alone.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "editor/session/verify/difference.h"

namespace raygraph::session {

// Holds both pictures, cut where the picture is, and the bounds that each pixel has.
struct Compared {
    Extent2D size;
    Texels reference, picture;     // pixels that do not count are those of the reference in both
    Texels referenceNoise, noise;  // variances, of the reference and of the picture, at least those around
    // Sums over many pixels use the pixels' own variances. The noise of the reference times `noiseRatio`
    // would be that of as many samples as the picture has, if their number is known.
    Texels ownReferenceNoise, ownNoise;
    double noiseRatio = 0.0;
    // By how much less a picture that is cut at white may show on average, since its noise is cut; empty: no
    // picture is cut.
    std::vector<float> lostAtWhite;
    std::vector<float> relative;  // of each pixel; infinity: it does not count
    double floor = 0.0;           // a twentieth of the mean luminance
    double scale = 0.0;           // of JudgedAgainst
    size_t counted = 0;

    bool Counts(size_t pixel) const { return std::isfinite(relative[pixel]); }
    // Returns it for a value of a texel.
    double LostAtWhite(size_t i) const { return lostAtWhite.empty() ? 0.0 : lostAtWhite[i]; }
    std::vector<bool> Counting() const {
        std::vector<bool> counts(relative.size());
        for (size_t pixel = 0; pixel < counts.size(); ++pixel) counts[pixel] = Counts(pixel);
        return counts;
    }
    // Returns what the relative error of a channel of a pixel is over.
    double Scale(size_t pixel, size_t channel) const {
        if (scale > 0.0) return scale;
        const float* texel = &reference[4 * pixel];
        return std::max({std::abs(double{texel[channel]}), 0.25 * std::abs(LuminanceOf(texel)), floor});
    }
};

}  // namespace raygraph::session
