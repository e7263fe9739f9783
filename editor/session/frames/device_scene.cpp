#include "editor/session/frames/device_scene.h"

#include <tuple>

#include "base/check.h"
#include "base/text.h"
#include "editor/session/frames/sample_frames.h"
#include "editor/session/settings/bias.h"
#include "editor/session/settings/light_settings.h"
#include "passes/trace.h"
#include "renderer/gpu_scene/camera_record.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/gltf/still_scene.h"
#include "renderer/scene/model/camera_view.h"

namespace raygraph::session {

namespace {

scene::CameraView ViewFrom(const PictureSettings& settings, const std::string& camera,
                           const scene::SceneData& data) {
    const float aspect = static_cast<float>(settings.size.width) / static_cast<float>(settings.size.height);
    try {
        return scene::ChooseView(data, camera, aspect);
    } catch (const Error& error) {
        throw SettingError(error.Kind(), Text("camera: {}", error.what()));
    }
}

// Only views that read texture levels need these levels on the device.
GpuSceneDesc SceneDescFor(const PictureSettings& settings, Traversal traversal) {
    const bool isDrawn = settings.view == View::Raster;
    return {.textureLevels = isDrawn || IsOn(settings.paths.biases, Bias::TextureLod),
            .textureBudget = settings.textureBudget,
            .traversal = settings.view == View::PathTraced ? traversal : Traversal::Driver,
            .measuresLight = settings.light == DefaultLight::Auto,  // the session has decided already
            .lightRule = LightRule::Always};
}

}  // namespace

DeviceScene::DeviceScene(rhi::Device& device, SceneInput& input, const PictureSettings& settings,
                         const TracingChoice& tracing)
    : m_settings(settings),
      m_tracing(tracing),
      m_renderer(device),
      m_scene(m_renderer, SceneDescFor(settings, tracing.traversal)) {
    if (settings.at) m_motion.emplace(input.data, settings.clips);
    m_atRest.cameras = input.data.cameras;
    m_atRest.bounds = input.data.bounds;
    m_restView = ViewAtRest(settings.camera);
    PlaceView(m_restView, m_atRest.bounds);
    LightGroups groups = MatchLightGroups(settings.lightGroups, input.data);
    const bool hasMap = !input.environment.rgba.empty();
    m_scene.SetEnvironment(EnvironmentOf(settings, hasMap));
    m_scene.SetScene(std::move(input.data));
    if (settings.hasGround && !m_atRest.bounds.IsEmpty()) {
        m_scene.SetGround(m_atRest.bounds);
        if (groups.namedCount > 0) {  // it emits nothing
            groups.instances.push_back(gpu::kLightGroupRest);
            groups.materials.push_back(gpu::kLightGroupRest);
        }
    }
    if (m_motion)
        StartPicture();
    else
        m_scene.SetViewpoint(EyeOf(m_traced.camera));
    m_scene.SetLightGroups(std::move(groups));
    if (!hasMap) return;
    m_scene.SetEnvironmentMap(input.environment);
    input.environment = {};
}

passes::TraceSettings DeviceScene::Traced(const scene::CameraView& view) const {
    passes::TraceSettings traced =
        passes::FrameSettings({m_settings.size.width, m_settings.size.height}, view,
                              {m_settings.aperture, m_focus}, m_settings.paths);
    traced.region = m_settings.crop.value_or(passes::Region{});
    traced.traversal = m_tracing.traversal;
    traced.form = m_tracing.form;
    return traced;
}

void DeviceScene::PlaceView(const scene::CameraView& view, const scene::Bounds& bounds) {
    m_focus = m_settings.focusDistance > 0.0f ? m_settings.focusDistance : DefaultFocus(view, bounds);
    m_traced = Traced(view);
}

void DeviceScene::StartPicture() {
    m_motion->StartAt(m_scene, *m_settings.at);
    const scene::SceneData& posed = m_motion->Posed();
    // A scene without cameras is framed as it is at rest, so that a moving one does not carry the view along
    PlaceView(posed.cameras.empty() ? m_restView : ViewFrom(m_settings, m_settings.camera, posed),
              posed.bounds);
    m_scene.SetViewpoint(EyeOf(m_traced.camera));
}

void DeviceScene::MoveTo(double seconds) {
    const bool isCameraMoved = m_motion->MoveTo(m_scene, seconds);
    if (isCameraMoved) m_traced = Traced(ViewFrom(m_settings, m_settings.camera, m_motion->Posed()));
}

SceneIds DeviceScene::Declare(uint32_t sampleIndex) {
    if (!IsBlurred()) return DeclareUnblurred();
    return DeclareInShutter(ShutterPosition(sampleIndex, m_settings.paths.seed));
}

SceneIds DeviceScene::DeclareInShutter(double position) {
    const Shutter& shutter = *m_settings.shutter;
    MoveTo(*m_settings.at + shutter.open + (shutter.close - shutter.open) * position);
    return m_scene.Declare(m_renderer);
}

SceneIds DeviceScene::DeclareUnblurred() {
    if (m_motion) MoveTo(*m_settings.at);
    return m_scene.Declare(m_renderer);
}

void DeviceScene::SetTime(double at) {
    RG_CHECK(m_motion.has_value());
    m_settings.at = at;
    StartPicture();
}

scene::CameraView DeviceScene::ViewAtRest(const std::string& camera) const {
    return ViewFrom(m_settings, camera, m_atRest);
}

void DeviceScene::RequireCamera(const std::string& camera) const {
    std::ignore = ViewAtRest(camera);
}

void DeviceScene::SetCamera(const std::string& camera) {
    m_restView = ViewAtRest(camera);
    m_settings.camera = camera;
    if (m_motion) {
        StartPicture();
        return;
    }
    PlaceView(m_restView, m_atRest.bounds);
    m_scene.SetViewpoint(EyeOf(m_traced.camera));
}

passes::TraceSettings DeviceScene::SettingsFor(uint32_t sampleIndex) const {
    passes::TraceSettings settings = m_traced;
    settings.sampleIndex = sampleIndex;
    return settings;
}

// --- SceneMotion ---

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
