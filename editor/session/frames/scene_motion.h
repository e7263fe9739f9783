// SceneMotion shows the animations of a scene on a device at any time. For editor/session/ alone.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/scene/animation/pose_applier.h"

namespace raygraph::session {

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

}  // namespace raygraph::session
