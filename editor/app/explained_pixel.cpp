#include "editor/app/explained_pixel.h"

#include <algorithm>
#include <utility>

namespace raygraph::editor {

std::vector<PathLine> LinesOfPath(const session::ExplainedPath& path, const glm::dvec3& origin,
                                  double reach) {
    std::vector<PathLine> lines;
    const auto ray = [&](const glm::vec3& from, const glm::vec3& direction, double length) {
        const glm::dvec3 start = origin + glm::dvec3(from);
        return std::pair(start, start + std::min(length, reach) * glm::dvec3(direction));
    };
    for (size_t i = 0; i < path.vertices.size(); ++i) {
        const gpu::PathVertexRecord& vertex = path.vertices[i];
        if (static_cast<PathEvent>(vertex.event) == PathEvent::Environment) {
            const auto [from, to] = ray(vertex.origin, vertex.direction, reach);
            lines.push_back({PathLine::Kind::Escaping, i, from, to});
        } else {
            lines.push_back({PathLine::Kind::Ray, i, origin + glm::dvec3(vertex.origin),
                             origin + glm::dvec3(vertex.position)});
        }
        if (vertex.chosen == gpu::kNoRecord || vertex.unoccluded == glm::vec3(0.0f)) continue;
        const bool isLit = vertex.visibility != glm::vec3(0.0f);
        const auto [from, to] = ray(vertex.shadowOrigin, vertex.shadowDirection, vertex.shadowDistance);
        lines.push_back({isLit ? PathLine::Kind::Lit : PathLine::Kind::Occluded, i, from, to});
    }
    return lines;
}

ExplainedPixel::View ExplainedPixel::ViewOf(const viewport::Viewport& view) {
    View now{.revisions = view.Scene().Revisions(),
             .camera = view.Camera(),
             .paths = view.Paths(),
             .size = view.Size()};
    now.camera.aspect = 1.0f;  // that of the size applies
    return now;
}

bool ExplainedPixel::IsCurrent(const viewport::Viewport& view) const {
    return m_view && *m_view == ViewOf(view);
}

void ExplainedPixel::Ask(viewport::Viewport& view, glm::uvec2 pixel) {
    const uint32_t samples = view.Progress().pathTracedSamples;
    const uint32_t count = std::min(samples > 0 ? samples : kSamples, view.kMaxRequestedSamples);
    Clear();
    m_view = ViewOf(view);
    m_samples = view.RequestSamples(pixel, 0, count);
}

void ExplainedPixel::AskPath(viewport::Viewport& view, uint32_t sample) {
    if (IsPending() || !m_values || !IsCurrent(view)) return;
    m_path = view.RequestPath(m_values->pixel, sample);
}

void ExplainedPixel::Observe(viewport::Viewport& view, const scene::SceneData& scene) {
    if (m_samples && m_samples->IsReady()) {
        viewport::PixelSamples samples = m_samples->Result();
        m_samples.reset();
        if (!samples.values.empty()) {
            m_values = session::ExplainSamples(samples.pixel, samples.firstSample, std::move(samples.values));
            AskPath(view, session::BrightestOf(*m_values, 1).front());
        }
    }
    if (m_path && m_path->IsReady()) {
        viewport::PathResult path = m_path->Result();
        m_path.reset();
        if (path.vertices.empty()) return;
        const session::ExplainedPath explained =
            session::PathIn(*m_values, path.sample, std::move(path.vertices));
        if (!explained.isExact && !IsCurrent(view)) return;  // it is of a view that has changed meanwhile
        m_shown = *m_values;
        m_shown->origin = path.origin;
        m_shown->names = session::PathNames(scene);
        m_shown->names.NumberLights(path.lights);
        m_shown->paths = {explained};
        vertex = 0;
    }
}

}  // namespace raygraph::editor
