#include "editor/session/verify/verdict.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/text.h"
#include "editor/session/settings/parse.h"

namespace raygraph::session {

namespace {

constexpr double kPixelDeviations = 4.0, kMeanDeviations = 4.0;
constexpr size_t kWorstPixels = 16;

// Returns k for which |z| <= k holds for all of `count` normal numbers with probability 1 - significance.
double SidakDeviations(size_t count, double significance) {
    const double ofOne = -std::expm1(std::log1p(-significance) / double(std::max<size_t>(count, 1)));
    double low = 0.0, high = 40.0;
    for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (std::erfc(middle / std::numbers::sqrt2) > ofOne ? low : high) = middle;
    }
    return high;
}

// Returns the mean over 5 x 5 pixels around each, of those in the picture.
Texels BoxMeans(const Texels& texels, Extent2D size) {
    const auto pass = [&](const Texels& from, bool isAlongX) {
        Texels to(from.size());
        const int width = static_cast<int>(size.width), height = static_cast<int>(size.height);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const int at = isAlongX ? x : y, end = isAlongX ? width : height;
                const int first = std::max(at - 2, 0), last = std::min(at + 2, end - 1);
                float sum[4] = {};
                for (int i = first; i <= last; ++i) {
                    const size_t pixel = size_t(isAlongX ? y : i) * size.width + size_t(isAlongX ? i : x);
                    for (size_t c = 0; c < 4; ++c) sum[c] += from[4 * pixel + c];
                }
                const size_t pixel = size_t(y) * size.width + size_t(x);
                for (size_t c = 0; c < 4; ++c) to[4 * pixel + c] = sum[c] / float(last - first + 1);
            }
        return to;
    };
    return pass(pass(texels, true), false);
}

Texels AtLeastAround(Texels variance, Extent2D size) {
    const Texels around = BoxMeans(variance, size);
    for (size_t i = 0; i < variance.size(); ++i) variance[i] = std::max(variance[i], around[i]);
    return variance;
}

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

// Holds both pictures, cut where the picture is, and the bounds that each pixel has.
struct Compared {
    Extent2D size;
    Texels reference, picture;     // pixels that do not count are those of the reference in both
    Texels referenceNoise, noise;  // variances, of the reference and of the picture
    std::vector<float> relative;   // of each pixel; infinity: it does not count
    double floor = 0.0;            // a twentieth of the mean luminance
    size_t counted = 0;

    bool Counts(size_t pixel) const { return std::isfinite(relative[pixel]); }
    // Returns what the relative error of a channel of a pixel is over.
    double Scale(size_t pixel, size_t channel) const {
        const float* texel = &reference[4 * pixel];
        return std::max({std::abs(double{texel[channel]}), 0.25 * std::abs(LuminanceOf(texel)), floor});
    }
};

struct Failures {
    double tiles = 0.0, pixels = 0.0, energy = 0.0;  // shares, and the relative error beyond the noise
};

// Judges tiles, pixels and the mean; `noiseShare` is the share of the reference's noise that counts.
Failures Evaluate(const Compared& all, double noiseShare, Verdict* verdict) {
    const Extent2D size = all.size;
    const uint32_t columns = (size.width + kVerifyTile - 1) / kVerifyTile,
                   rows = (size.height + kVerifyTile - 1) / kVerifyTile;
    const double deviations = SidakDeviations(size_t{3} * columns * rows, 0.01);
    Failures failures;
    size_t tileCount = 0;
    std::array<double, 3> difference{}, variance{}, reference{};
    std::vector<VerdictPixel> worst;
    for (uint32_t row = 0; row < rows; ++row)
        for (uint32_t column = 0; column < columns; ++column) {
            VerdictTile tile{.x = column * kVerifyTile, .y = row * kVerifyTile};
            tile.width = std::min(kVerifyTile, size.width - tile.x);
            tile.height = std::min(kVerifyTile, size.height - tile.y);
            std::array<double, 3> sum{}, noise{}, bound{}, scale{};
            size_t count = 0;
            VerdictPixel ofTile;
            for (uint32_t y = tile.y; y < tile.y + tile.height; ++y)
                for (uint32_t x = tile.x; x < tile.x + tile.width; ++x) {
                    const size_t pixel = size_t{y} * size.width + x;
                    if (!all.Counts(pixel)) continue;
                    ++count;
                    double excess = 0.0;
                    for (size_t c = 0; c < 3; ++c) {
                        const size_t i = 4 * pixel + c;
                        const double d = double{all.picture[i]} - all.reference[i];
                        const double v = all.noise[i] + noiseShare * all.referenceNoise[i];
                        const double s = all.Scale(pixel, c), allowed = all.relative[pixel] * s;
                        sum[c] += d;
                        noise[c] += v;
                        bound[c] += allowed;
                        scale[c] += s;
                        reference[c] += all.reference[i];
                        excess = std::max(excess, std::abs(d) / (allowed + kPixelDeviations * std::sqrt(v) +
                                                                 std::numeric_limits<double>::min()));
                    }
                    if (excess > 1.0) failures.pixels += 1.0;
                    if (excess > ofTile.excess) ofTile = {.x = x, .y = y, .excess = excess};
                }
            if (count == 0) continue;
            ++tileCount;
            for (size_t c = 0; c < 3; ++c) {
                difference[c] += sum[c];
                variance[c] += noise[c];
                const double deviation = std::sqrt(noise[c]);
                const double excess = std::abs(sum[c]) / (bound[c] + deviations * deviation +
                                                          std::numeric_limits<double>::min());
                if (excess <= tile.excess) continue;
                tile.excess = excess;
                tile.relativeError = scale[c] > 0.0 ? sum[c] / scale[c] : 0.0;
                tile.z = deviation > 0.0 ? sum[c] / deviation : 0.0;
            }
            if (tile.excess > 1.0) failures.tiles += 1.0;
            if (verdict != nullptr) {
                verdict->tiles.push_back(tile);
                if (ofTile.excess > 0.0) worst.push_back(ofTile);
            }
        }
    failures.tiles /= double(std::max<size_t>(tileCount, 1));
    failures.pixels /= double(std::max<size_t>(all.counted, 1));
    const double luminance = 0.2126 * reference[0] + 0.7152 * reference[1] + 0.0722 * reference[2];
    for (size_t c = 0; c < 3; ++c) {
        const double beyond = std::abs(difference[c]) - kMeanDeviations * std::sqrt(variance[c]);
        const double over = std::max({reference[c], 0.25 * luminance, all.floor * double(all.counted)});
        if (beyond > 0.0) failures.energy = std::max(failures.energy, over > 0.0 ? beyond / over : 1.0);
    }
    if (verdict != nullptr) {
        std::ranges::sort(worst, std::greater{}, &VerdictPixel::excess);
        if (worst.size() > kWorstPixels) worst.resize(kWorstPixels);
        for (VerdictPixel& pixel : worst)
            for (size_t c = 0; c < 3; ++c) {
                const size_t i = 4 * (size_t{pixel.y} * size.width + pixel.x) + c;
                pixel.reference[c] = all.reference[i];
                pixel.picture[c] = all.picture[i];
            }
        verdict->worstPixels = std::move(worst);
    }
    return failures;
}

Compared Prepare(const Picture& picture, const JudgedAgainst& against, bool& isEstimated) {
    const Picture& reference = against.reference;
    Compared all{.size = picture.size};
    const size_t count = PixelCount(picture.size);
    const float white = std::min(reference.white, picture.white);
    all.reference = CutAt(reference.radiance, white);
    all.picture = CutAt(picture.radiance, white);
    all.relative = against.relative;
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
    all.noise = NoiseOf(picture, reference, isEstimated);
    all.referenceNoise = reference.variance.empty() ? Texels(4 * count, 0.0f)
                                                    : AtLeastAround(reference.variance, picture.size);
    return all;
}

}  // namespace

Texels NoiseOf(const Picture& picture, const Picture& reference, bool& isEstimated) {
    const size_t count = PixelCount(picture.size);
    isEstimated = picture.variance.empty();
    Texels noise(4 * count, 0.0f);
    if (!isEstimated) {
        noise = picture.variance;
        if (picture.samples > 0 && reference.samples > 0 && !reference.variance.empty()) {
            const float ratio = float(reference.samples) / float(picture.samples);
            for (size_t i = 0; i < noise.size(); ++i)
                noise[i] = std::max(noise[i], ratio * reference.variance[i]);
        }
        noise = AtLeastAround(std::move(noise), picture.size);
    } else {
        const uint32_t width = picture.size.width, height = picture.size.height;
        const float white = std::min(reference.white, picture.white);
        const auto residual = [&](uint32_t x, uint32_t y, size_t c) {
            const size_t i = 4 * (size_t{y} * width + x) + c;
            return std::min(picture.radiance[i], white) - std::min(reference.radiance[i], white);
        };
        std::vector<float> sizes;
        for (uint32_t top = 0; top < height; top += kVerifyTile)
            for (uint32_t left = 0; left < width; left += kVerifyTile)
                for (size_t c = 0; c < 3; ++c) {
                    const uint32_t right = std::min(left + kVerifyTile, width),
                                   bottom = std::min(top + kVerifyTile, height);
                    sizes.clear();
                    double known = 0.0;
                    for (uint32_t y = top; y + 1 < bottom; ++y)
                        for (uint32_t x = left; x + 1 < right; ++x) {
                            sizes.push_back(0.5f *
                                            std::abs(residual(x, y, c) - residual(x + 1, y, c) -
                                                     residual(x, y + 1, c) + residual(x + 1, y + 1, c)));
                            if (!reference.variance.empty())
                                known += reference.variance[4 * (size_t{y} * width + x) + c];
                        }
                    if (sizes.empty()) continue;
                    const auto middle = sizes.begin() + std::ptrdiff_t(sizes.size() / 2);
                    std::ranges::nth_element(sizes, middle);
                    // 0.6745 is the median of the size of a standard normal number
                    const double deviation = *middle / 0.6745;
                    const double variance = deviation * deviation - known / double(sizes.size());
                    for (uint32_t y = top; y < bottom; ++y)
                        for (uint32_t x = left; x < right; ++x)
                            noise[4 * (size_t{y} * width + x) + c] =
                                static_cast<float>(std::max(variance, 0.0));
                }
    }
    if (picture.transfer)
        for (size_t i = 0; i < noise.size(); ++i)
            if (i % 4 != 3) noise[i] += picture.RoundingVariance(picture.radiance[i]);
    return noise;
}

Verdict Judge(Renderer& renderer, const Picture& picture, const JudgedAgainst& against) {
    Verdict verdict;
    Picture counted = picture;
    if (picture.size == against.reference.size)
        for (size_t pixel = 0; pixel < against.relative.size(); ++pixel)
            if (!std::isfinite(against.relative[pixel]))
                std::copy_n(&against.reference.radiance[4 * pixel], 4, &counted.radiance[4 * pixel]);
    verdict.difference = Difference(renderer, against.reference, counted, against.exposureEv);
    const Compared all = Prepare(picture, against, verdict.isNoiseEstimated);
    const Failures failures = Evaluate(all, 1.0, &verdict), withoutNoise = Evaluate(all, 0.0, nullptr);

    Texels noisy = all.reference;
    for (size_t i = 0; i < noisy.size(); ++i)
        if (i % 4 != 3 && all.Counts(i / 4))
            noisy[i] =
                std::max(0.0f, noisy[i] + NormalAt(i) * std::sqrt(all.noise[i] + all.referenceNoise[i]));
    const float white = std::min(against.reference.white, picture.white);
    noisy = CutAt(std::move(noisy), white);
    verdict.flipOfNoise = FlipOf(renderer, all.reference, noisy, all.size, against.exposureEv).mean;
    verdict.ssimOfNoise = SsimOf(all.reference, noisy, all.size, against.exposureEv);

    const Tolerance& tolerance = against.tolerance;
    const auto atMost = [&](const char* name, double value, double limit) {
        verdict.checks.push_back({name, value, limit, value <= limit});
    };
    atMost("tiles", failures.tiles, tolerance.tiles);
    atMost("pixels", failures.pixels, tolerance.pixels);
    atMost("energy", failures.energy, tolerance.energy);
    atMost("flip", verdict.difference.flip, verdict.flipOfNoise + tolerance.flip);
    const double leastSsim = verdict.ssimOfNoise - tolerance.ssim;
    verdict.checks.push_back(
        {"ssim", verdict.difference.ssim, leastSsim, verdict.difference.ssim >= leastSsim});
    verdict.isRight = std::ranges::all_of(verdict.checks, &VerdictCheck::isPassed);
    const auto agree = [](double a, double b, double limit) { return (a <= limit) == (b <= limit); };
    verdict.isDecided = !verdict.isRight || (agree(failures.tiles, withoutNoise.tiles, tolerance.tiles) &&
                                             agree(failures.pixels, withoutNoise.pixels, tolerance.pixels) &&
                                             agree(failures.energy, withoutNoise.energy, tolerance.energy));
    return verdict;
}

}  // namespace raygraph::session
