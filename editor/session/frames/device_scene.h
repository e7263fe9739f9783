// DeviceScene is a scene on a device, with the renderer and the settings to trace it; SceneMotion shows its
// animations. For editor/session/ and editor/cli/ alone.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "editor/session/settings/picture_settings.h"
#include "editor/session/settings/scene_input.h"
#include "editor/session/settings/tracing_choice.h"
#include "passes/trace.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/graph/renderer.h"
#include "renderer/scene/animation/pose.h"

namespace raygraph::session {

// SceneMotion shows the animations of a scene on a device at any time.
class SceneMotion {
  public:
    // Prepares `scene` for deformation (scene::DeformInstances). `clips` selects its animations
    // (scene::FindClips).
    SceneMotion(scene::SceneData& scene, std::string_view clips);

    // Poses `gpu`, which has this scene, as if it had been set at this time, whatever was shown before.
    void StartAt(GpuScene& gpu, double seconds);
    // Moves it to another time. Returns whether a camera has changed.
    bool MoveTo(GpuScene& gpu, double seconds);
    // Returns the scene with its cameras as they are now.
    const scene::SceneData& Posed() const { return m_posed; }

  private:
    const scene::PoseChanges& Pose(double seconds);

    std::vector<scene::ClipState> m_clips;
    scene::SceneData m_posed;  // an outline
    scene::PoseEvaluator m_evaluator;
    scene::PoseApplier m_applier;
    std::optional<double> m_seconds;
};

class DeviceScene {
  public:
    // Moves scene and environment out of `input` while it uploads them. `device` outlives the object. Throws
    // SettingError of kind Usage for a camera that is not in the scene, or a group of lights that matches
    // nothing in it; of kind BadInput for a missing clip.
    DeviceScene(rhi::Device& device, SceneInput& input, const PictureSettings& settings,
                const TracingChoice& tracing = {});

    Renderer& GraphRenderer() { return m_renderer; }
    GpuScene& Scene() { return m_scene; }  // already declared by this object
    // Declares the scene in the open frame as the sample with this index sees it: with motion, at its time.
    SceneIds Declare(uint32_t sampleIndex);
    // Declares it at PictureSettings::at, whatever the shutter.
    SceneIds DeclareUnblurred();
    // Declares it at a position in the shutter's time, which must exist: 0 when it opens, 1 when it closes.
    SceneIds DeclareInShutter(double position);
    // Returns the settings of this sample, for which the scene must have been declared.
    passes::TraceSettings SettingsFor(uint32_t sampleIndex) const;
    // Returns whether samples see the scene at different times.
    bool IsBlurred() const { return m_motion && m_settings.shutter; }
    // Requires a scene with a time.
    void SetTime(double at);
    // Sets PictureSettings::camera. Throws as the constructor, and changes nothing then.
    void SetCamera(const std::string& camera);
    void RequireCamera(const std::string& camera) const;
    // From the next frame on, the driver traces even if there are trees for software traversal.
    void TraceByDriver() { m_tracing.traversal = m_traced.traversal = Traversal::Driver; }
    // Returns why there are no trees for software traversal; empty if there are.
    const std::string& NoSoftwareTraversalReason() const { return m_scene.Statistics().noWideBvhReason; }

  private:
    scene::CameraView ViewAtRest(const std::string& camera) const;
    // Poses the scene at its time, with view, focus and origin as if it had always been at that time.
    void StartPicture();
    void PlaceView(const scene::CameraView& view, const scene::Bounds& bounds);
    void MoveTo(double seconds);
    passes::TraceSettings Traced(const scene::CameraView& view) const;

    PictureSettings m_settings;
    TracingChoice m_tracing;
    Renderer m_renderer;
    GpuScene m_scene;
    std::optional<SceneMotion> m_motion;
    scene::SceneData m_atRest;  // cameras and bounds only
    scene::CameraView m_restView;
    float m_focus = 0.0f;  // distance to the plane in focus, for all times of the shutter
    passes::TraceSettings m_traced;
};

}  // namespace raygraph::session
