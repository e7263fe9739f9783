// Scenes on a device, viewports, and the frames that show them in images of the host.
#include <cmath>
#include <utility>
#include <vector>

#include "c/call.h"
#include "c/handles.h"
#include "editor/session/settings/light_settings.h"
#include "editor/viewport/viewport.h"
#include "editor/viewport/vulkan_interop.h"
#include "renderer/gpu_scene/gpu_scene.h"
#include "renderer/graph/renderer.h"
#include "renderer/scene/animation/pose.h"
#include "renderer/scene/model/camera_view.h"
#include "renderer/scene/model/check.h"
#include "rhi/format.h"

using raygraph::ErrorKind;
using raygraph::MakeError;
using raygraph::c::Call;
using raygraph::c::Guarded;
namespace rhi = raygraph::rhi;
namespace scene = raygraph::scene;
namespace session = raygraph::session;
namespace viewport = raygraph::viewport;

namespace raygraph::c {

struct RendererState {
    explicit RendererState(std::shared_ptr<rhi::Device> on) : device(std::move(on)), renderer(*device) {}

    std::shared_ptr<rhi::Device> device;
    std::vector<std::shared_ptr<viewport::HostImage>> shown;  // in the open frame
    Renderer renderer;
};

// A scene on the device, and the outline of what it shows, by which edits are found.
struct GpuSceneState {
    explicit GpuSceneState(std::shared_ptr<RendererState> on)
        : renderer(std::move(on)), scene(renderer->renderer) {}

    void Set(RgScene& from);
    void Update(const Call& call, const RgScene& from);
    void SetSettings(const session::PictureSettings& to);

    std::shared_ptr<RendererState> renderer;
    GpuScene scene;
    scene::SceneData outline;  // without vertices and images
    session::PictureSettings settings;
    bool hasMap = false;
    uint64_t structure = 0;  // RgScene::structure
};

struct ViewportState {
    ViewportState(std::shared_ptr<GpuSceneState> of, const viewport::ViewportDesc& desc)
        : scene(std::move(of)), viewport(scene->renderer->renderer, scene->scene, desc) {}

    std::shared_ptr<GpuSceneState> scene;
    viewport::Viewport viewport;
};

void GpuSceneState::Set(RgScene& from) {
    from.scene.Update();
    session::SceneInput input = from.scene.InputFor(false);
    scene::SceneData posed = scene::PoseOutline(input.data);
    scene.SetScene(std::move(input.data));
    outline = std::move(posed);
    structure = from.structure;
    hasMap = !input.environment.rgba.empty();
    if (hasMap)
        scene.SetEnvironmentMap(input.environment);
    else
        scene.RemoveEnvironmentMap();
    SetSettings(settings);
}

void GpuSceneState::SetSettings(const session::PictureSettings& to) {
    scene.SetEnvironment(session::EnvironmentOf(to, hasMap));
    scene.SetGround(to.hasGround ? outline.bounds : scene::Bounds());
    settings = to;
}

namespace {

bool AreEqual(const scene::Material& a, const scene::Material& b) {
    bool areEqual = true;
    scene::ForEachMaterialField(
        [&](const auto& field) { areEqual = areEqual && a.*field.member == b.*field.member; });
    return areEqual;
}

scene::PlacedTransform PlaceOf(const scene::Instance& instance) {
    return {instance.objectToWorld, instance.translationResidual};
}

}  // namespace

void GpuSceneState::Update(const Call& call, const RgScene& from) {
    if (from.structure != structure)
        call.Refuse(
            "the scene is another one, or has other objects, textures or another environment than the one "
            "that was set: it needs rg_gpu_scene_set");
    const scene::SceneData& edited = from.scene.input.data;
    scene::SceneData posed = outline;
    for (size_t i = 0; i < posed.nodes.size(); ++i) {
        scene::Node& to = posed.nodes[i];
        const scene::Node& node = edited.nodes[i];
        to.translation = node.translation;
        to.translationResidual = node.translationResidual;
        to.rotation = node.rotation;
        to.scale = node.scale;
        to.matrix = node.matrix;
        to.isVisible = node.isVisible;
    }
    posed.materials = edited.materials;
    posed.lights = edited.lights;
    scene::UpdateWorldTransforms(posed);

    const std::vector<bool> shown = scene::VisibleNodes(posed), before = scene::VisibleNodes(outline);
    std::vector<uint32_t> moved, appeared, gone;
    std::vector<scene::PlacedTransform> placed;
    for (uint32_t i = 0; i < posed.instances.size(); ++i) {
        const scene::Instance& instance = posed.instances[i];
        if (PlaceOf(instance) != PlaceOf(outline.instances[i])) {
            moved.push_back(i);
            placed.push_back(PlaceOf(instance));
        }
        const bool isShown = scene::IsVisible(shown, instance);
        if (isShown != scene::IsVisible(before, outline.instances[i]))
            (isShown ? appeared : gone).push_back(i);
    }
    scene.SetTransforms(moved, placed);
    if (!appeared.empty()) scene.SetVisible(appeared, true);
    if (!gone.empty()) scene.SetVisible(gone, false);
    for (uint32_t i = 0; i < posed.materials.size(); ++i)
        if (!AreEqual(posed.materials[i], outline.materials[i])) scene.SetMaterial(i, posed.materials[i]);
    for (uint32_t i = 0; i < posed.lights.size(); ++i) {
        if (posed.lights[i] != outline.lights[i]) scene.SetLight(i, posed.lights[i]);
        const bool isShown = scene::IsVisible(shown, posed.lights[i].node);
        if (isShown != scene::IsVisible(before, outline.lights[i].node)) scene.SetLightVisible(i, isShown);
    }
    outline = std::move(posed);
}

namespace {

scene::CameraView ViewOf(const Call& call, const RgCamera& camera) {
    const auto isFinite = [](const auto& numbers) {
        for (const auto number : numbers)
            if (!std::isfinite(number)) return false;
        return true;
    };
    const float others[] = {camera.y_fov, camera.height, camera.aperture, camera.focus_distance,
                            camera.z_near};
    if (!isFinite(camera.eye) || !isFinite(camera.target) || !isFinite(camera.up) || !isFinite(others))
        call.Refuse("a number of the camera is not finite");
    for (const float number : others)
        if (number < 0.0f) call.Refuse("a number of the camera is negative");
    const glm::vec3 up(camera.up[0], camera.up[1], camera.up[2]);
    scene::CameraView view = scene::CameraView::LookAt(
        {camera.eye[0], camera.eye[1], camera.eye[2]}, {camera.target[0], camera.target[1], camera.target[2]},
        up == glm::vec3(0.0f) ? glm::vec3(0.0f, 1.0f, 0.0f) : up);
    if (camera.is_orthographic != 0) {
        view.projection = scene::Projection::Orthographic;
        if (camera.height == 0.0f) call.Refuse("an orthographic camera needs a height");
        view.height = camera.height;
    } else {
        view.yFov = camera.y_fov != 0.0f ? camera.y_fov : glm::radians(40.0f);
        if (view.yFov >= glm::pi<float>()) call.Refuse("y_fov is not below pi");
    }
    if (camera.z_near != 0.0f) view.zNear = camera.z_near;
    return view;
}

RgToken TokenOf(const rhi::Submission& submission) {
    return {.queue = static_cast<uint32_t>(submission.queue), .reserved = 0, .value = submission.value};
}

std::vector<rhi::SemaphoreUse> SemaphoresOf(const Call& call, const RgSemaphoreUse* uses, uint32_t count) {
    std::vector<rhi::SemaphoreUse> list;
    for (uint32_t i = 0; i < count; ++i) {
        const RgSemaphoreUse& use = (&call.Required(uses, "an array of semaphores"))[i];
        list.push_back({&call.Required(use.semaphore, "a semaphore"), use.value});
    }
    return list;
}

}  // namespace

}  // namespace raygraph::c

struct RgRenderer {
    std::shared_ptr<raygraph::c::RendererState> state;
};
struct RgGpuScene {
    std::shared_ptr<raygraph::c::GpuSceneState> state;
};
struct RgViewport {
    std::shared_ptr<raygraph::c::ViewportState> state;
};
struct RgHostImage {
    std::shared_ptr<rhi::Device> device;
    std::shared_ptr<viewport::HostImage> image;
};
struct RgPick {
    std::shared_ptr<raygraph::c::RendererState> renderer;  // has the answer
    viewport::Pick pick;
};

// --- Scenes on a device ---

RgResult rg_renderer_create(RgDevice* device, RgRenderer** renderer) {
    return Guarded("rg_renderer_create", [&](const Call& call) {
        const RgDevice& on = call.Required(device, "device");
        call.Required(renderer, "renderer") =
            new RgRenderer{std::make_shared<raygraph::c::RendererState>(on.device)};
    });
}

void rg_renderer_destroy(RgRenderer* renderer) {
    delete renderer;
}

RgResult rg_gpu_scene_create(RgRenderer* renderer, RgScene* scene, RgGpuScene** gpu_scene) {
    return Guarded("rg_gpu_scene_create", [&](const Call& call) {
        const RgRenderer& on = call.Required(renderer, "renderer");
        RgScene& from = call.Required(scene, "scene");
        call.Required(gpu_scene, "gpu_scene");
        auto made = std::make_unique<RgGpuScene>(std::make_shared<raygraph::c::GpuSceneState>(on.state));
        made->state->Set(from);
        *gpu_scene = made.release();
    });
}

void rg_gpu_scene_destroy(RgGpuScene* gpu_scene) {
    delete gpu_scene;
}

RgResult rg_gpu_scene_set(RgGpuScene* gpu_scene, RgScene* scene) {
    return Guarded("rg_gpu_scene_set", [&](const Call& call) {
        const RgGpuScene& to = call.Required(gpu_scene, "gpu_scene");
        to.state->Set(call.Required(scene, "scene"));
    });
}

RgResult rg_gpu_scene_update(RgGpuScene* gpu_scene, RgScene* scene) {
    return Guarded("rg_gpu_scene_update", [&](const Call& call) {
        const RgGpuScene& to = call.Required(gpu_scene, "gpu_scene");
        to.state->Update(call, call.Required(scene, "scene"));
    });
}

RgResult rg_gpu_scene_set_transforms(RgGpuScene* gpu_scene, const uint32_t* instances, const double* matrices,
                                     uint32_t count) {
    return Guarded("rg_gpu_scene_set_transforms", [&](const Call& call) {
        const RgGpuScene& to = call.Required(gpu_scene, "gpu_scene");
        if (count == 0) return;
        call.Required(instances, "instances");
        call.Required(matrices, "matrices");
        std::vector<scene::PlacedTransform> placed;
        for (uint32_t i = 0; i < count; ++i)
            placed.push_back(raygraph::c::TransformAt(matrices + size_t{16} * i));
        to.state->scene.SetTransforms({instances, count}, placed);
    });
}

// --- Viewports ---

RgResult rg_viewport_create(RgGpuScene* gpu_scene, const RgViewportDesc* desc, RgViewport** viewport) {
    return Guarded("rg_viewport_create", [&](const Call& call) {
        const RgGpuScene& of = call.Required(gpu_scene, "gpu_scene");
        call.Required(viewport, "viewport");
        const RgViewportDesc given = call.Read(desc, "desc");
        auto made = std::make_unique<RgViewport>(std::make_shared<raygraph::c::ViewportState>(
            of.state, viewport::ViewportDesc{raygraph::c::TextOr(given.name, "viewport"),
                                             {given.width, given.height}}));
        made->state->viewport.SetCamera(scene::ChooseView(of.state->outline, "", 1.0f));
        *viewport = made.release();
    });
}

void rg_viewport_destroy(RgViewport* viewport) {
    delete viewport;
}

RgResult rg_viewport_set_size(RgViewport* viewport, uint32_t width, uint32_t height) {
    return Guarded("rg_viewport_set_size", [&](const Call& call) {
        call.Required(viewport, "viewport").state->viewport.SetSize({width, height});
    });
}

RgResult rg_viewport_set_camera(RgViewport* viewport, const RgCamera* camera) {
    return Guarded("rg_viewport_set_camera", [&](const Call& call) {
        const RgViewport& of = call.Required(viewport, "viewport");
        const RgCamera given = call.Read(camera, "camera");
        const glm::dvec3 way(given.target[0] - given.eye[0], given.target[1] - given.eye[1],
                             given.target[2] - given.eye[2]);
        const auto distance = static_cast<float>(glm::length(way));
        const float focus = given.focus_distance > 0.0f ? given.focus_distance
                            : distance > 0.0f           ? distance
                                                        : 1.0f;
        of.state->viewport.SetCamera(raygraph::c::ViewOf(call, given), {given.aperture, focus});
    });
}

RgResult rg_viewport_set_view(RgViewport* viewport, RgView view) {
    using viewport::View;
    static_assert(RG_VIEW_PATH_TRACED == static_cast<int>(View::PathTraced) &&
                  RG_VIEW_RASTER == static_cast<int>(View::Raster) &&
                  RG_VIEW_WIPE == static_cast<int>(View::Wipe) &&
                  RG_VIEW_SIDE_BY_SIDE == static_cast<int>(View::SideBySide) &&
                  RG_VIEW_DIFFERENCE == static_cast<int>(View::Difference) &&
                  RG_VIEW_RELATIVE_ERROR == static_cast<int>(View::RelativeError) &&
                  RG_VIEW_FLIP == static_cast<int>(View::Flip) &&
                  RG_VIEW_REAL_TIME == static_cast<int>(View::RealTime));
    return Guarded("rg_viewport_set_view", [&](const Call& call) {
        const RgViewport& of = call.Required(viewport, "viewport");
        if (view > RG_VIEW_REAL_TIME || view == static_cast<RgView>(View::Surface))
            call.Refuse(raygraph::Text("{} is no view", view));
        of.state->viewport.SetView(static_cast<View>(view));
    });
}

RgResult rg_viewport_set_settings(RgViewport* viewport, const RgSettings* settings) {
    return Guarded("rg_viewport_set_settings", [&](const Call& call) {
        raygraph::c::ViewportState& to = *call.Required(viewport, "viewport").state;
        raygraph::c::RenderOptions options = raygraph::c::OptionsOf(settings);
        viewport::ShowSettings show = to.viewport.Show();
        show.backdrop.reset();
        if (session::HideBehindGround(options.settings)) show.backdrop.emplace();
        const session::PictureSettings picture = session::SettingsFrom(options.settings);
        show.isDenoised = !options.request.denoiser.empty();
        show.tonemap = session::TonemapOf(options.request, nullptr, picture);
        show.tonemap.isUnassociated = picture.paths.isEnvironmentHidden && !show.backdrop;
        scene::CameraView view = to.viewport.Camera();
        if (!picture.camera.empty()) try {
                view = scene::ChooseView(to.scene->outline, picture.camera, 1.0f);
            } catch (const raygraph::Error& error) {
                throw session::SettingError(error.Kind(), raygraph::Text("camera: {}", error.what()));
            }
        const float focus = picture.focusDistance > 0.0f
                                ? picture.focusDistance
                                : session::DefaultFocus(view, to.scene->outline.bounds);
        to.scene->SetSettings(picture);
        to.viewport.SetCamera(view, {picture.aperture, focus});
        to.viewport.SetPaths(picture.paths);
        to.viewport.SetShow(show);
    });
}

RgResult rg_viewport_set_budget(RgViewport* viewport, const RgBudget* budget) {
    return Guarded("rg_viewport_set_budget", [&](const Call& call) {
        const RgViewport& of = call.Required(viewport, "viewport");
        const RgBudget given = call.Read(budget, "budget");
        if (!(given.frame_ms >= 0.0)) call.Refuse("budget.frame_ms is not 0 or above");
        viewport::BudgetSettings limits = of.state->viewport.Budget();
        limits.frameMs = given.frame_ms;
        limits.samplesPerFrame = given.samples_per_frame;
        limits.maxSamples = given.max_samples;
        limits.whilePreparing =
            given.never_waits != 0 ? viewport::PreparingView::Preview : viewport::PreparingView::PathTraced;
        of.state->viewport.SetBudget(limits);
    });
}

RgResult rg_viewport_get_progress(const RgViewport* viewport, RgViewportProgress* progress) {
    return Guarded("rg_viewport_get_progress", [&](const Call& call) {
        const viewport::Viewport& of = call.Required(viewport, "viewport").state->viewport;
        const viewport::ViewportProgress now = of.Progress();
        RgViewportProgress made{};
        made.samples = now.pathTracedSamples;
        made.denoised_samples = now.denoisedSamples;
        made.is_preview = now.isPreview ? 1 : 0;
        made.frame_ms = of.LastFrameMs();
        call.Write(progress, "progress", made);
    });
}

RgResult rg_viewport_pick(RgViewport* viewport, uint32_t x, uint32_t y, RgPick** pick) {
    return Guarded("rg_viewport_pick", [&](const Call& call) {
        const RgViewport& of = call.Required(viewport, "viewport");
        call.Required(pick, "pick") =
            new RgPick{of.state->scene->renderer, of.state->viewport.RequestPick({x, y})};
    });
}

RgResult rg_pick_poll(RgPick* pick, bool* is_ready, RgPickResult* result) {
    return Guarded("rg_pick_poll", [&](const Call& call) {
        const viewport::Pick& asked = call.Required(pick, "pick").pick;
        call.Required(is_ready, "is_ready");
        if (!asked.IsReady()) {
            *is_ready = false;
            return;
        }
        const viewport::PickResult found = asked.Result();
        RgPickResult made{};
        made.is_hit = found.isHit ? 1 : 0;
        made.instance = found.instance;
        made.material = found.material;
        for (int i = 0; i < 3; ++i) {
            made.position[i] = found.position[i];
            made.normal[i] = found.normal[i];
        }
        made.depth = found.depth;
        made.primitive = found.primitive;
        call.Write(result, "result", made);
        *is_ready = true;
    });
}

void rg_pick_destroy(RgPick* pick) {
    delete pick;
}

// --- Frames ---

RgResult rg_host_image_create(RgDevice* device, const RgHostImageDesc* desc, RgHostImage** image) {
    return Guarded("rg_host_image_create", [&](const Call& call) {
        const RgDevice& on = call.Required(device, "device");
        call.Required(image, "image");
        const RgHostImageDesc given = call.Read(desc, "desc");
        viewport::HostImageDesc wanted;
        wanted.image = &call.Required(given.image, "desc.image");
        wanted.extent = {given.width, given.height};
        wanted.format = rhi::FormatFromVk(static_cast<VkFormat>(given.format));
        if (given.layout_after != 0) wanted.layoutAfter = static_cast<VkImageLayout>(given.layout_after);
        *image = new RgHostImage{on.device, std::make_shared<viewport::HostImage>(*on.device, wanted)};
    });
}

void rg_host_image_destroy(RgHostImage* image) {
    delete image;
}

RgResult rg_host_image_return(RgHostImage* image, int32_t layout) {
    return Guarded("rg_host_image_return", [&](const Call& call) {
        call.Required(image, "image").image->Return(static_cast<VkImageLayout>(layout));
    });
}

RgResult rg_frame_begin(RgRenderer* renderer) {
    return Guarded("rg_frame_begin", [&](const Call& call) {
        raygraph::c::RendererState& on = *call.Required(renderer, "renderer").state;
        on.renderer.BeginFrame();
        on.shown.clear();
    });
}

RgResult rg_frame_would_block(const RgRenderer* renderer, bool* would_block) {
    return Guarded("rg_frame_would_block", [&](const Call& call) {
        const bool would = call.Required(renderer, "renderer").state->renderer.WouldBlock();
        call.Required(would_block, "would_block") = would;
    });
}

RgResult rg_viewport_show(RgViewport* viewport, RgHostImage* image, const RgSemaphores* semaphores) {
    return Guarded("rg_viewport_show", [&](const Call& call) {
        raygraph::c::ViewportState& of = *call.Required(viewport, "viewport").state;
        const RgHostImage& in = call.Required(image, "image");
        const RgSemaphores given = call.ReadOr(semaphores, "semaphores");
        const viewport::HostSemaphores used{
            .wait = raygraph::c::SemaphoresOf(call, given.waits, given.wait_count),
            .signal = raygraph::c::SemaphoresOf(call, given.signals, given.signal_count)};
        raygraph::c::RendererState& on = *of.scene->renderer;
        const raygraph::TextureId picture = of.viewport.Declare();
        if (!picture.IsValid()) return;
        on.shown.push_back(in.image);
        in.image->Show(on.renderer, picture, used);
    });
}

RgResult rg_frame_execute(RgRenderer* renderer, RgToken* token) {
    return Guarded("rg_frame_execute", [&](const Call& call) {
        raygraph::c::RendererState& on = *call.Required(renderer, "renderer").state;
        call.Required(token, "token");
        const rhi::Submission submitted = on.renderer.Execute();
        on.shown.clear();
        *token = raygraph::c::TokenOf(submitted);
    });
}

RgResult rg_frame_record(RgRenderer* renderer, VkCommandBuffer commands, RgToken* token) {
    return Guarded("rg_frame_record", [&](const Call& call) {
        raygraph::c::RendererState& on = *call.Required(renderer, "renderer").state;
        call.Required(commands, "commands");
        call.Required(token, "token");
        const rhi::Submission recorded = on.renderer.Record(commands);
        on.shown.clear();
        *token = raygraph::c::TokenOf(recorded);
    });
}

RgResult rg_frame_drop(RgRenderer* renderer) {
    return Guarded("rg_frame_drop", [&](const Call& call) {
        raygraph::c::RendererState& on = *call.Required(renderer, "renderer").state;
        on.renderer.DropFrame();
        on.shown.clear();
    });
}
