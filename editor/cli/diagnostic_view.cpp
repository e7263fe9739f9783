#include "editor/cli/diagnostic_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/check.h"

namespace raygraph::cli {

namespace {

using Color = std::array<float, 3>;
constexpr uint32_t kMiss = 0xFFFFFFFFu;

uint8_t ToByte(float value) {
    return static_cast<uint8_t>(std::lround(255.0f * std::clamp(value, 0.0f, 1.0f)));
}

// IEC 61966-2-1
float EncodeSrgb(float linear) {
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

// Neighbouring ids get far apart hues (steps of the golden ratio), and two levels of brightness.
Color ColorOfId(uint32_t id) {
    const double hue = std::fmod(id * 0.6180339887498949, 1.0);
    const float value = id % 2 == 0 ? 0.95f : 0.7f;
    Color color{};
    for (size_t c = 0; c < 3; c++) {
        const double offset = std::fmod(hue + static_cast<double>(c) / 3.0, 1.0);
        const double ramp = std::clamp(std::abs(offset * 6.0 - 3.0) - 1.0, 0.0, 1.0);
        color[c] = value * static_cast<float>(0.25 + 0.75 * ramp);
    }
    return color;
}

template <typename ColorOf>
image::Image8 Paint(const ImageSize& size, ColorOf&& colorOf) {
    image::Image8 picture{size.width, size.height, std::vector<uint8_t>(4 * size.PixelCount())};
    for (size_t i = 0; i < size.PixelCount(); i++) {
        const Color color = colorOf(i);
        for (size_t c = 0; c < 3; c++) picture.rgba[4 * i + c] = ToByte(color[c]);
        picture.rgba[4 * i + 3] = 255;
    }
    return picture;
}

Color RgbAt(const Texels& texels, size_t i) {
    return {texels[4 * i], texels[4 * i + 1], texels[4 * i + 2]};
}

image::Image8 ShowNormals(const RenderFile& render) {
    return Paint(render.size, [&](size_t i) {
        const Color n = RgbAt(render.normal, i);
        if (n == Color{}) return n;
        return Color{0.5f + 0.5f * n[0], 0.5f + 0.5f * n[1], 0.5f + 0.5f * n[2]};
    });
}

image::Image8 ShowDepth(const RenderFile& render) {
    float nearest = std::numeric_limits<float>::infinity(), farthest = -nearest;
    for (const float z : render.depth) {
        if (!std::isfinite(z)) continue;
        nearest = std::min(nearest, z);
        farthest = std::max(farthest, z);
    }
    constexpr float kDarkest = 0.15f;
    const float scale = farthest > nearest ? (1.0f - kDarkest) / (farthest - nearest) : 0.0f;
    return Paint(render.size, [&](size_t i) {
        const float z = render.depth[i];
        const float grey = std::isfinite(z) ? 1.0f - scale * (z - nearest) : 0.0f;
        return Color{grey, grey, grey};
    });
}

image::Image8 ShowIds(const ImageSize& size, const std::vector<uint32_t>& ids) {
    return Paint(size, [&](size_t i) { return ids[i] == kMiss ? Color{} : ColorOfId(ids[i]); });
}

template <typename Value, typename IsHit>
Texels Grey(const std::vector<Value>& values, IsHit&& isHit) {
    Texels texels(4 * values.size());
    for (size_t i = 0; i < values.size(); i++) {
        if (!isHit(values[i])) continue;
        for (size_t c = 0; c < 3; c++) texels[4 * i + c] = static_cast<float>(values[i]);
        texels[4 * i + 3] = 1.0f;
    }
    return texels;
}

}  // namespace

image::Image8 ShowView(View view, const RenderFile& render) {
    switch (view) {
        case View::PathTraced:
        case View::Raster:
            break;
        case View::Albedo:
            return Paint(render.size, [&](size_t i) {
                Color color = RgbAt(render.albedo, i);
                for (float& channel : color) channel = EncodeSrgb(channel);
                return color;
            });
        case View::Normals:
            return ShowNormals(render);
        case View::Depth:
            return ShowDepth(render);
        case View::Instance:
            return ShowIds(render.size, render.instance);
        case View::Material:
            return ShowIds(render.size, render.material);
    }
    RG_CHECK(false);
    return {};
}

Texels ViewTexels(View view, const RenderFile& render) {
    const auto isId = [](uint32_t id) { return id != kMiss; };
    switch (view) {
        case View::PathTraced:
        case View::Raster:
            return render.radiance;
        case View::Albedo:
            return render.albedo;
        case View::Normals: {
            Texels texels = render.normal;
            for (size_t i = 3; i < texels.size(); i += 4) texels[i] = render.albedo[i];
            return texels;
        }
        case View::Depth:
            return Grey(render.depth, [](float z) { return std::isfinite(z); });
        case View::Instance:
            return Grey(render.instance, isId);
        case View::Material:
            return Grey(render.material, isId);
    }
    return {};
}

}  // namespace raygraph::cli
