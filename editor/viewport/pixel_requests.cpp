#include "editor/viewport/pixel_requests.h"

#include <limits>

#include "passes/probe.h"
#include "renderer/graph/readback_values.h"

namespace raygraph::viewport {

namespace {

bool Contains(Extent2D extent, glm::uvec2 pixel) {
    return pixel.x < extent.width && pixel.y < extent.height;
}

PickResult PickOf(glm::uvec2 pixel, const glm::uvec4& ids, const glm::vec4& position,
                  const glm::vec4& normal) {
    constexpr uint32_t kMiss = 0xFFFFFFFFu;
    if (ids.x == kMiss) return {.pixel = pixel};
    return {.pixel = pixel,
            .isHit = true,
            .instance = ids.x,
            .primitive = ids.z,
            .material = ids.y,
            .geometry = ids.w,
            .position = glm::vec3(position),
            .normal = glm::vec3(normal),
            .depth = position.w};
}

// Holds the readback of a view's pixel.
struct Probed {
    Readback texels;
    uint32_t sampleCount = 0;
};

std::optional<PixelValue> ValueOf(const std::optional<Probed>& probed) {
    if (!probed) return std::nullopt;
    const passes::ProbedPixel texels = ValuesOf<passes::ProbedPixel>(probed->texels).front();
    const auto count = static_cast<float>(probed->sampleCount);
    PixelValue value{.radiance = glm::vec3(texels.mean),
                     .coverage = texels.mean.w,
                     .sampleCount = probed->sampleCount,
                     .standardError = glm::vec3(std::numeric_limits<float>::infinity())};
    if (probed->sampleCount > 1) value.standardError = glm::sqrt(glm::vec3(texels.variance) / count);
    return value;
}

}  // namespace

void PixelRequests::DeclarePicks(Renderer& renderer, const SceneIds& scene,
                                 const passes::TraceSettings& settings) {
    m_picks.DeclareReplies(renderer, [&](glm::uvec2 pixel) -> decltype(m_picks)::Reply {
        if (!Contains(settings.extent, pixel)) return {{}, [pixel] { return PickResult{.pixel = pixel}; }};
        passes::TraceSettings one = settings;
        one.region = {pixel.x, pixel.y, 1, 1};
        const passes::PrimaryHitIds hits =
            passes::PrimaryHits(renderer, scene, one, passes::FilmPosition::Center);
        const Readback ids = renderer.ReadBack(hits.ids), position = renderer.ReadBack(hits.position),
                       normal = renderer.ReadBack(hits.normal);
        return {{ids, position, normal}, [=] {
                    return PickOf(pixel, ValuesOf<glm::uvec4>(ids).front(),
                                  ValuesOf<glm::vec4>(position).front(), ValuesOf<glm::vec4>(normal).front());
                }};
    });
}

void PixelRequests::DeclareInspections(Renderer& renderer, Extent2D extent,
                                       const std::optional<Shown>& pathTraced,
                                       const std::optional<Shown>& raster) {
    m_inspections.DeclareReplies(renderer, [&](glm::uvec2 pixel) {
        decltype(m_inspections)::Reply reply;
        const auto probe = [&](const std::optional<Shown>& shown) {
            std::optional<Probed> probed;
            if (!shown || !Contains(extent, pixel)) return probed;
            const uint32_t ahead = shown->progress.cursor.Has(pixel.x, pixel.y) ? 1 : 0;
            const uint32_t count = shown->progress.sampleCount + ahead;
            if (count == 0) return probed;
            const BufferId texels =
                passes::Probe(renderer, shown->samples, shown->progress, {pixel.x, pixel.y, 1, 1});
            probed = Probed{renderer.ReadBack(texels), count};
            reply.readbacks.push_back(probed->texels);
            return probed;
        };
        reply.finish = [pixel, ofPaths = probe(pathTraced), ofRaster = probe(raster)] {
            return InspectResult{pixel, ValueOf(ofPaths), ValueOf(ofRaster)};
        };
        return reply;
    });
}

void PixelRequests::DeclareSamples(Renderer& renderer, const SceneIds& scene,
                                   const passes::TraceSettings& settings, bool mayWait) {
    const auto settingsOf = [&](const SampleRange& samples) {
        passes::TraceSettings traced = settings;
        traced.region = {samples.pixel.x, samples.pixel.y, 1, 1};
        traced.sampleIndex = samples.first;
        traced.sampleCount = samples.count;
        return traced;
    };
    m_samples.DeclareReplies(
        renderer, [&](const SampleRange& asked) -> std::optional<decltype(m_samples)::Reply> {
            PixelSamples answer{.pixel = asked.pixel, .firstSample = asked.first, .values = {}};
            if (!Contains(settings.extent, asked.pixel)) return {{{}, [answer] { return answer; }}};
            // Paths of Roulette::Frame have one length for each sample
            const bool isOneByOne = settings.roulette.kind == Roulette::Frame;
            const PassId first = renderer.NextPass();
            std::vector<TextureId> pictures;
            for (uint32_t done = 0; done < asked.count; done += isOneByOne ? 1 : asked.count)
                pictures.push_back(passes::Trace(renderer, scene,
                                                 settingsOf({.pixel = asked.pixel,
                                                             .first = asked.first + done,
                                                             .count = isOneByOne ? 1 : asked.count}))
                                       .radiance);
            if (!mayWait && !renderer.PreparePipelines(first, renderer.NextPass())) return std::nullopt;
            decltype(m_samples)::Reply reply;
            for (const TextureId picture : pictures) reply.readbacks.push_back(renderer.ReadBack(picture));
            reply.finish = [answer, readbacks = reply.readbacks]() mutable {
                answer.values.clear();
                for (const Readback& texels : readbacks)
                    for (const glm::vec4& value : ValuesOf<glm::vec4>(texels))
                        answer.values.emplace_back(value);
                return answer;
            };
            return reply;
        });
    m_paths.DeclareReplies(renderer,
                           [&](const SampleRange& asked) -> std::optional<decltype(m_paths)::Reply> {
                               PathResult answer{.pixel = asked.pixel,
                                                 .sample = asked.first,
                                                 .vertices = {},
                                                 .origin = scene.origin,
                                                 .lights = scene.lightSet};
                               if (!Contains(settings.extent, asked.pixel))
                                   return {{{}, [answer] { return answer; }}};
                               const PassId first = renderer.NextPass();
                               const passes::TraceIds traced =
                                   passes::Trace(renderer, scene, settingsOf(asked), {.record = true});
                               if (!mayWait && !renderer.PreparePipelines(first, renderer.NextPass()))
                                   return std::nullopt;
                               const Readback record = renderer.ReadBack(traced.record);
                               return {{{record}, [answer, record]() mutable {
                                            answer.vertices = passes::PathOf(record);
                                            return answer;
                                        }}};
                           });
}

}  // namespace raygraph::viewport
