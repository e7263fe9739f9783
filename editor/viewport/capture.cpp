#include "editor/viewport/capture.h"

#include <cstring>

#include "base/error.h"

namespace raygraph::viewport {

struct Capture::State {
    bool isSubmitted = false;
    bool isRaster = false;
    uint32_t sampleCount = 0;
    scene::CameraView camera;
    PathSettings paths;
    EnvironmentSettings environment;
    Readback mean, variance, albedo, normal, position, ids;
};

namespace {

template <typename T>
std::vector<T> TexelsOf(const Readback& readback) {
    const std::span<const std::byte> bytes = readback.Bytes();
    std::vector<T> texels(bytes.size() / sizeof(T));
    if (!texels.empty()) std::memcpy(texels.data(), bytes.data(), bytes.size());
    return texels;
}

// One channel of texels of four.
template <typename T>
std::vector<T> ChannelOf(const std::vector<T>& texels, size_t channel) {
    std::vector<T> values;
    values.reserve(texels.size() / 4);
    for (size_t i = channel; i < texels.size(); i += 4) values.push_back(texels[i]);
    return values;
}

}  // namespace

bool Capture::IsTaken() const {
    return m_state && m_state->isSubmitted;
}

bool Capture::IsReady() const {
    if (!IsTaken()) return false;
    const State& state = *m_state;
    return state.mean.IsReady() && state.variance.IsReady() && state.albedo.IsReady() &&
           state.normal.IsReady() && state.position.IsReady() && state.ids.IsReady();
}

CaptureResult Capture::Result() const {
    if (!IsReady()) throw Error(ErrorKind::Usage, "Capture: its answer is not there yet");
    const std::vector<uint32_t> ids = TexelsOf<uint32_t>(m_state->ids);
    return {.extent = m_state->mean.Extent(),
            .isRaster = m_state->isRaster,
            .sampleCount = m_state->sampleCount,
            .camera = m_state->camera,
            .paths = m_state->paths,
            .environment = m_state->environment,
            .mean = TexelsOf<float>(m_state->mean),
            .variance = TexelsOf<float>(m_state->variance),
            .albedo = TexelsOf<float>(m_state->albedo),
            .normal = TexelsOf<float>(m_state->normal),
            .depth = ChannelOf(TexelsOf<float>(m_state->position), 3),
            .instance = ChannelOf(ids, 0),
            .material = ChannelOf(ids, 1)};
}

Capture CaptureRequests::Request() {
    Capture capture;
    capture.m_state = std::make_shared<Capture::State>();
    m_captures.push_back(capture.m_state);
    return capture;
}

void CaptureRequests::Declare(Renderer& renderer, const SceneIds& scene,
                              const passes::TraceSettings& settings, const Shown& shown) {
    std::erase_if(m_captures,
                  [](const std::shared_ptr<Capture::State>& state) { return state->isSubmitted; });
    if (m_captures.empty() || shown.progress.sampleCount == 0 || !shown.progress.cursor.IsAtStart()) return;
    const passes::PrimaryHitIds hits =
        passes::PrimaryHits(renderer, scene, settings, passes::FilmPosition::Center);
    for (const std::shared_ptr<Capture::State>& state : m_captures) {
        state->isRaster = shown.isRaster;
        state->sampleCount = shown.progress.sampleCount;
        state->camera = shown.camera;
        state->paths = shown.paths;
        state->environment = shown.environment;
        state->mean = renderer.ReadBack(shown.mean);
        state->variance = renderer.ReadBack(shown.variance);
        state->albedo = renderer.ReadBack(hits.albedo);
        state->normal = renderer.ReadBack(hits.normal);
        state->position = renderer.ReadBack(hits.position);
        state->ids = renderer.ReadBack(hits.ids);
        renderer.OnSubmitted([state] { state->isSubmitted = true; });
    }
}

}  // namespace raygraph::viewport
