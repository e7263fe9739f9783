#include "editor/session/explain/noise.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/text.h"
#include "editor/session/file/sample_ranges.h"
#include "editor/session/settings/picture_settings.h"
#include "shaders/core/ramp.glsl"

namespace raygraph::session {

namespace {

// The variance of a pixel's mean and the mean, both over R, G and B.
struct PixelNoise {
    double variance = 0.0;
    double mean = 0.0;
    double RelativeError() const {
        return variance > 0.0 ? std::sqrt(variance) / std::max(mean, 1e-30) : 0.0;
    }
};

std::vector<PixelNoise> NoiseOf(const RenderFile& render) {
    if (render.variance.empty() || SampleCount(render.samples) < 2)
        throw MakeError(ErrorKind::BadInput, "the render has {}, so that its noise is unknown",
                        render.variance.empty() ? "no variance" : "one sample");
    const auto uniform = static_cast<double>(SampleCount(render.samples));
    std::vector<PixelNoise> noise(render.radiance.size() / 4);
    for (size_t i = 0; i < noise.size(); ++i) {
        const double samples = render.adaptive ? render.adaptive->counts[i] : uniform;
        for (size_t c = 0; c < 3; ++c) {
            noise[i].variance += render.variance[4 * i + c] / (3.0 * samples);
            noise[i].mean += render.radiance[4 * i + c] / 3.0;
        }
    }
    return noise;
}

// The luminances of the light groups in pixel i; negative ones, of filtered pictures, count as black.
std::vector<double> GroupLuminances(const RenderFile& render, size_t i) {
    std::vector<double> luminances;
    for (const Texels& group : render.lightGroups)
        luminances.push_back(
            std::max(0.0, double{shading::Luminance({group[4 * i], group[4 * i + 1], group[4 * i + 2]})}));
    return luminances;
}

void RequireGroups(const RenderFile& render) {
    if (render.lightGroups.empty())
        throw MakeError(ErrorKind::BadInput,
                        "the render has no light groups: render it with --light-group NAME=PATTERN");
}

image::Image8 Black(Extent2D size) {
    image::Image8 map{.width = size.width, .height = size.height, .rgba = {}};
    map.rgba.assign(size_t{4} * size.width * size.height, 0);
    for (size_t i = 3; i < map.rgba.size(); i += 4) map.rgba[i] = 255;
    return map;
}

// `color` is display-encoded.
void Set(image::Image8& map, size_t pixel, const glm::vec3& color) {
    for (int c = 0; c < 3; ++c)
        map.rgba[4 * pixel + static_cast<size_t>(c)] =
            static_cast<uint8_t>(std::lround(255.0f * std::clamp(color[c], 0.0f, 1.0f)));
}

}  // namespace

std::vector<NoisyPixel> NoisiestPixels(const RenderFile& render, size_t count) {
    const std::vector<PixelNoise> noise = NoiseOf(render);
    double all = 0.0;
    for (const PixelNoise& pixel : noise) all += pixel.variance;
    if (!(all > 0.0)) return {};
    std::vector<size_t> order(noise.size());
    std::iota(order.begin(), order.end(), size_t{0});
    count = std::min(count, order.size());
    const auto end = order.begin() + static_cast<ptrdiff_t>(count);
    std::partial_sort(order.begin(), end, order.end(), [&](size_t a, size_t b) {
        return noise[a].variance != noise[b].variance ? noise[a].variance > noise[b].variance : a < b;
    });
    const passes::Region part = RenderedPart(SettingsFrom(render.settings));
    std::vector<NoisyPixel> noisiest;
    for (const size_t i : std::span(order).first(count))
        noisiest.push_back({{part.x + i % render.size.width, part.y + i / render.size.width},
                            noise[i].variance / all,
                            noise[i].RelativeError()});
    return noisiest;
}

image::Image8 NoiseMap(const RenderFile& render) {
    const std::vector<PixelNoise> noise = NoiseOf(render);
    image::Image8 map = Black(render.size);
    for (size_t i = 0; i < noise.size(); ++i) {
        if (noise[i].variance == 0.0 && noise[i].mean == 0.0) continue;
        const double height = 1.0 + std::log10(std::max(noise[i].RelativeError(), 1e-3)) / 3.0;
        Set(map, i, shading::SrgbEncode(shading::HeatColor(static_cast<float>(height))));
    }
    return map;
}

std::vector<LightGroupShare> LightGroupShares(const RenderFile& render,
                                              const std::optional<glm::uvec2>& pixel) {
    RequireGroups(render);
    const PictureSettings settings = SettingsFrom(render.settings);
    size_t first = 0, end = render.radiance.size() / 4;
    if (pixel) {
        const passes::Region part = RenderedPart(settings);
        // Pixels to the left of the part wrap around to large numbers
        const glm::uvec2 place = *pixel - glm::uvec2(part.x, part.y);
        if (place.x >= render.size.width || place.y >= render.size.height)
            throw MakeError(ErrorKind::Usage, "pixel {},{} was not rendered", pixel->x, pixel->y);
        first = size_t{place.y} * render.size.width + place.x;
        end = first + 1;
    }
    std::vector<LightGroupShare> shares;
    for (const std::string& name : LightGroupNames(settings.lightGroups)) shares.push_back({name});
    double all = 0.0;
    for (size_t i = first; i < end; ++i) {
        const std::vector<double> luminances = GroupLuminances(render, i);
        for (size_t group = 0; group < luminances.size(); ++group) {
            shares[group].share += luminances[group];
            all += luminances[group];
        }
    }
    std::erase_if(shares, [](const LightGroupShare& group) { return group.share == 0.0; });
    for (LightGroupShare& group : shares) group.share /= all;
    std::ranges::stable_sort(shares, std::ranges::greater(), &LightGroupShare::share);
    return shares;
}

image::Image8 LightGroupMap(const RenderFile& render) {
    RequireGroups(render);
    image::Image8 map = Black(render.size);
    for (size_t i = 0; i < render.radiance.size() / 4; ++i) {
        const std::vector<double> luminances = GroupLuminances(render, i);
        const double all = std::reduce(luminances.begin(), luminances.end());
        if (all == 0.0) continue;
        glm::vec3 color(0.0f);
        for (size_t group = 0; group < luminances.size(); ++group)
            color +=
                static_cast<float>(luminances[group] / all) * shading::IdColor(static_cast<uint32_t>(group));
        Set(map, i, color);
    }
    return map;
}

}  // namespace raygraph::session
