#include "editor/session/frames/scene_motion.h"

#include "renderer/scene/animation/deform.h"
#include "renderer/scene/gltf/still_scene.h"

namespace raygraph::session {

namespace {

scene::SceneData OutlineToPose(scene::SceneData& scene) {
    scene::DeformInstances(scene);
    return scene::PoseOutline(scene);
}

}  // namespace

SceneMotion::SceneMotion(scene::SceneData& scene, std::string_view clips)
    : m_clips(scene::FindClips(scene, clips, 0.0)),
      m_posed(OutlineToPose(scene)),
      m_evaluator(m_posed),
      m_applier(m_posed) {}

const scene::PoseChanges& SceneMotion::Pose(double seconds) {
    for (scene::ClipState& clip : m_clips) clip.seconds = seconds;
    return m_applier.Apply(m_posed, m_evaluator.Evaluate(m_posed, m_clips));
}

void SceneMotion::StartAt(GpuScene& gpu, double seconds) {
    Pose(seconds);
    gpu.SetPose(m_posed, m_applier);
    m_seconds = seconds;
}

bool SceneMotion::MoveTo(GpuScene& gpu, double seconds) {
    if (m_seconds == seconds) return false;
    const scene::PoseChanges& changes = Pose(seconds);
    gpu.SetPose(m_posed, m_applier, changes);
    m_seconds = seconds;
    return !changes.cameras.empty();
}

}  // namespace raygraph::session
