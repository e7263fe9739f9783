// The noise of a picture beside a reference whose noise is known. Threads: pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/api.h"
#include "editor/session/verify/picture.h"

namespace raygraph::session {

// An estimate never gives a picture more noise than so many samples a pixel of the reference have.
inline constexpr double kLeastPictureSamples = 8.0;

struct PictureNoise {
    // Variances of the radiance, w is 0: `own` of each pixel, `variance` at least that around it.
    Texels variance, own;
    // The number of samples of the reference with this noise; 0: the picture has its own, or none.
    double samples = 0.0;
    bool isEstimated = false;  // `samples` was
};

// Returns the noise of the picture, the reference's apart. What is known is used: the picture's variance, but
// at least that of as many samples of the reference, since few samples often miss what varies; or `samples` a
// pixel of the reference, 0 for a picture without noise.
//
// Without either the number of samples is estimated, one for the whole picture: the noise has the shape of
// the reference's. Its amount is what second differences of picture - reference along both axes have, as a
// mean over tiles of 16 x 16 and then the median of tiles, which a mistake in some does not move. Noise of
// independent pixels has as much at any distance of the pixels that are subtracted. A pattern has not: from
// distances of 1 to 4 pixels the least counts, so that checkerboards and grids are no noise. Twice as much
// is allowed, since the noise of paths is skewed, and its median below its mean. Pixels that do not count
// (`relative` of JudgedAgainst) have no part in it, and without a variance of the reference there is no
// noise. Rounding to eight bits is added.
RAYGRAPH_API PictureNoise NoiseOf(const Picture& picture, const Picture& reference,
                                  const std::vector<float>& relative = {},
                                  std::optional<uint32_t> samples = std::nullopt);

// Returns variances that are at least their mean over 5 x 5 pixels.
RAYGRAPH_API Texels AtLeastAround(Texels variance, Extent2D size);

}  // namespace raygraph::session
