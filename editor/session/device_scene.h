// A scene on a device, with the renderer and the settings to trace it. For editor/session/ and editor/cli/
// alone.
#pragma once

#include <optional>

#include "editor/session/picture_settings.h"
#include "editor/session/scene_input.h"
#include "editor/session/scene_motion.h"
#include "editor/session/tracing_choice.h"
#include "passes/trace.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/graph/renderer.h"

namespace raygraph::session {

class DeviceScene {
  public:
    // Takes the scene and the environment out of `input` as it uploads them. `device` outlives the object.
    // SettingError of kind Usage for a camera that is not in the scene, or a group of lights that fits
    // nothing in it; of kind BadInput for a clip that it does not have.
    DeviceScene(rhi::Device& device, SceneInput& input, const PictureSettings& settings,
                const TracingChoice& tracing = {});

    Renderer& GraphRenderer() { return m_renderer; }
    GpuScene& Scene() { return m_scene; }  // declared by this object
    // Declares the scene in the frame that has begun, as the sample with this index sees it: at its time,
    // where there is motion.
    SceneIds Declare(uint32_t sampleIndex);
    // The same at PictureSettings::at, whatever the shutter.
    SceneIds DeclareSharp();
    // At a place of the shutter's time, which there is: 0, when it opens, to 1, when it closes.
    SceneIds DeclareInShutter(double position);
    // Of the sample with this index, once the scene was declared for it.
    passes::TraceSettings SettingsFor(uint32_t sampleIndex) const;
    // Whether samples see the scene at different times.
    bool IsBlurred() const { return m_motion && m_settings.shutter; }
    // Only of a scene with a time.
    void SetTime(double at);
    // As PictureSettings::camera. Throws as the constructor, and changes nothing.
    void SetCamera(const std::string& camera);
    void RequireCamera(const std::string& camera) const;
    // From the next frame on, the driver traces where there are trees for own traversal, too.
    void TraceByDriver() { m_tracing.traversal = m_traced.traversal = Traversal::Driver; }
    // Why there are no trees for own traversal; empty: there are.
    const std::string& WhyNoOwnTraversal() const { return m_scene.Statistics().whyNoWideTrees; }

  private:
    scene::CameraView ViewAtRest(const std::string& camera) const;
    // Poses the scene at its time, with its view, focus and origin: as nothing but that time has it.
    void StartPicture();
    void PlaceView(const scene::CameraView& view, const scene::Bounds& bounds);
    void MoveTo(double seconds);
    passes::TraceSettings Traced(const scene::CameraView& view) const;

    PictureSettings m_settings;
    TracingChoice m_tracing;
    Renderer m_renderer;
    GpuScene m_scene;
    std::optional<SceneMotion> m_motion;
    scene::SceneData m_atRest;  // its cameras and bounds alone
    scene::CameraView m_restView;
    float m_focus = 0.0f;  // of the picture, at all times of its shutter
    passes::TraceSettings m_traced;
};

}  // namespace raygraph::session
