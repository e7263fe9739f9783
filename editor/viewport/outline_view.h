// OutlineView is the outline of the selection, kept over frames: it is recomputed when it may have moved.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "editor/viewport/view_settings.h"
#include "renderer/scene/model/camera_view.h"

namespace raygraph::viewport {

class OutlineView {
  public:
    explicit OutlineView(std::string name) : m_name(std::move(name)) {}

    void SetInstances(std::vector<uint32_t> instances);
    bool IsEmpty() const { return m_instances.empty(); }

    // Returns a new picture: `picture` with the outline on it. `camera` is that of `settings`; if `isMoving`,
    // the outline may be coarse, and a later frame computes the fine one.
    TextureId Declare(Renderer& renderer, const SceneIds& scene, const SceneRevisions& revisions,
                      const scene::CameraView& camera, passes::TraceSettings settings,
                      const OutlineSettings& look, bool isMoving, TextureId picture);
    // Discards the stored outline, which belongs to another scene.
    void Invalidate() { m_made.reset(); }
    void Release(Renderer& renderer) { renderer.Release(m_name); }

  private:
    // Holds the inputs of the outline.
    struct Key {
        SceneRevisions revisions;
        scene::CameraView camera;
        Extent2D extent;
        float width = 0.0f;
        uint64_t selection = 0;
        bool operator==(const Key&) const = default;
    };
    struct Made {
        Key key;
        bool isCoarse = false;
    };

    std::string m_name;
    std::vector<uint32_t> m_instances;
    uint64_t m_selection = 0;  // number of SetInstances that changed the selection
    std::optional<Made> m_made;
};

}  // namespace raygraph::viewport
