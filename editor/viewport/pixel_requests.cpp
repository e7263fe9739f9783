#include "editor/viewport/pixel_requests.h"

#include <cmath>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "passes/probe.h"

namespace raygraph::viewport {

namespace {

template <typename T>
T FirstOf(const Readback& readback) {
    T value;
    std::memcpy(&value, readback.Bytes().data(), sizeof(T));
    return value;
}

void RequireReady(bool isReady, const char* what) {
    if (!isReady) throw Error(ErrorKind::Usage, std::string(what) + ": its answer is not there yet");
}

bool Contains(Extent2D extent, glm::uvec2 pixel) {
    return pixel.x < extent.width && pixel.y < extent.height;
}

// Notes that the answering frame has been submitted; requests that it did not answer stay.
template <typename State>
void NoteSubmission(Renderer& renderer, const std::shared_ptr<State>& state) {
    renderer.OnSubmitted([state] { state->isSubmitted = true; });
}

template <typename State>
void EraseAnswered(std::vector<std::shared_ptr<State>>& requests) {
    std::erase_if(requests, [](const std::shared_ptr<State>& state) { return state->isSubmitted; });
}

}  // namespace

struct Pick::State {
    glm::uvec2 pixel{0};
    bool isSubmitted = false;
    bool isOutside = false;
    Readback ids, position, normal;
};

struct Inspection::State {
    struct Probed {
        Readback texels;
        uint32_t sampleCount = 0;
    };
    glm::uvec2 pixel{0};
    bool isSubmitted = false;
    std::optional<Probed> pathTraced, raster;
};

bool Pick::IsReady() const {
    if (!m_state || !m_state->isSubmitted) return false;
    return m_state->isOutside ||
           (m_state->ids.IsReady() && m_state->position.IsReady() && m_state->normal.IsReady());
}

PickResult Pick::Result() const {
    RequireReady(IsReady(), "Pick");
    PickResult result{.pixel = m_state->pixel};
    if (m_state->isOutside) return result;
    const auto ids = FirstOf<glm::uvec4>(m_state->ids);
    constexpr uint32_t kMiss = 0xFFFFFFFFu;
    if (ids.x == kMiss) return result;
    const auto position = FirstOf<glm::vec4>(m_state->position);
    result.isHit = true;
    result.instance = ids.x;
    result.material = ids.y;
    result.primitive = ids.z;
    result.geometry = ids.w;
    result.position = glm::vec3(position);
    result.depth = position.w;
    result.normal = glm::vec3(FirstOf<glm::vec4>(m_state->normal));
    return result;
}

bool Inspection::IsReady() const {
    if (!m_state || !m_state->isSubmitted) return false;
    const auto isThere = [](const std::optional<State::Probed>& probed) {
        return !probed || probed->texels.IsReady();
    };
    return isThere(m_state->pathTraced) && isThere(m_state->raster);
}

InspectResult Inspection::Result() const {
    RequireReady(IsReady(), "Inspection");
    const auto valueOf = [](const std::optional<State::Probed>& probed) -> std::optional<PixelValue> {
        if (!probed) return std::nullopt;
        const auto texels = FirstOf<passes::ProbedTexels>(probed->texels);
        const auto count = static_cast<float>(probed->sampleCount);
        PixelValue value{.radiance = glm::vec3(texels.mean),
                         .coverage = texels.mean.w,
                         .sampleCount = probed->sampleCount,
                         .standardError = glm::vec3(std::numeric_limits<float>::infinity())};
        if (probed->sampleCount > 1) value.standardError = glm::sqrt(glm::vec3(texels.variance) / count);
        return value;
    };
    return {m_state->pixel, valueOf(m_state->pathTraced), valueOf(m_state->raster)};
}

Pick PixelRequests::RequestPick(glm::uvec2 pixel) {
    Pick pick;
    pick.m_state = std::make_shared<Pick::State>();
    pick.m_state->pixel = pixel;
    m_picks.push_back(pick.m_state);
    return pick;
}

Inspection PixelRequests::RequestInspection(glm::uvec2 pixel) {
    Inspection inspection;
    inspection.m_state = std::make_shared<Inspection::State>();
    inspection.m_state->pixel = pixel;
    m_inspections.push_back(inspection.m_state);
    return inspection;
}

void PixelRequests::DeclarePicks(Renderer& renderer, const SceneIds& scene,
                                 const passes::TraceSettings& settings) {
    EraseAnswered(m_picks);
    for (const std::shared_ptr<Pick::State>& pick : m_picks) {
        NoteSubmission(renderer, pick);
        pick->isOutside = !Contains(settings.extent, pick->pixel);
        if (pick->isOutside) continue;
        passes::TraceSettings one = settings;
        one.region = {pick->pixel.x, pick->pixel.y, 1, 1};
        const passes::PrimaryHitIds hits =
            passes::PrimaryHits(renderer, scene, one, passes::FilmPosition::Center);
        pick->ids = renderer.ReadBack(hits.ids);
        pick->position = renderer.ReadBack(hits.position);
        pick->normal = renderer.ReadBack(hits.normal);
    }
}

void PixelRequests::DeclareInspections(Renderer& renderer, Extent2D extent,
                                       const std::optional<Shown>& pathTraced,
                                       const std::optional<Shown>& raster) {
    EraseAnswered(m_inspections);
    for (const std::shared_ptr<Inspection::State>& inspection : m_inspections) {
        NoteSubmission(renderer, inspection);
        const glm::uvec2 pixel = inspection->pixel;
        const auto probe = [&](const std::optional<Shown>& shown) {
            std::optional<Inspection::State::Probed> probed;
            if (!shown || !Contains(extent, pixel)) return probed;
            const uint32_t ahead = shown->progress.cursor.Has(pixel.x, pixel.y) ? 1 : 0;
            const uint32_t count = shown->progress.sampleCount + ahead;
            if (count == 0) return probed;
            const BufferId texels = passes::Probe(renderer, shown->mean, shown->variance, pixel);
            probed = Inspection::State::Probed{renderer.ReadBack(texels), count};
            return probed;
        };
        inspection->pathTraced = probe(pathTraced);
        inspection->raster = probe(raster);
    }
}

}  // namespace raygraph::viewport
