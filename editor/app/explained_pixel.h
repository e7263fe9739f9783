// ExplainedPixel is the pixel that the editor explains: its samples in the path-traced view, and the path of
// one of them, as an explanation in words and as lines in the world. It draws nothing. Threads: that of the
// viewport.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "editor/session/explain/explain.h"
#include "editor/viewport/viewport.h"

namespace raygraph::editor {

// Describes a part of a path as a straight line, meters in world space.
struct PathLine {
    enum class Kind : uint8_t {
        Ray,       // to the vertex
        Escaping,  // to the vertex, which is the environment
        Lit,       // from the vertex to a light, which brings light
        Occluded   // from the vertex to a light, which something is in the way of
    };
    Kind kind = Kind::Ray;
    size_t vertex = 0;  // counted from 0
    glm::dvec3 from{0.0}, to{0.0};
};

// Returns the rays of a path in their order, and after each ray the shadow ray of the vertex that it leads
// to. Rays that leave the scene, and those to infinitely distant lights, are `reach` long.
std::vector<PathLine> LinesOfPath(const session::ExplainedPath& path, const glm::dvec3& origin, double reach);

class ExplainedPixel {
  public:
    // Requests the samples that the view has of a pixel, the first kMaxRequestedSamples at most, and the path
    // of the brightest one. Where the view has none, it is one of kSamples.
    void Ask(viewport::Viewport& view, glm::uvec2 pixel);
    static constexpr uint32_t kSamples = 64;
    // Requests the path of another of these samples. Does nothing unless IsCurrent.
    void AskPath(viewport::Viewport& view, uint32_t sample);
    // Takes what the viewport has answered; called once a frame. `scene` is that of the view.
    void Observe(viewport::Viewport& view, const scene::SceneData& scene);
    void Clear() { *this = {}; }

    bool IsPending() const { return m_samples || m_path; }
    // Returns whether the view is still that in which the pixel was requested.
    bool IsCurrent(const viewport::Viewport& view) const;
    // Returns the samples of the pixel with one path; nothing before there is one.
    const std::optional<session::Explanation>& Shown() const { return m_shown; }
    const session::ExplainedPath& Path() const { return m_shown->paths.front(); }  // Shown() is there

    size_t vertex = 0;  // of the path, the one that is selected

  private:
    // Holds what decides the samples of a view.
    struct View {
        SceneRevisions revisions;
        scene::CameraView camera;
        viewport::PathSettings paths;
        Extent2D size;

        bool operator==(const View&) const = default;
    };
    static View ViewOf(const viewport::Viewport& view);

    std::optional<View> m_view;
    std::optional<session::Explanation> m_values;  // samples of which no path is there yet
    std::optional<session::Explanation> m_shown;
    std::optional<viewport::SamplesRequest> m_samples;
    std::optional<viewport::PathRequest> m_path;
};

}  // namespace raygraph::editor
