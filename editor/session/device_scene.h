// A scene on a device, with the renderer and the settings to trace it. For editor/session/ and editor/cli/
// alone.
#pragma once

#include "editor/session/picture_settings.h"
#include "editor/session/scene_input.h"
#include "passes/trace.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/graph/renderer.h"

namespace raygraph::session {

class DeviceScene {
  public:
    // Takes the scene and the environment out of `input` as it uploads them. `device` outlives the object.
    // SettingError of kind Usage for a camera that is not in the scene, or a group of lights that fits
    // nothing in it.
    DeviceScene(rhi::Device& device, SceneInput& input, const PictureSettings& settings);

    Renderer& GraphRenderer() { return m_renderer; }
    GpuScene& Scene() { return m_scene; }
    // Of the sample with this index.
    passes::TraceSettings SettingsFor(uint32_t sampleIndex) const;

  private:
    Renderer m_renderer;
    GpuScene m_scene;
    passes::TraceSettings m_settings;
};

}  // namespace raygraph::session
