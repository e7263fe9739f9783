// The verdict on a picture: it is right if it differs from the reference by no more than the noise of both
// and a stated tolerance. Threads: pure functions, but for Judge, whose thread is that of the Renderer.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/api.h"
#include "editor/session/verify/difference.h"
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
    std::string where = {};  // what the value is of; "": the picture
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
    // More samples of the reference would not change the verdict: the picture is not right, or each check
    // would end alike without the noise of the reference.
    bool isDecided = false;
    std::vector<VerdictCheck> checks;
    std::vector<VerdictTile> tiles;         // all of each size, row by row
    std::vector<Projection> projections;    // what noise does not explain, the largest error first
    std::vector<VerdictPixel> worstPixels;  // at most 16, worst first, none beside another
    PictureDifference difference;           // of the pixels that count; others are those of the reference
    double flipOfNoise = 0.0, ssimOfNoise = 1.0;
    bool isNoiseEstimated = false;  // the noise of the picture is not known and was estimated
};

// Holds what a picture is judged by.
struct JudgedAgainst {
    const Picture& reference;  // without variance it counts as exact
    Tolerance tolerance;
    // Tolerance::relative of each pixel; empty: the same for all. Infinity: the pixel does not count.
    std::vector<float> relative = {};
    float exposureEv = 0.0f;  // for FLIP and SSIM
    // The reference with its AOVs, of whose parts there are projections; null: only of the whole.
    const RenderFile* render = nullptr;
    SceneNames names = {};
};

// Throws Error{BadInput} as Difference does, and if no pixel counts.
//
// A tile passes if in each channel |mean difference| <= tolerance + k standard errors, where k is so large
// that all tiles of a right picture pass with a probability of 0.99 (Sidak) if errors are normal; a pixel,
// with k = 4. The variance of a pixel is at least the mean around it, 5 x 5 pixels, and that of a picture
// with a known number of samples at least that of as many samples of the reference: few samples often miss
// what varies. Without a known variance that of independent noise is estimated in each tile from second
// differences of picture - reference along both axes, by their median. FLIP and SSIM are compared with those
// of the reference against itself with normal noise of these variances added.
RAYGRAPH_API Verdict Judge(Renderer& renderer, const Picture& picture, const JudgedAgainst& against);

// Returns the variance of the picture's noise by the rules above; the variance of the reference is apart.
RAYGRAPH_API Texels NoiseOf(const Picture& picture, const Picture& reference, bool& isEstimated);

}  // namespace raygraph::session
