#include "editor/session/verify/difference.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/text.h"
#include "editor/session/settings/parse.h"
#include "passes/compare.h"
#include "passes/flip.h"
#include "passes/pixel_list.h"
#include "passes/tonemap.h"
#include "renderer/graph/readback_values.h"

namespace raygraph::session {

namespace {

bool Counts(const std::vector<bool>& counts, size_t pixel) {
    return counts.empty() || counts[pixel];
}

TextureId Upload(Renderer& renderer, const char* name, const Texels& texels, Extent2D size) {
    return passes::UploadTexels(renderer, std::as_bytes(std::span(texels)),
                                renderer.CreateTexture(name, {size, Format::Rgba32Float}));
}

TextureId Displayed(Renderer& renderer, const char* name, const Texels& texels, Extent2D size,
                    float exposureEv) {
    return passes::Tonemap(
        renderer, Upload(renderer, name, texels, size),
        {.exposureEv = exposureEv, .tonemapOperator = TonemapOperator::Srgb, .isOpaque = true});
}

// Filters a plane by the 11 x 11 window of SSIM; pixels beyond the border repeat the border.
std::vector<double> Smoothed(const std::vector<double>& plane, Extent2D size) {
    constexpr int kRadius = 5;
    double weights[kRadius + 1], sum = 0.0;
    for (int i = 0; i <= kRadius; ++i) {
        weights[i] = std::exp(-double(i * i) / (2.0 * 1.5 * 1.5));
        sum += (i == 0 ? 1.0 : 2.0) * weights[i];
    }
    const int width = static_cast<int>(size.width), height = static_cast<int>(size.height);
    const auto filter = [&](const std::vector<double>& from, bool isAlongX) {
        std::vector<double> to(from.size());
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                double value = 0.0;
                for (int i = -kRadius; i <= kRadius; ++i) {
                    const int sx = isAlongX ? std::clamp(x + i, 0, width - 1) : x,
                              sy = isAlongX ? y : std::clamp(y + i, 0, height - 1);
                    value += weights[std::abs(i)] * from[size_t(sy) * size.width + size_t(sx)];
                }
                to[size_t(y) * size.width + size_t(x)] = value / sum;
            }
        return to;
    };
    return filter(filter(plane, true), false);
}

std::optional<ZScores> ScoresOf(const Texels& reference, const Texels& picture, const Texels& varianceA,
                                const Texels& varianceB, const std::vector<bool>& counts) {
    if (varianceA.empty() && varianceB.empty()) return std::nullopt;
    ZScores scores;
    std::array<double, 3> difference{}, variance{};
    double squares = 0.0;
    size_t count = 0, beyond = 0;
    for (size_t i = 0; i < reference.size(); ++i) {
        if (i % 4 == 3 || !Counts(counts, i / 4)) continue;
        const double d = double{picture[i]} - reference[i];
        const double v = (varianceA.empty() ? 0.0 : varianceA[i]) + (varianceB.empty() ? 0.0 : varianceB[i]);
        difference[i % 4] += d;
        variance[i % 4] += v;
        if (v > 0.0) {
            ++count;
            squares += d * d / v;
            if (d * d > 9.0 * v) ++beyond;
        } else if (d != 0.0) {
            ++scores.differsWithoutNoise;
        }
    }
    if (count > 0) {
        scores.rms = std::sqrt(squares / double(count));
        scores.beyondThree = double(beyond) / double(count);
    }
    scores.isOfBoth = !varianceA.empty() && !varianceB.empty();
    for (size_t c = 0; c < 3; ++c)
        scores.ofMean[c] = variance[c] > 0.0 ? difference[c] / std::sqrt(variance[c]) : 0.0;
    return scores;
}

}  // namespace

Texels CutAt(Texels radiance, float white) {
    if (white < std::numeric_limits<float>::infinity())
        for (float& value : radiance) value = std::min(value, white);
    return radiance;
}

FlipOfPictures FlipOf(Renderer& renderer, const Texels& reference, const Texels& picture, Extent2D size,
                      float exposureEv, const std::vector<bool>& counts) {
    renderer.BeginFrame();
    const TextureId a = Displayed(renderer, "reference", reference, size, exposureEv),
                    b = Displayed(renderer, "picture", picture, size, exposureEv);
    const Readback map = renderer.ReadBack(passes::Flip(renderer, a, b));
    renderer.Execute();
    FlipOfPictures flip{.map = WaitForValues<float>(map)};
    size_t counted = 0;
    for (size_t i = 0; i < flip.map.size(); ++i) {
        if (!Counts(counts, i)) continue;
        flip.mean += flip.map[i];
        ++counted;
    }
    flip.mean /= double(std::max<size_t>(counted, 1));
    return flip;
}

double SsimOf(const Texels& reference, const Texels& picture, Extent2D size, float exposureEv,
              const std::vector<bool>& counts) {
    const size_t count = reference.size() / 4;
    const float scale = std::exp2(exposureEv);
    const Transfer srgb;
    std::array<std::vector<double>, 5> planes;  // x, y, x^2, y^2, xy
    for (auto& plane : planes) plane.resize(count);
    const auto encoded = [&](const float* texel) {
        float cut[3];
        for (int c = 0; c < 3; ++c) cut[c] = std::clamp(texel[c] * scale, 0.0f, 1.0f);
        return double{srgb.Encode(LuminanceOf(cut))};
    };
    for (size_t i = 0; i < count; ++i) {
        const double x = encoded(&reference[4 * i]), y = encoded(&picture[4 * i]);
        planes[0][i] = x;
        planes[1][i] = y;
        planes[2][i] = x * x;
        planes[3][i] = y * y;
        planes[4][i] = x * y;
    }
    for (auto& plane : planes) plane = Smoothed(plane, size);
    constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;
    double sum = 0.0;
    size_t counted = 0;
    for (size_t i = 0; i < count; ++i) {
        if (!Counts(counts, i)) continue;
        ++counted;
        const double mx = planes[0][i], my = planes[1][i];
        const double vx = planes[2][i] - mx * mx, vy = planes[3][i] - my * my, both = planes[4][i] - mx * my;
        sum += (2.0 * mx * my + kC1) * (2.0 * both + kC2) / ((mx * mx + my * my + kC1) * (vx + vy + kC2));
    }
    return sum / double(std::max<size_t>(counted, 1));
}

void RequireComparable(const Renderer& renderer, const Picture& reference, const Picture& picture) {
    if (reference.size != picture.size)
        throw MakeError(ErrorKind::BadInput, "{} has {} pixels, and {} has {}", Printable(picture.name, 1024),
                        ToText(picture.size), Printable(reference.name, 1024), ToText(reference.size));
    const uint32_t most = renderer.Device().Info().maxTextureExtent;
    if (PixelCount(picture.size) == 0 || std::max(picture.size.width, picture.size.height) > most)
        throw MakeError(ErrorKind::BadInput, "{}: {} pixels; a picture to compare has from 1x1 to {}x{}",
                        Printable(picture.name, 1024), ToText(picture.size), most, most);
}

PictureDifference Difference(Renderer& renderer, const Picture& reference, const Picture& picture,
                             float exposureEv, const std::vector<bool>& counts) {
    RequireComparable(renderer, reference, picture);
    for (const Picture* each : {&reference, &picture})
        for (size_t i = 0; i < each->radiance.size(); ++i)
            if (i % 4 != 3 && !std::isfinite(each->radiance[i]) && Counts(counts, i / 4))
                throw MakeError(ErrorKind::BadInput, "{}: pixel ({}, {}) is {}", Printable(each->name, 1024),
                                i / 4 % each->size.width, i / 4 / each->size.width,
                                std::isnan(each->radiance[i]) ? "NaN" : "infinite");
    const float white = std::min(reference.white, picture.white);
    const Texels a = CutAt(reference.radiance, white);
    Texels b = CutAt(picture.radiance, white);
    PictureDifference result;
    double squares = 0.0, noise = 0.0;
    size_t values = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        if (!Counts(counts, i / 4)) {
            b[i] = a[i];
            continue;
        }
        if (i % 4 == 3) continue;
        ++values;
        const double r = a[i], d = b[i] - r, weight = 1.0 / (r * r + 0.01);
        squares += d * d * weight;
        if (!reference.variance.empty()) noise += reference.variance[i] * weight;
        if (!picture.variance.empty()) noise += picture.variance[i] * weight;
        result.meanOfReference[i % 4] += r;
        result.mean[i % 4] += b[i];
    }
    const double count = double(values) / 3.0;
    result.relMse = squares / (3.0 * count);
    result.relMseOfNoise = noise / (3.0 * count);
    for (size_t c = 0; c < 3; ++c) {
        result.meanOfReference[c] /= count;
        result.mean[c] /= count;
    }
    FlipOfPictures flip = FlipOf(renderer, a, b, picture.size, exposureEv, counts);
    result.flip = flip.mean;
    result.flipMap = std::move(flip.map);
    result.ssim = SsimOf(a, b, picture.size, exposureEv, counts);
    result.z = ScoresOf(a, b, reference.variance, picture.variance, counts);
    return result;
}

image::Image8 ShowRadiance(Renderer& renderer, const Texels& radiance, Extent2D size, float exposureEv) {
    renderer.BeginFrame();
    const Readback shown = renderer.ReadBack(Displayed(renderer, "shown", radiance, size, exposureEv));
    renderer.Execute();
    return {size.width, size.height, WaitForValues<uint8_t>(shown)};
}

image::Image8 ShowHeat(Renderer& renderer, const std::vector<float>& values, Extent2D size, float maximum) {
    renderer.BeginFrame();
    const TextureId map = passes::UploadTexels(renderer, std::as_bytes(std::span(values)),
                                               renderer.CreateTexture("values", {size, Format::R32Float}));
    const Readback shown = renderer.ReadBack(passes::Heat(renderer, map, maximum));
    renderer.Execute();
    return {size.width, size.height, WaitForValues<uint8_t>(shown)};
}

std::vector<float> StopsBetween(const Texels& reference, const Texels& picture, float floor) {
    std::vector<float> stops(reference.size() / 4);
    for (size_t i = 0; i < stops.size(); ++i)
        stops[i] = std::log2(std::max(LuminanceOf(&picture[4 * i]), floor) /
                             std::max(LuminanceOf(&reference[4 * i]), floor));
    return stops;
}

image::Image8 ShowStops(const std::vector<float>& stops, Extent2D size, float maximum) {
    image::Image8 image{size.width, size.height, std::vector<uint8_t>(4 * stops.size(), 255)};
    const auto code = [](float value) { return static_cast<uint8_t>(std::lround(255.0f * value)); };
    for (size_t i = 0; i < stops.size(); ++i) {
        const float t = std::clamp(stops[i] / maximum, -1.0f, 1.0f), size1 = std::abs(t);
        // White fades to the hue in the first half, the hue to its dark shade in the second
        const float others = 1.0f - std::min(2.0f * size1, 1.0f),
                    own = 1.0f - 0.5f * std::max(2.0f * size1 - 1.0f, 0.0f);
        uint8_t* const texel = &image.rgba[4 * i];
        texel[0] = code(t > 0.0f ? own : others);
        texel[1] = code(others);
        texel[2] = code(t > 0.0f ? others : own);
    }
    return image;
}

}  // namespace raygraph::session
