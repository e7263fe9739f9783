#include "editor/viewport/capture.h"

#include "renderer/graph/readback_values.h"

namespace raygraph::viewport {

void CaptureRequests::Declare(Renderer& renderer, const SceneIds& scene,
                              const passes::TraceSettings& settings, const Shown& shown) {
    if (!m_captures.HasUnanswered() || shown.progress.sampleCount == 0 || !shown.progress.cursor.IsAtStart())
        return;
    const passes::PrimaryHitIds hits =
        passes::PrimaryHits(renderer, scene, settings, passes::FilmPosition::Center);
    m_captures.DeclareReplies(renderer, [&](std::monostate) -> decltype(m_captures)::Reply {
        const passes::SumsReadback sums(renderer, shown.samples);
        const Readback albedo = renderer.ReadBack(hits.albedo), normal = renderer.ReadBack(hits.normal),
                       position = renderer.ReadBack(hits.position), ids = renderer.ReadBack(hits.ids);
        std::vector<Readback> readbacks = sums.Readbacks();
        readbacks.insert(readbacks.end(), {albedo, normal, position, ids});
        std::optional<Readback> denoised;
        if (shown.denoised) denoised = readbacks.emplace_back(renderer.ReadBack(*shown.denoised));
        return {std::move(readbacks), [=] {
                    const std::vector<uint32_t> all = ValuesOf<uint32_t>(ids);
                    const passes::ExactSums taken = sums.Values();
                    const uint32_t count = shown.progress.sampleCount;
                    return CaptureResult{
                        .extent = ids.Extent(),
                        .isRaster = shown.isRaster,
                        .sampleCount = count,
                        .camera = shown.camera,
                        .lens = shown.lens,
                        .paths = shown.paths,
                        .raster = shown.raster,
                        .environment = shown.environment,
                        .sums = taken,
                        .mean = passes::MeanOf(taken, count),
                        .variance = passes::VarianceOf(taken, count),
                        .denoised = denoised ? ValuesOf<float>(*denoised) : std::vector<float>{},
                        .albedo = ValuesOf<float>(albedo),
                        .normal = ValuesOf<float>(normal),
                        .depth = ChannelOf(ValuesOf<float>(position), 3),
                        .instance = ChannelOf(all, 0),
                        .material = ChannelOf(all, 1)};
                }};
    });
}

}  // namespace raygraph::viewport
