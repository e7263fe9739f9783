#include "editor/session/frames/adaptive_frames.h"

#include <algorithm>
#include <bit>
#include <string>
#include <utility>

#include "renderer/graph/readback_values.h"

namespace raygraph::session {

namespace {

// Rounds down, so that frames have few different sizes.
uint32_t RoundedDown(uint32_t samples) {
    const uint32_t unit = std::max(std::bit_floor(samples) / 4, 1u);
    return samples / unit * unit;
}

std::string VarianceName(uint32_t base) {
    return "adaptive.variance" + std::to_string(base);
}
std::string MeanName(uint32_t base) {
    return "adaptive.mean" + std::to_string(base);
}

}  // namespace

AdaptiveFrames::AdaptiveFrames(Renderer& renderer, Extent2D size, uint32_t firstSample)
    : m_renderer(renderer),
      m_size(size),
      m_firstSample(firstSample),
      m_counts(size),
      m_lists{ColorList{passes::PixelList(renderer.Device(), size)},
              ColorList{passes::PixelList(renderer.Device(), size)}} {
    ForgetBelow(kLastStage);  // bases of an earlier picture
}

AdaptiveFrames::AdaptiveFrames(Renderer& renderer, Extent2D size, uint32_t firstSample,
                               const AdaptiveState& state)
    : m_renderer(renderer),
      m_size(size),
      m_firstSample(firstSample),
      m_counts(size, state),
      m_lists{ColorList{passes::PixelList(renderer.Device(), size)},
              ColorList{passes::PixelList(renderer.Device(), size)}} {
    ForgetBelow(kLastStage);
    for (const auto& [base, noted] : state.noted) {
        const passes::VarianceIds ids = Noted(base);
        passes::UploadTexels(renderer, std::as_bytes(std::span(noted.variance)), ids.variance);
        passes::UploadTexels(renderer, std::as_bytes(std::span(noted.mean)), ids.mean);
    }
}

passes::VarianceIds AdaptiveFrames::Noted(uint32_t base) const {
    return {m_renderer.Persist(VarianceName(base), {m_size, Format::R32Float}),
            m_renderer.Persist(MeanName(base), {m_size, Format::R32Float})};
}

void AdaptiveFrames::ForgetBelow(uint32_t base) {
    for (uint32_t of = kFirstBase; of < base; of *= 2) {
        m_renderer.Forget(VarianceName(of));
        m_renderer.Forget(MeanName(of));
    }
}

void AdaptiveFrames::SetList(const AdaptiveCounts::Next& next) {
    const std::vector<AdaptiveCounts::WalkPixel>& walk = m_counts.WalkPixels(next.color);
    std::vector<gpu::ListedPixel> pixels(walk.size());
    std::ranges::transform(walk, pixels.begin(), [&](const AdaptiveCounts::WalkPixel& at) {
        return gpu::ListedPixel{at.pixel % m_size.width | at.pixel / m_size.width << 16u,
                                m_firstSample + at.count};
    });
    ColorList& list = m_lists[next.color];
    list.list.Set(pixels);
    list.listed = m_counts.WalkId(next.color);
}

bool AdaptiveFrames::PrepareFor(uint32_t average, const passes::Accumulation& radiance) {
    using Kind = AdaptiveCounts::Next::Kind;
    AdaptiveCounts::Next next = m_counts.NextTo(average);
    for (; next.kind == Kind::Decision; next = m_counts.NextTo(average)) Decide(next.color, radiance);
    return next.kind == Kind::Samples;
}

void AdaptiveFrames::Decide(uint32_t color, const passes::Accumulation& radiance) {
    const AdaptiveState state = m_counts.State();
    const uint32_t base = BaseAfter(state.stages[color]);
    if (PixelsOfColor(m_size, 1 - color) == 0) {
        const std::vector<float> none(state.counts.size(), 0.0f);
        return m_counts.Decide(color, {none, none});
    }
    // The others were noted before they got more
    std::vector<gpu::ListedPixel> pixels;
    ForPixelsOfColor(m_size, 1 - color, [&](size_t i) {
        const auto pixel = static_cast<uint32_t>(i);
        if (state.counts[i] == base)
            pixels.push_back({pixel % m_size.width | pixel / m_size.width << 16u, base});
    });
    m_renderer.BeginFrame();
    passes::VarianceIds noted = Noted(base);
    if (!pixels.empty()) {
        ColorList& list = m_lists[1 - color];
        list.list.Set(pixels);
        list.listed = 0;
        noted = passes::RecordVariance(m_renderer, radiance,
                                       list.list.Declare(m_renderer, static_cast<uint32_t>(pixels.size())),
                                       base, base, noted);
    }
    const VarianceReadback readback = ReadBackVariances(noted);
    m_renderer.Execute();
    m_counts.Decide(color, {WaitForValues<float>(readback.variance), WaitForValues<float>(readback.mean)});
    ForgetBelow(m_counts.FirstBaseNeeded());
}

AdaptiveFrames::Samples AdaptiveFrames::Take(const passes::Accumulation& radiance, uint32_t average,
                                             uint64_t mostTexels, uint32_t mostRows) {
    const AdaptiveCounts::Next next = m_counts.NextTo(average);
    ColorList& list = m_lists[next.color];
    if (list.listed != m_counts.WalkId(next.color)) SetList(next);
    const passes::ListedPixels pixels = list.list.Declare(m_renderer, next.pixels);
    if (const uint32_t base = m_counts.BaseToRecord(next.color); base > 0)
        std::ignore =
            passes::RecordVariance(m_renderer, radiance, pixels, m_firstSample + base, base, Noted(base));
    const uint64_t most = std::min(
        {uint64_t{next.length}, mostTexels / pixels.count, uint64_t{mostRows / pixels.extent.height}});
    const Samples samples{pixels, next.taken,
                          RoundedDown(static_cast<uint32_t>(std::max<uint64_t>(most, 1)))};
    m_counts.Advance(next, samples.count);
    return samples;
}

TextureId AdaptiveFrames::CountsTexture() const {
    return passes::UploadCounts(m_renderer, m_counts.State().counts, m_size);
}

AdaptiveFrames::VarianceReadback AdaptiveFrames::ReadBackVariances(const passes::VarianceIds& noted) {
    return {m_renderer.ReadBack(noted.variance), m_renderer.ReadBack(noted.mean)};
}

void AdaptiveFrames::ReadBack() {
    m_noted.clear();
    const AdaptiveState state = m_counts.State();
    uint32_t most[kColors] = {};
    for (uint32_t color = 0; color < kColors; ++color) {
        ForPixelsOfColor(m_size, color,
                         [&](size_t i) { most[color] = std::max(most[color], state.counts[i]); });
        for (uint32_t base = FirstBaseToKeep(state, color); base < most[color]; base *= 2)
            if (!m_noted.contains(base)) m_noted[base] = ReadBackVariances(Noted(base));
    }
}

AdaptiveState AdaptiveFrames::Take() const {
    AdaptiveState state = m_counts.State();
    for (const auto& [base, readback] : m_noted) {
        PixelVariances& noted = state.noted[base];
        noted = {WaitForValues<float>(readback.variance), WaitForValues<float>(readback.mean)};
        for (uint32_t color = 0; color < kColors; ++color)
            ForPixelsOfColor(m_size, color, [&, base = base](size_t i) {
                if (state.counts[i] > base && base >= FirstBaseToKeep(state, color)) return;
                noted.variance[i] = noted.mean[i] = 0.0f;
            });
    }
    return state;
}

}  // namespace raygraph::session
