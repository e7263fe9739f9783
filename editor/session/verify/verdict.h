// The verdict on a picture: it is right if it differs from the reference by no more than the noise of both
// and a stated tolerance. Threads: pure functions, but for Judge, whose thread is that of the Renderer.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/api.h"
#include "editor/session/verify/difference.h"
#include "editor/session/verify/picture_noise.h"
#include "editor/session/verify/projections.h"

namespace raygraph::session {

// States what a right picture may differ by, beyond the noise. Relative errors are those of the radiance of a
// channel over that of the reference, or over a quarter of its luminance or a twentieth of the picture's
// mean, where these are larger.
struct Tolerance {
    double relative = 0.05;  // of a tile's mean, and of a pixel
    double tiles = 0.01;     // share of the tiles of a size that may be beyond
    double pixels = 0.02;    // share of the pixels that may be beyond
    double energy = 0.02;    // relative, of the mean of the picture
    double parts = 0.05;     // relative, along each Projection
    double flip = 0.05;      // above what noise explains
    double ssim = 0.05;      // below what noise explains

    bool operator==(const Tolerance&) const = default;
};

// Tiles are squares of so many pixels a side, of two sizes; those at the right and lower edges may be
// smaller.
inline constexpr std::array<uint32_t, 2> kVerifyTiles{16, 8};

// Is one of the conditions that a right picture meets.
struct VerdictCheck {
    std::string name;  // as the member of Tolerance
    double value = 0.0, limit = 0.0;
    bool isPassed = true;
    std::string where = {};  // what the value is of, and where; "": the picture
};

struct VerdictTile {
    uint32_t x = 0, y = 0, width = 0, height = 0;  // pixels
    double relativeError = 0.0;                    // of the channel that is off most
    double z = 0.0;                                // difference over its standard error; that channel's
    double excess = 0.0;                           // difference over the bound: above 1, the tile is beyond
};

struct VerdictPixel {
    uint32_t x = 0, y = 0;
    double excess = 0.0;  // as of a tile
    std::array<float, 3> reference{}, picture{};
};

struct Verdict {
    bool isRight = false;
    // More samples of the reference would hardly change the verdict: each check passes with the noise of the
    // reference taken off its limit, or one fails with that noise added to it.
    bool isDecided = false;
    std::vector<VerdictCheck> checks;
    std::vector<VerdictTile> tiles;         // all of each size, row by row
    std::vector<Projection> projections;    // what noise does not explain, the largest error first
    std::vector<VerdictPixel> worstPixels;  // at most 16, worst first, none beside another
    PictureDifference difference;           // of the pixels that count; others are those of the reference
    double flipOfNoise = 0.0, ssimOfNoise = 1.0;
    bool isNoiseEstimated = false;  // the noise of the picture is not known and was estimated
    double pictureSamples = 0.0;    // PictureNoise::samples
};

// Holds what a picture is judged by.
struct JudgedAgainst {
    const Picture& reference;  // without variance it counts as exact
    Tolerance tolerance;
    // Tolerance::relative of each pixel; empty: the same for all. Infinity: the pixel does not count.
    std::vector<float> relative = {};
    float exposureEv = 0.0f;                      // for FLIP and SSIM
    std::optional<uint32_t> pictureSamples = {};  // of NoiseOf
    // Errors of all pixels are relative to this for values that are no light, such as vectors, and have no
    // energy. 0: they are relative to the radiance.
    double scale = 0.0;
    // The reference with its AOVs, of whose parts there are projections; null: only of the whole.
    const RenderFile* render = nullptr;
    SceneNames names = {};
};

// Throws Error{BadInput} as Difference does, and if no pixel counts.
//
// A tile passes if in each channel |mean difference| <= tolerance + k standard errors, where k is so large
// that all tiles of a right picture pass with a probability of 0.99 (Sidak) if errors are normal; a pixel,
// with k = 4. The noise of the picture is NoiseOf. FLIP and SSIM are compared with those of the reference
// against itself with normal noise of these variances added. A pixel that is NaN or infinite fails the check
// `nonfinite`, and counts as black.
RAYGRAPH_API Verdict Judge(Renderer& renderer, const Picture& picture, const JudgedAgainst& against);

// Returns the picture with black pixels for those that are NaN or infinite.
RAYGRAPH_API Picture WithoutNonFinite(Picture picture);

}  // namespace raygraph::session
