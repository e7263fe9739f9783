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

struct Failures {
    double tiles = 0.0, pixels = 0.0, energy = 0.0;  // shares, and the relative error beyond the noise
};

// Judges tiles, pixels and the mean.
class Judging {
  public:
    // `noiseShare` is the share of the reference's noise that counts.
    Judging(const Compared& all, double noiseShare) : m_all(all), m_noiseShare(noiseShare) {
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
            const double beyond = std::abs(m_difference[c]) - kMeanDeviations * std::sqrt(m_variance[c]);
            const double over =
                std::max({m_reference[c], 0.25 * luminance, m_all.floor * double(m_all.counted)});
            if (beyond > 0.0)
                m_failures.energy = std::max(m_failures.energy, over > 0.0 ? beyond / over : 1.0);
        }
        if (verdict != nullptr) verdict->worstPixels = WorstPixels();
        return m_failures;
    }

  private:
    // Returns whether a pixel of it counts. Each pixel is to be counted once.
    bool JudgeTile(VerdictTile& tile, bool isCountingPixels) {
        std::array<double, 3> sum{}, noise{}, bound{}, scale{};
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
                    const double v = m_all.noise[i] + m_noiseShare * m_all.referenceNoise[i];
                    const double s = m_all.Scale(pixel, c), allowed = m_all.relative[pixel] * s;
                    sum[c] += d;
                    noise[c] += v;
                    bound[c] += allowed;
                    scale[c] += s;
                    if (!isCountingPixels) continue;
                    m_difference[c] += d;
                    m_variance[c] += v;
                    m_reference[c] += m_all.reference[i];
                    excess = std::max(excess, std::abs(d) / (allowed + kPixelDeviations * std::sqrt(v) +
                                                             std::numeric_limits<double>::min()));
                }
                if (excess > 1.0) m_failures.pixels += 1.0;
                if (excess > worst.excess) worst = {.x = x, .y = y, .excess = excess};
            }
        for (size_t c = 0; c < 3; ++c) {
            const double deviation = std::sqrt(noise[c]);
            const double excess =
                std::abs(sum[c]) / (bound[c] + m_deviations * deviation + std::numeric_limits<double>::min());
            if (excess <= tile.excess) continue;
            tile.excess = excess;
            tile.relativeError = scale[c] > 0.0 ? sum[c] / scale[c] : 0.0;
            tile.z = deviation > 0.0 ? sum[c] / deviation : 0.0;
        }
        if (worst.excess > 0.0) m_worst.push_back(worst);
        return count > 0;
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
    double m_noiseShare, m_deviations;
    Failures m_failures;
    std::array<double, 3> m_difference{}, m_variance{}, m_reference{};  // sums over the picture
    std::vector<VerdictPixel> m_worst;                                  // of each tile of the first size
};

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
    all.ownNoise = isEstimated ? all.noise : picture.variance;
    all.noiseRatio = picture.samples > 0 ? float(reference.samples) / float(picture.samples) : 0.0f;
    all.ownReferenceNoise = reference.variance;
    all.ownReferenceNoise.resize(4 * count, 0.0f);
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
        constexpr uint32_t kSide = kVerifyTiles.front();
        std::vector<float> sizes;
        for (uint32_t top = 0; top < height; top += kSide)
            for (uint32_t left = 0; left < width; left += kSide)
                for (size_t c = 0; c < 3; ++c) {
                    const uint32_t right = std::min(left + kSide, width),
                                   bottom = std::min(top + kSide, height);
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
    const Failures failures = Judging(all, 1.0).Run(&verdict), withoutNoise = Judging(all, 0.0).Run(nullptr);

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
    verdict.projections = Project(all, against.render, against.names);
    double errorWithoutNoise = 0.0;
    for (const Projection& found : verdict.projections)
        errorWithoutNoise = std::max(errorWithoutNoise, found.errorWithoutNoise);
    atMost("parts", verdict.projections.empty() ? 0.0 : std::max(verdict.projections.front().error, 0.0),
           tolerance.parts);
    if (!verdict.projections.empty()) verdict.checks.back().where = ToText(verdict.projections.front());
    verdict.isRight = std::ranges::all_of(verdict.checks, &VerdictCheck::isPassed);
    const auto agree = [](double a, double b, double limit) { return (a <= limit) == (b <= limit); };
    verdict.isDecided = !verdict.isRight || (agree(failures.tiles, withoutNoise.tiles, tolerance.tiles) &&
                                             agree(failures.pixels, withoutNoise.pixels, tolerance.pixels) &&
                                             agree(failures.energy, withoutNoise.energy, tolerance.energy) &&
                                             errorWithoutNoise <= tolerance.parts);
    return verdict;
}

}  // namespace raygraph::session
