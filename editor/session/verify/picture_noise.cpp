#include "editor/session/verify/picture_noise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "editor/session/verify/difference.h"

namespace raygraph::session {

namespace {

// The median of tiles is below the mean if noise is skewed, as that of paths is: the variance may be larger
// by this factor.
constexpr double kSkewMargin = 2.0;
constexpr uint32_t kNoiseTile = 16, kMostDistance = 4;

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

// Estimates the samples of the reference that have the noise of a picture.
class Estimating {
  public:
    Estimating(const Picture& picture, const Picture& reference, const std::vector<float>& relative)
        : m_picture(picture),
          m_reference(reference),
          m_relative(relative),
          m_size(picture.size),
          m_white(std::min(reference.white, picture.white)),
          m_shape(AtLeastAround(reference.variance, picture.size)) {
        double luminance = 0.0;
        const size_t pixels = PixelCount(m_size);
        for (size_t pixel = 0; pixel < pixels; ++pixel)
            luminance += std::abs(LuminanceOf(&reference.radiance[4 * pixel]));
        m_floor = luminance / (20.0 * double(pixels));
    }

    // Returns variance of the picture over that of the reference.
    double Ratio() const {
        double least = std::numeric_limits<double>::infinity();
        for (uint32_t distance = 1; distance <= kMostDistance; ++distance)
            if (distance < std::min(m_size.width, m_size.height)) least = std::min(least, RatioAt(distance));
        return std::isfinite(least) ? least : 0.0;
    }

  private:
    struct Sums {
        double squares = 0.0, shape = 0.0;  // weighted
    };

    double RatioAt(uint32_t distance) const {
        std::vector<Sums> tiles;
        double all = 0.0;
        for (uint32_t top = 0; top + distance < m_size.height; top += kNoiseTile)
            for (uint32_t left = 0; left + distance < m_size.width; left += kNoiseTile) {
                Sums sums;
                for (uint32_t y = top; y < std::min(top + kNoiseTile, m_size.height - distance); ++y)
                    for (uint32_t x = left; x < std::min(left + kNoiseTile, m_size.width - distance); ++x)
                        AddAt(sums, x, y, distance);
                if (!(sums.shape > 0.0)) continue;
                all += sums.shape;
                tiles.push_back(sums);
            }
        // The median of tiles, each with the weight of the noise that it shows
        std::ranges::sort(tiles, {}, [](const Sums& sums) { return sums.squares / sums.shape; });
        double sum = 0.0;
        for (const Sums& sums : tiles)
            if ((sum += sums.shape) >= 0.5 * all) return std::max(sums.squares / sums.shape, 0.0);
        return 0.0;
    }

    void AddAt(Sums& sums, uint32_t x, uint32_t y, uint32_t distance) const {
        const size_t first = size_t{y} * m_size.width + x, down = size_t{distance} * m_size.width;
        const std::array<size_t, 4> four{first, first + distance, first + down, first + down + distance};
        for (const size_t pixel : four)
            if (!m_relative.empty() && !std::isfinite(m_relative[pixel])) return;
        for (size_t c = 0; c < 3; ++c) {
            double difference = 0.0, shape = 0.0, known = 0.0, scale = m_floor;
            bool isCut = false;
            for (size_t k = 0; k < 4; ++k) {
                const size_t i = 4 * four[k] + c;
                isCut |= m_picture.radiance[i] >= m_white || m_reference.radiance[i] >= m_white;
                const double d = double{m_picture.radiance[i]} - m_reference.radiance[i];
                difference += k == 0 || k == 3 ? d : -d;
                shape += 0.25 * m_shape[i];
                known += 0.25 * (double{m_reference.variance[i]} +
                                 m_picture.RoundingVariance(m_picture.radiance[i]));
                scale = std::max(scale, std::abs(double{m_reference.radiance[i]}));
            }
            if (isCut || !(shape > 0.0)) continue;
            // Where noise is below what is allowed, differences say little of it
            const double allowed = 0.05 * scale;
            const double weight = 1.0 / (shape + known + allowed * allowed);
            sums.squares += weight * (0.25 * difference * difference - known);
            sums.shape += weight * shape;
        }
    }

    const Picture &m_picture, &m_reference;
    const std::vector<float>& m_relative;
    Extent2D m_size;
    float m_white;
    Texels m_shape;
    double m_floor = 0.0;
};

}  // namespace

Texels AtLeastAround(Texels variance, Extent2D size) {
    const Texels around = BoxMeans(variance, size);
    for (size_t i = 0; i < variance.size(); ++i) variance[i] = std::max(variance[i], around[i]);
    return variance;
}

PictureNoise NoiseOf(const Picture& picture, const Picture& reference, const std::vector<float>& relative,
                     std::optional<uint32_t> samples) {
    PictureNoise noise;
    const bool isShapeKnown = !reference.variance.empty() && reference.samples > 0;
    noise.own.assign(picture.radiance.size(), 0.0f);
    double ratio = 0.0;
    if (!picture.variance.empty()) {
        noise.own = picture.variance;
        if (picture.samples > 0 && isShapeKnown) ratio = double(reference.samples) / double(picture.samples);
    } else if (samples) {
        noise.samples = *samples;
        if (*samples > 0 && isShapeKnown) ratio = double(reference.samples) / *samples;
    } else {
        noise.isEstimated = true;
        if (isShapeKnown)
            ratio = std::min(kSkewMargin * Estimating(picture, reference, relative).Ratio(),
                             double(reference.samples) / kLeastPictureSamples);
        if (ratio > 0.0) noise.samples = double(reference.samples) / ratio;
    }
    noise.variance = noise.own;
    const auto least = static_cast<float>(ratio);
    for (size_t i = 0; ratio > 0.0 && i < noise.variance.size(); ++i)
        noise.variance[i] = std::max(noise.variance[i], least * reference.variance[i]);
    if (picture.variance.empty()) noise.own = noise.variance;
    noise.variance = AtLeastAround(std::move(noise.variance), picture.size);
    for (Texels* texels : {&noise.variance, &noise.own})
        for (size_t i = 0; i < texels->size(); ++i)
            (*texels)[i] = i % 4 == 3 ? 0.0f : (*texels)[i] + picture.RoundingVariance(picture.radiance[i]);
    return noise;
}

}  // namespace raygraph::session
