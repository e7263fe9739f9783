// Everything that is open in the editor: the scene, on the host and on the device, its view, and
// the selection.
#pragma once

#include <array>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "editor/app/camera_controller.h"
#include "editor/app/document.h"
#include "editor/app/frame_history.h"
#include "editor/app/gizmo.h"
#include "editor/app/hierarchy.h"
#include "editor/app/log_history.h"
#include "editor/app/saved_render.h"
#include "editor/app/scene_loader.h"
#include "editor/app/settings.h"
#include "editor/app/timeline.h"
#include "editor/session/scene_input.h"
#include "editor/viewport/viewport.h"
#include "renderer/graph/renderer.h"
#include "renderer/image/image.h"

namespace raygraph::editor {

struct Bookmark {
    scene::CameraView view;
    float distance = 1.0f;
};

class Workspace {
  public:
    // `shaders`: the folder of shader sources to reload from, or "". `messages`: what the log panel shows,
    // null: none.
    explicit Workspace(rhi::Device& of, const std::filesystem::path& shaders = {},
                       std::shared_ptr<LogHistory> messages = {}, uint64_t textureBudget = 0)
        : device(of),
          log(messages ? std::move(messages) : std::make_shared<LogHistory>()),
          hasShaderSources(!shaders.empty()),
          renderer(of, {.shaderRoot = shaders}),
          gpu(renderer, {.textureLevels = true, .textureBudget = textureBudget}),
          view(renderer, gpu),
          loader(gpu.TakesTrees(), of.Log()) {
        view.SetBudget({.frameMs = frameMs, .whileMoving = viewport::MotionView::PathTraced});
        viewport::PathSettings paths;
        paths.biases.textureLod = 0.0f;
        view.SetPaths(paths);
        camera.Set(scene::ViewOfBounds({}, 1.0f), 2.0f);
    }

    // This is BudgetSettings::frameMs of the viewport while the user does something.
    double frameMs = 30.0;
    bool hasLongFrames = false;  // frames take longer while the user does nothing, as in a window

    // By the file's extension, .hdr or .exr; any other is a scene.
    static bool IsEnvironment(const std::filesystem::path& file);
    // Starts to load a scene or an environment map (.hdr, .exr) on another thread; the message says if
    // another load of the kind is running.
    // The scene is shown in this variant, by name or index, "": none; through this camera, as of
    // scene::ChooseView.
    void Open(const std::filesystem::path& file, const std::string& variant = {},
              const std::string& choice = {});
    void RemoveEnvironmentMap();
    // What lights the open scene, and scenes that are opened, where there is no map: what each brings along,
    // or the studio as this says.
    void UseLight(DefaultLight light);
    DefaultLight Light() const { return m_defaultLight; }  // as it was last said
    // The file of the environment map; "": there is none.
    const std::filesystem::path& EnvironmentFile() const { return m_environmentFile; }
    // Whether the open scene brings along an environment, which is shown where there is no file.
    bool HasSceneEnvironment() const { return document.Scene().environment.faceSize > 0; }
    // What is shown, as a render names it; without the data, and without the scene's hash, which
    // Document::Content has.
    ShownScene Shown() const;
    bool IsLoading() const { return loader.IsLoading() || m_arriving || m_environment.valid(); }
    std::optional<SceneLoader::Progress> LoadProgress() const;  // of a scene
    // Takes what has been loaded, and reports what could not be. An environment map is shown at once; a scene
    // is returned once frames have copied it to the device.
    std::optional<LoadedScene> FinishLoading();
    // Replaces the open scene, whose unsaved edits are lost. False: the device refuses the new one, and the
    // message says why; then nothing changes.
    bool Show(LoadedScene loaded);
    // The open scene with its edits, .gltf or .glb; that file is open then. The message reports the result;
    // false: it failed.
    bool SaveScene(const std::filesystem::path& file);
    // A variant of the scene's materials, in all views; scene::kNone: none. No edit: it is not saved.
    void ShowVariant(uint32_t variant);
    // A camera of the scene, or one that frames it all. The view follows a camera that animations move until
    // it is moved by other means.
    void UseCamera(std::optional<uint32_t> camera);
    // As of scene::ChooseView; Error{Usage} for a camera that the scene does not have.
    void UseCamera(const std::string& choice);
    // Lets time pass for the timeline, and shows its pose; once a frame. Does nothing if that is shown.
    void Animate(double seconds);
    // With the material that was picked, if one was.
    void Select(std::optional<uint32_t> node, std::optional<uint32_t> material = {});
    // Frames the selection, or the whole scene.
    void FrameSelection();
    // An edit that the scene refuses changes nothing; the message says why, and so does the log.
    void Apply(const Edit& edit);
    void ToggleVisibility();  // of the selection
    void Undo();
    void Redo();
    // Records the times of the last frames; once a frame.
    void Observe();
    // The stored settings, without the window's.
    void Take(const Settings& settings);
    Settings Kept() const;
    void Say(std::string text) { message = std::move(text); }
    // Says it, and warns of it in the log.
    void Refuse(const std::string& why, std::string_view category = log_category::kScene);
    // The same for what may come at every frame: logged when it is not what `last` holds, the text before.
    // Whoever owns `last` clears it when all is well.
    void RefuseAgain(const std::string& why, std::string& last,
                     std::string_view category = log_category::kScene);

    rhi::Device& device;
    std::shared_ptr<LogHistory> log;  // never null
    LogFilter logFilter;
    uint64_t logSeen = 0;  // its revision when it was shown last
    bool hasShaderSources;
    Renderer renderer;
    GpuScene gpu;
    viewport::Viewport view;
    Document document;
    CameraController camera;
    SceneLoader loader;
    Timeline timeline;                                 // of the document's scene
    scene::PointsAndLines pointsAndLines;              // radii of those of scenes that are opened
    std::filesystem::path root;                        // of such scenes: scene::LoadOptions::root
    std::array<std::optional<Bookmark>, 9> bookmarks;  // keys 1 to 9
    Hierarchy hierarchy;
    std::optional<uint32_t> nodeToReveal;  // in it
    std::optional<uint32_t> selectedNode;
    std::optional<uint32_t> selectedMaterial;  // of the pick
    GizmoTool tool = GizmoTool::Move;
    GizmoSpace toolSpace = GizmoSpace::World;
    GizmoPivot pivot = GizmoPivot::Middle;
    FrameHistory history;
    SampleRate sampleRate;
    viewport::ErrorEstimate estimate;
    bool hasDrawn = false;       // a frame, so that there is a plan
    double uiMs = 0.0;           // host time that the panels of the last frame took
    float targetPercent = 1.0f;  // of the error, for the time left
    bool showsCulled = true;     // in the plan
    Panels panels;
    std::vector<std::filesystem::path> recent;  // opened or saved, newest first
    std::string message;                        // the newest one line

  private:
    void NoteOpened(const std::filesystem::path& file);
    float Aspect() const;  // of the picture
    void LookFrom(const scene::CameraView& place);

    void OpenEnvironment(const std::filesystem::path& file);
    void FinishLoadingEnvironment();
    bool TryFor(const Document& of, const std::function<void()>& run);

    std::optional<LoadedScene> m_arriving;  // frames copy it to the device

    struct LoadedEnvironment {
        image::Environment map;
        std::string hash;
    };
    EnvironmentSettings SceneEnvironment() const {
        return {.radiance = glm::vec3(1.0f), .usesScene = true, .defaultLight = m_defaultLight};
    }
    DefaultLight m_defaultLight = DefaultLight::Auto;
    std::filesystem::path m_environmentFile, m_loadingEnvironment;
    std::string m_environmentHash;
    std::future<LoadedEnvironment> m_environment;  // being loaded
    std::optional<viewport::ErrorRequest> m_errorRequest;
    double m_errorAsked = 0.0;  // seconds
    std::string m_refusedEdit;  // why the last edit was; "": it was not
    std::string m_refusedPose;  // likewise
    struct LookedThrough {
        uint32_t camera = 0;
        scene::CameraView view;
    };
    std::optional<LookedThrough> m_lookedThrough;  // what UseCamera was given last, a camera of the scene
    template <typename Change>
    bool Try(Change&& change);  // false: it was refused, and the message says why
};

}  // namespace raygraph::editor
