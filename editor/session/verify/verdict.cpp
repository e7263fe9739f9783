#include "editor/session/verify/verdict.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/text.h"
#include "editor/session/settings/parse.h"
#include "editor/session/verify/compared.h"
#include "editor/session/verify/projections.h"

namespace raygraph::session {

namespace {

constexpr double kPixelDeviations = 4.0, kMeanDeviations = 4.0;
constexpr size_t kWorstPixels = 16;

// Returns numbers of a standard normal distribution that depend on the index alone (Box and Muller 1958).
float NormalAt(uint64_t index) {
    const auto mixed = [](uint64_t x) {  // SplitMix64, Steele et al. 2014
        x += 0x9e3779b97f4a7c15ull;
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
        x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
        return x ^ (x >> 31);
    };
    const double u = (double(mixed(2 * index) >> 11) + 0.5) * 0x1p-53,
                 v = double(mixed(2 * index + 1) >> 11) * 0x1p-53;
    return static_cast<float>(std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * std::numbers::pi * v));
}

struct Failures {
    double tiles = 0.0, pixels = 0.0, energy = 0.0;  // shares, and the relative error beyond the noise
};

// How much noise bounds allow for: that of both pictures; or as much as makes it certain, by the noise of the
// reference, that a check which passes would do so beside an exact reference, or that one which fails would.
enum class NoiseOfBounds { Both, ForRight, ForWrong };

// Two standard errors of one number are what it is certain by. That one of many is beyond its bound is less
// so, and takes as many as the bound has.
constexpr double kCertainDeviations = 2.0;

double NoiseBound(NoiseOfBounds of, double deviations, double ofPicture, double ofReference) {
    switch (of) {
        case NoiseOfBounds::Both:
            return deviations * std::sqrt(ofPicture + ofReference);
        case NoiseOfBounds::ForRight:
            return deviations * std::sqrt(ofPicture) - kCertainDeviations * std::sqrt(ofReference);
        case NoiseOfBounds::ForWrong:
            return deviations * (std::sqrt(ofPicture) + std::sqrt(ofReference));
    }
    return 0.0;
}

// Judges tiles, pixels and the mean.
class Judging {
  public:
    Judging(const Compared& all, NoiseOfBounds of) : m_all(all), m_of(of) {
        size_t tiles = 0;
        for (const uint32_t side : kVerifyTiles)
            tiles += size_t{(all.size.width + side - 1) / side} * ((all.size.height + side - 1) / side);
        m_deviations = SidakDeviations(3 * tiles, 0.01);
    }

    Failures Run(Verdict* verdict) {
        for (const uint32_t side : kVerifyTiles) {
            const bool isFirst = side == kVerifyTiles.front();
            size_t tiles = 0, beyond = 0;
            for (uint32_t y = 0; y < m_all.size.height; y += side)
                for (uint32_t x = 0; x < m_all.size.width; x += side) {
                    VerdictTile tile{.x = x, .y = y};
                    tile.width = std::min(side, m_all.size.width - x);
                    tile.height = std::min(side, m_all.size.height - y);
                    if (!JudgeTile(tile, isFirst)) continue;
                    ++tiles;
                    beyond += tile.excess > 1.0;
                    if (verdict != nullptr) verdict->tiles.push_back(tile);
                }
            m_failures.tiles =
                std::max(m_failures.tiles, double(beyond) / double(std::max<size_t>(tiles, 1)));
        }
        m_failures.pixels /= double(std::max<size_t>(m_all.counted, 1));
        const double luminance = 0.2126 * m_reference[0] + 0.7152 * m_reference[1] + 0.0722 * m_reference[2];
        for (size_t c = 0; c < 3; ++c) {
            const double beyond = std::abs(m_difference[c]) -
                                  NoiseBound(m_of, kMeanDeviations, m_variance[c], m_referenceVariance[c]) -
                                  (m_difference[c] < 0.0 ? m_lost[c] : 0.0);
            const double over =
                std::max({m_reference[c], 0.25 * luminance, m_all.floor * double(m_all.counted)});
            if (beyond > 0.0 && m_all.scale == 0.0)
                m_failures.energy = std::max(m_failures.energy, over > 0.0 ? beyond / over : 1.0);
        }
        if (verdict != nullptr) verdict->worstPixels = WorstPixels();
        return m_failures;
    }

  private:
    // Returns whether a pixel of it counts. Each pixel is to be counted once.
    bool JudgeTile(VerdictTile& tile, bool isCountingPixels) {
        std::array<double, 3> sum{}, noise{}, ofReference{}, lost{}, bound{}, scale{};
        size_t count = 0;
        VerdictPixel worst;
        for (uint32_t y = tile.y; y < tile.y + tile.height; ++y)
            for (uint32_t x = tile.x; x < tile.x + tile.width; ++x) {
                const size_t pixel = size_t{y} * m_all.size.width + x;
                if (!m_all.Counts(pixel)) continue;
                ++count;
                double excess = 0.0;
                for (size_t c = 0; c < 3; ++c) {
                    const size_t i = 4 * pixel + c;
                    const double d = double{m_all.picture[i]} - m_all.reference[i];
                    const double v = m_all.noise[i], r = m_all.referenceNoise[i];
                    const double s = m_all.Scale(pixel, c), allowed = m_all.relative[pixel] * s;
                    sum[c] += d;
                    noise[c] += v;
                    ofReference[c] += r;
                    lost[c] += m_all.LostAtWhite(i);
                    bound[c] += allowed;
                    scale[c] += s;
                    if (!isCountingPixels) continue;
                    m_difference[c] += d;
                    m_variance[c] += v;
                    m_referenceVariance[c] += r;
                    m_reference[c] += m_all.reference[i];
                    m_lost[c] += m_all.LostAtWhite(i);
                    // The share of many pixels is an average: it takes no margin to be certain of it
                    const double ofNoise = m_of == NoiseOfBounds::ForRight
                                               ? kPixelDeviations * std::sqrt(v)
                                               : NoiseBound(m_of, kPixelDeviations, v, r);
                    excess = std::max(excess, Excess(d, allowed + ofNoise));
                }
                if (excess > 1.0) m_failures.pixels += 1.0;
                if (excess > worst.excess) worst = {.x = x, .y = y, .excess = excess};
            }
        for (size_t c = 0; c < 3; ++c) {
            const double deviation = std::sqrt(noise[c] + ofReference[c]);
            const double excess =
                Excess(sum[c], bound[c] + NoiseBound(m_of, m_deviations, noise[c], ofReference[c]) +
                                   (sum[c] < 0.0 ? lost[c] : 0.0));
            if (excess <= tile.excess) continue;
            tile.excess = excess;
            tile.relativeError = scale[c] > 0.0 ? sum[c] / scale[c] : 0.0;
            tile.z = deviation > 0.0 ? sum[c] / deviation : 0.0;
        }
        if (worst.excess > 0.0) m_worst.push_back(worst);
        return count > 0;
    }

    static double Excess(double difference, double bound) {
        return std::abs(difference) / std::max(bound, std::numeric_limits<double>::min());
    }

    std::vector<VerdictPixel> WorstPixels() {
        std::ranges::sort(m_worst, std::greater{}, &VerdictPixel::excess);
        if (m_worst.size() > kWorstPixels) m_worst.resize(kWorstPixels);
        for (VerdictPixel& pixel : m_worst)
            for (size_t c = 0; c < 3; ++c) {
                const size_t i = 4 * (size_t{pixel.y} * m_all.size.width + pixel.x) + c;
                pixel.reference[c] = m_all.reference[i];
                pixel.picture[c] = m_all.picture[i];
            }
        return std::move(m_worst);
    }

    const Compared& m_all;
    NoiseOfBounds m_of;
    double m_deviations;
    Failures m_failures;
    // Sums over the picture.
    std::array<double, 3> m_difference{}, m_variance{}, m_referenceVariance{}, m_reference{}, m_lost{};
    std::vector<VerdictPixel> m_worst;  // of each tile of the first size
};

Compared Prepare(const Picture& picture, const JudgedAgainst& against, PictureNoise noise) {
    const Picture& reference = against.reference;
    Compared all{.size = picture.size};
    const size_t count = PixelCount(picture.size);
    const float white = std::min(reference.white, picture.white);
    all.reference = CutAt(reference.radiance, white);
    all.picture = CutAt(picture.radiance, white);
    all.relative = against.relative;
    all.scale = against.scale;
    if (all.relative.empty()) all.relative.assign(count, static_cast<float>(against.tolerance.relative));
    double luminance = 0.0;
    for (size_t pixel = 0; pixel < count; ++pixel) {
        if (!all.Counts(pixel)) {
            std::copy_n(&all.reference[4 * pixel], 4, &all.picture[4 * pixel]);
            continue;
        }
        ++all.counted;
        luminance += std::abs(LuminanceOf(&all.reference[4 * pixel]));  // vectors have negative ones
    }
    if (all.counted == 0)
        throw MakeError(ErrorKind::BadInput, "{}: no pixel counts: all are masked or ignored",
                        Printable(picture.name, 1024));
    all.floor = luminance / (20.0 * double(all.counted));
    const double samples = picture.samples > 0 ? double(picture.samples) : noise.samples;
    all.noiseRatio = samples > 0.0 ? double(reference.samples) / samples : 0.0;
    all.noise = std::move(noise.variance);
    all.ownNoise = std::move(noise.own);
    if (std::isfinite(white)) {
        // The most that cutting takes from the mean r of noise with variance v (Scarf 1958)
        all.lostAtWhite.resize(4 * count);
        for (size_t i = 0; i < all.lostAtWhite.size(); ++i) {
            const float distance = std::abs(white - reference.radiance[i]);
            all.lostAtWhite[i] = 0.5f * (std::sqrt(all.noise[i] + distance * distance) - distance);
        }
    }
    all.ownReferenceNoise = reference.variance;
    all.ownReferenceNoise.resize(4 * count, 0.0f);
    all.referenceNoise = reference.variance.empty() ? Texels(4 * count, 0.0f)
                                                    : AtLeastAround(reference.variance, picture.size);
    return all;
}

// FLIP and 1 - SSIM of the reference against itself with noise.
struct Seen {
    double flip = 0.0, ssim = 0.0;
};

Seen SeenOfNoise(Renderer& renderer, const Compared& all, float white, float exposureEv, double ofPicture,
                 double ofReference) {
    Texels noisy = all.reference;
    for (size_t i = 0; i < noisy.size(); ++i) {
        const double variance = ofPicture * all.noise[i] + ofReference * all.referenceNoise[i];
        if (i % 4 != 3 && all.Counts(i / 4) && variance > 0.0)
            noisy[i] = std::max(0.0f, noisy[i] + NormalAt(i) * static_cast<float>(std::sqrt(variance)));
    }
    noisy = CutAt(std::move(noisy), white);
    const std::vector<bool> counts = all.Counting();
    return {FlipOf(renderer, all.reference, noisy, all.size, exposureEv, counts).mean,
            1.0 - SsimOf(all.reference, noisy, all.size, exposureEv, counts)};
}

bool IsFinite(const float* texel) {
    return std::isfinite(texel[0]) && std::isfinite(texel[1]) && std::isfinite(texel[2]);
}

// Counts the pixels that are NaN or infinite.
VerdictCheck NonFinite(const Picture& picture, const std::vector<float>& relative) {
    VerdictCheck check{.name = "nonfinite"};
    for (size_t pixel = 0; pixel < PixelCount(picture.size); ++pixel) {
        if (IsFinite(&picture.radiance[4 * pixel])) continue;
        if (!relative.empty() && !std::isfinite(relative[pixel])) continue;
        constexpr double kMostShown = 4.0;
        if (check.value < kMostShown)
            check.where += Text("{}{},{}", check.where.empty() ? "pixels " : "; ", pixel % picture.size.width,
                                pixel / picture.size.width);
        check.value += 1.0;
    }
    check.isPassed = check.value == 0.0;
    return check;
}

}  // namespace

Picture WithoutNonFinite(Picture picture) {
    for (size_t i = 0; i < picture.radiance.size(); i += 4)
        if (!IsFinite(&picture.radiance[i])) std::fill_n(&picture.radiance[i], 3, 0.0f);
    return picture;
}

Verdict Judge(Renderer& renderer, const Picture& given, const JudgedAgainst& against) {
    Verdict verdict;
    RequireComparable(renderer, against.reference, given);
    const VerdictCheck nonFinite = NonFinite(given, against.relative);
    const Picture picture = WithoutNonFinite(given);
    PictureNoise noise = NoiseOf(picture, against.reference, against.relative, against.pictureSamples);
    verdict.isNoiseEstimated = noise.isEstimated;
    verdict.pictureSamples = noise.samples;
    const Compared all = Prepare(picture, against, std::move(noise));
    verdict.difference = Difference(renderer, against.reference, picture, against.exposureEv, all.Counting());
    const Failures failures = Judging(all, NoiseOfBounds::Both).Run(&verdict);
    const Failures forRight = Judging(all, NoiseOfBounds::ForRight).Run(nullptr),
                   forWrong = Judging(all, NoiseOfBounds::ForWrong).Run(nullptr);

    const float white = std::min(against.reference.white, picture.white);
    const auto seen = [&](double ofPicture, double ofReference) {
        return SeenOfNoise(renderer, all, white, against.exposureEv, ofPicture, ofReference);
    };
    const Seen ofBoth = seen(1.0, 1.0);
    Seen ofPicture = ofBoth, ofReference;
    if (!against.reference.variance.empty()) {
        ofPicture = seen(1.0, 0.0);
        ofReference = seen(0.0, 1.0);
    }
    verdict.flipOfNoise = ofBoth.flip;
    verdict.ssimOfNoise = 1.0 - ofBoth.ssim;

    const Tolerance& tolerance = against.tolerance;
    bool isCertainlyRight = nonFinite.isPassed, isCertainlyWrong = !nonFinite.isPassed;
    // `right` and `wrong` are the values for a limit that decide it
    const auto atMost = [&](const char* name, double value, double limit, double right, double wrong) {
        verdict.checks.push_back({name, value, limit, value <= limit});
        isCertainlyRight &= right <= limit;
        isCertainlyWrong |= !(wrong <= limit);
    };
    atMost("tiles", failures.tiles, tolerance.tiles, forRight.tiles, forWrong.tiles);
    atMost("pixels", failures.pixels, tolerance.pixels, forRight.pixels, forWrong.pixels);
    atMost("energy", failures.energy, tolerance.energy, forRight.energy, forWrong.energy);
    // The noise of the reference is in the difference, too. What is seen of it may be twice that of normal
    // noise
    const auto doubt = [](double both, double ofPictureAlone, double ofReferenceAlone) {
        return ofPictureAlone + 2.0 * std::max(ofReferenceAlone, both - ofPictureAlone) - both;
    };
    const double flip = verdict.difference.flip, unlike = 1.0 - verdict.difference.ssim;
    atMost("flip", flip, ofBoth.flip + tolerance.flip, flip + ofBoth.flip - ofPicture.flip,
           flip - std::max(doubt(ofBoth.flip, ofPicture.flip, ofReference.flip), 0.0));
    const double unlikeLimit = ofBoth.ssim + tolerance.ssim;
    atMost("ssim", unlike, unlikeLimit, unlike + ofBoth.ssim - ofPicture.ssim,
           unlike - std::max(doubt(ofBoth.ssim, ofPicture.ssim, ofReference.ssim), 0.0));
    verdict.checks.back().value = 1.0 - unlike;
    verdict.checks.back().limit = 1.0 - unlikeLimit;
    verdict.projections = Project(all, against.render, against.names);
    double error = 0.0, errorForRight = 0.0, errorForWrong = 0.0;
    for (const Projection& found : verdict.projections) {
        error = std::max(error, found.error);
        errorForRight = std::max(errorForRight, found.errorForRight);
        errorForWrong = std::max(errorForWrong, found.errorForWrong);
    }
    atMost("parts", error, tolerance.parts, errorForRight, errorForWrong);
    if (error > 0.0) verdict.checks.back().where = ToText(verdict.projections.front());
    verdict.checks.push_back(nonFinite);
    verdict.isRight = std::ranges::all_of(verdict.checks, &VerdictCheck::isPassed);
    verdict.isDecided = verdict.isRight ? isCertainlyRight : isCertainlyWrong;
    return verdict;
}

}  // namespace raygraph::session
