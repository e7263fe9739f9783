// Workspace holds everything that is open in the editor: the scene, on the host and on the device, its view,
// and the selection.
#pragma once

#include <array>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "editor/app/camera_controller.h"
#include "editor/app/document.h"
#include "editor/app/explained_pixel.h"
#include "editor/app/file_content.h"
#include "editor/app/frame_statistics.h"
#include "editor/app/gizmo.h"
#include "editor/app/hierarchy.h"
#include "editor/app/log_history.h"
#include "editor/app/scene_loader.h"
#include "editor/app/scene_view.h"
#include "editor/app/settings.h"
#include "editor/app/thumbnails.h"
#include "editor/app/timeline.h"
#include "editor/session/settings/scene_input.h"
#include "editor/viewport/viewport.h"
#include "renderer/graph/renderer.h"
#include "renderer/image/image.h"

namespace raygraph::editor {

struct Bookmark {
    scene::CameraView view;
    float distance = 1.0f;
};

// Holds the name of a node while it is typed in the hierarchy.
struct NameDraft {
    uint32_t node = 0;
    std::array<char, 256> text{}, initial{};
    bool isNew = true;  // no frame has shown it
};

class Workspace {
  public:
    // `shaders` is the folder of shader sources for hot reload, or "". `messages` is the log that the panel
    // shows; null: a new one.
    explicit Workspace(rhi::Device& of, const std::filesystem::path& shaders = {},
                       std::shared_ptr<LogHistory> messages = {}, uint64_t textureBudget = 0)
        : device(of),
          log(messages ? std::move(messages) : std::make_shared<LogHistory>()),
          hasShaderSources(!shaders.empty()),
          renderer(of, {.shaderRoot = shaders}),
          gpu(renderer, {.textureLevels = true, .textureBudget = textureBudget}),
          view(renderer, gpu),
          loader(gpu.UsesWideBvhs(), of.Log()) {
        view.SetBudget({.frameMs = frameMs});
        viewport::PathSettings paths;
        paths.biases.textureLod = 0.0f;
        view.SetPaths(paths);
        camera.Set(scene::ViewOfBounds({}, 1.0f), 2.0f);
    }

    // This is BudgetSettings::frameMs of the viewport while the user does something.
    double frameMs = 30.0;
    bool allowsLongFrames = false;  // longer frames while the user is idle, as in a window

    // Returns whether the extension is .hdr or .exr; any other file is a scene.
    static bool IsEnvironment(const std::filesystem::path& file);
    // Starts to load a scene or an environment map (.hdr, .exr) on another thread; the message says if
    // another load of the kind is running. A scene is shown in this variant (name or index, "": none), and in
    // the view that is stored beside it, if there is one, changed so (null: not).
    void Open(const std::filesystem::path& file, const std::string& variant = {},
              const ChangeView& changeView = {});
    // Returns how the open scene is seen. Use shows it so; a camera that the scene lacks is reported.
    SceneView ShownView() const;
    void Use(const SceneView& seen);
    void RemoveEnvironmentMap();
    // Chooses the light of the open scene and of those opened later, where there is no environment map: their
    // own light, or the studio.
    void UseLight(DefaultLight light);
    DefaultLight Light() const { return m_defaultLight; }  // the last UseLight
    // Returns the file of the environment map; "" if there is none.
    const std::filesystem::path& EnvironmentFile() const { return m_environmentFile; }
    // Returns whether the open scene has an environment of its own, which is shown where there is no file.
    bool HasSceneEnvironment() const { return document.Scene().environment.faceSize > 0; }
    // Names what is shown in the terms of a render, without the data and without the scene's hash, which
    // Document::Content has.
    ShownScene Shown() const;
    bool IsLoading() const { return loader.IsLoading() || m_arriving || m_environment.valid(); }
    std::optional<SceneLoader::Progress> LoadProgress() const;  // while a scene is loaded
    // Takes finished loads, and reports failures. An environment map is shown at once; a scene is returned
    // once frames have copied it to the device.
    std::optional<LoadedScene> FinishLoading();
    // Replaces the open scene, whose unsaved edits are lost. Returns false if the device refuses the new one;
    // then nothing changes, and the message says why.
    bool Show(LoadedScene loaded);
    // Saves the open scene with its edits as .gltf or .glb, and the view beside it; the new file is the open
    // one then. Returns false on a failure; the message reports the result.
    bool SaveScene(const std::filesystem::path& file);
    void SaveView();  // beside the open scene's file; the message reports the result
    // Shows a variant of the scene's materials in all views; scene::kNone: no variant. This is no edit, and
    // is not saved.
    void ShowVariant(uint32_t variant);
    // Looks through a camera of the scene, or through one that frames all of it. The view follows an animated
    // camera until it is moved by other means.
    void UseCamera(std::optional<uint32_t> camera);
    // Looks through a camera as in scene::ChooseView. Throws Error{Usage} if the scene does not have it.
    void UseCamera(const std::string& choice);
    // Returns the scene's camera through which the view looks, until it is moved.
    std::optional<uint32_t> FollowedCamera() const;
    // Returns the first camera that has not been deleted.
    std::optional<uint32_t> FirstCamera() const;
    // Advances the timeline, and shows its pose; called once a frame. Does nothing if that pose is shown.
    void Animate(double seconds);
    // Selects a node, with the material that was picked, if one was.
    void Select(std::optional<uint32_t> node, std::optional<uint32_t> material = {});
    void SelectAll(std::vector<uint32_t> nodes);  // the last one is the active one
    // Adds a node to the selection as the active one, or takes it out.
    void ToggleSelected(uint32_t node);
    // Selects the rows of the hierarchy from the last node that was selected otherwise to this one, which
    // becomes the active one; `isAdded`: and keeps what was selected.
    void SelectRange(uint32_t node, bool isAdded);
    bool IsSelected(uint32_t node) const;
    // Lists only the nodes whose names have this part, with their ancestors; "": all.
    void FilterHierarchy(std::string part);
    const std::string& HierarchyFilter() const { return m_hierarchyFilter; }
    // Returns the world-space bounds of the selection: its instances, and the places of nodes without any.
    scene::Bounds SelectionBounds() const;
    // Frames the selection, or the whole scene.
    void FrameSelection();
    // Applies an edit. If the scene refuses it, nothing changes, and message and log say why.
    void Apply(const Edit& edit) { Apply({&edit, 1}); }
    void Apply(std::span<const Edit> edits);  // as one step of the history
    // Says whether the next click in the picture chooses the distance in focus, instead of selecting.
    void PickFocus(bool isOn);
    bool IsPickingFocus() const { return m_isPickingFocus; }
    // Puts in focus what is seen in this pixel; a later frame answers, and the message reports it.
    void FocusOn(glm::uvec2 pixel);
    bool IsFocusPending() const { return m_focusRequest.has_value(); }
    // Returns the distance in focus, in meters along the view.
    float FocusDistance() const;
    // Returns the lens of the shown camera; an orthographic one has a pinhole.
    viewport::LensSettings Lens() const;
    // Returns `backdrop` as it can be shown: an environment without a map is not blurred.
    std::optional<passes::BackdropSettings> ShownBackdrop() const;
    // Lets the viewport show backdrop and ground; called before each frame.
    void ShowBackdrop();
    // Shows a light of this temperature, in kelvin within kWhitePointRange, as white.
    void SetWhitePoint(int kelvin);
    int WhitePoint() const { return m_whitePoint; }
    // Hides the selection, or shows it if the active node is hidden.
    void ToggleVisibility();
    // Edits of the hierarchy, with their messages; the selection follows. Copies are selected, and of what
    // was deleted the parent.
    void DuplicateSelection();
    // Adds and selects a light halfway to the point about which the camera orbits, shining along the view; it
    // lights a white surface there as radiance 1 does. Or an empty node at that point, or the present view as
    // a camera.
    void AddLight(scene::LightType type);
    void AddEmpty();
    void AddCamera();
    void DeleteSelection();
    // Puts the selection (if `node` is part of it, else the node alone) below `parent`, else makes it roots.
    void Reparent(uint32_t node, std::optional<uint32_t> parent);
    void Rename(uint32_t node, const std::string& name);
    // Lets the textures that share the image of this one show a file's picture. Returns why it cannot be, in
    // one line; "": it is done.
    std::string ReplaceImage(uint32_t texture, const std::filesystem::path& file);
    void StartRename();  // lets the name of the selection be typed in the hierarchy
    void Undo();
    void Redo();
    // Records the times of the last frames; called once a frame.
    void Observe();
    // Chooses the view by itself, once a scene is shown: the real-time one, where a frame of it takes at most
    // kMostRealTimeMs, else the path-traced one, denoised. The log says why. A view that the user chooses
    // meanwhile stays. Settings to be saved have no view that was chosen so.
    void ChooseViewByTime();
    static constexpr double kMostRealTimeMs = 100.0;
    // Goes on with that; called after each drawn frame.
    void ContinueChoosingView();
    bool IsChoosingView() const { return m_isChoosingView; }
    // Applies the stored settings, except the window's.
    void Take(const Settings& settings);
    Settings SettingsToSave() const;
    void ShowMessage(std::string text, bool isError = false);
    // Shows the reason in the message, in red, and logs it as a warning.
    void ReportError(const std::string& why, std::string_view category = log_category::kScene);
    // Reports what may recur in every frame: it is logged only if it differs from `last`, the previous
    // reason. The owner of `last` clears it once there is no failure.
    void ReportErrorOnce(const std::string& why, std::string& last,
                         std::string_view category = log_category::kScene);

    rhi::Device& device;
    std::shared_ptr<LogHistory> log;  // never null
    LogFilter logFilter;
    uint64_t shownLogRevision = 0;  // LogHistory::Revision when it was shown last
    bool hasShaderSources;
    Renderer renderer;
    GpuScene gpu;
    viewport::Viewport view;
    Document document;
    CameraController camera;
    float aperture = 0.0f;  // radius of the camera's lens in meters; 0: a pinhole
    float focus = 0.0f;     // its distance in focus, in meters; 0: session::DefaultFocus
    // It is seen behind the scene in path-traced and raster pictures; none: they are transparent. With a
    // ground, path-traced ones show the shadow on it.
    std::optional<passes::BackdropSettings> backdrop = passes::BackdropSettings{};
    bool hasGround = false;
    SceneLoader loader;
    Timeline timeline;                                 // animations of the document's scene
    scene::PointsAndLines pointsAndLines;              // radii of points and lines in scenes that are opened
    std::filesystem::path root;                        // scene::LoadOptions::root for scenes that are opened
    std::array<std::optional<Bookmark>, 9> bookmarks;  // keys 1 to 9, with Shift
    KeyBindings keys;
    std::optional<Action> actionToBind;  // the next key is given to it
    Hierarchy hierarchy;
    std::optional<uint32_t> nodeToReveal;  // to be scrolled to in the hierarchy
    bool isHierarchyFocused = false;       // the last click was in its panel, which takes its keys
    std::optional<uint32_t> pressedRow;    // one of several selected nodes; selected alone on release
    std::optional<NameDraft> nameDraft;
    Thumbnails thumbnails;
    std::optional<uint32_t> imageToReplace;    // a texture; its image is to be asked for
    std::optional<uint32_t> selectedNode;      // the active one of the selected nodes
    std::vector<uint32_t> selectedNodes;       // all of them
    std::optional<uint32_t> selectedMaterial;  // material of the pick
    GizmoTool tool = GizmoTool::Move;
    GizmoSpace toolSpace = GizmoSpace::World;
    GizmoPivot pivot = GizmoPivot::Middle;
    ExplainedPixel explained;
    FrameHistory history;
    SampleRate sampleRate;
    viewport::NoiseEstimate estimate;
    RealTimeErrorHistory realTimeErrors;  // measured while the statistics are shown beside a comparison
    bool hasDrawn = false;                // a frame was drawn, so that there is a plan
    double uiMs = 0.0;                    // host time of the last frame's panels
    float targetPercent = 1.0f;           // target error of the picture, in percent
    bool showsCulled = true;              // culled passes are shown in the plan
    Panels panels;
    PanelSizes panelSizes;
    std::vector<std::filesystem::path> recent;  // opened or saved, newest first
    std::string message;                        // newest message, one line
    bool isMessageError = false;
    float messageAge = 0.0f;  // seconds

  private:
    void AddRecentFile(const std::filesystem::path& file);
    void ObserveRealTime(double now);
    float Aspect() const;  // returns the aspect ratio of the picture
    void SetCameraView(const scene::CameraView& place);
    // Adds a node of this name at a place, turned as the view is if `isTurned`.
    void AddNode(const char* name, const glm::dvec3& place, bool isTurned, std::optional<scene::Light> light,
                 std::optional<scene::Camera> seen);
    void FollowHierarchy();  // after it has changed
    void FollowHistory();    // after undo and redo

    void FinishFocus();

    bool m_isPickingFocus = false;
    std::optional<viewport::Pick> m_focusRequest;
    int m_whitePoint = Settings().whitePoint;  // of the view's TonemapSettings::whiteBalance

    // Shows the map with these settings, else with a radiance factor of 1 and the present rotation. A map
    // that is being loaded is not shown then.
    void OpenEnvironment(const std::filesystem::path& file,
                         const std::optional<EnvironmentSettings>& settings = {});
    void UseEnvironment(const std::filesystem::path& file, const EnvironmentSettings& settings);
    void FinishLoadingEnvironment();
    bool TryWithDocument(const Document& of, const std::function<void()>& run);

    std::optional<LoadedScene> m_arriving;  // frames are copying it to the device

    struct LoadedEnvironment {
        image::Environment map;
        std::string hash;
    };
    EnvironmentSettings SceneEnvironment() const {
        return {.radiance = glm::vec3(1.0f), .usesScene = true, .defaultLight = m_defaultLight};
    }
    DefaultLight m_defaultLight = DefaultLight::Auto;
    struct WantedMap {
        std::filesystem::path file;
        std::optional<EnvironmentSettings> settings;
    };
    std::filesystem::path m_environmentFile;
    WantedMap m_loadingMap;                 // of m_environment
    bool m_isLoadStale = false;             // what is being loaded is not wanted any more
    std::optional<WantedMap> m_nextMap;     // to be loaded after that
    std::optional<WantedMap> m_missingMap;  // could not be loaded; saved views keep it
    void GiveUpMaps();                      // none of these three is wanted any more
    EnvironmentSettings SettingsFor(const WantedMap& map) const;  // with which it is, or would be, shown
    struct Look {
        float exposureEv = 0.0f;
        TonemapOperator tonemap{};
        int whitePoint = 0;
        bool operator==(const Look&) const = default;
    };
    void StoreView(const std::filesystem::path& file);  // from then on, the look is the scene's
    Look ShownLook() const;
    Look OwnLook() const;                             // the user's, where the shown one is the scene's
    std::optional<Look> m_lookOfScene, m_lookBefore;  // set by Use
    std::string m_environmentHash;
    scene::Bounds m_restBounds;  // of the scene, when its rest pose was shown last; the ground is under these
    std::future<LoadedEnvironment> m_environment;  // being loaded
    std::optional<viewport::NoiseRequest> m_errorRequest;
    double m_errorRequestTime = 0.0;  // time of the last request, in seconds
    bool m_isChoosingView = false;
    std::optional<viewport::ShowSettings> m_ownView;  // set by ChooseViewByTime; none: it was not called
    uint32_t m_realTimeFramesBefore = 0;              // before it began to measure
    std::optional<viewport::RealTimeErrorsRequest> m_realTimeRequest;
    double m_realTimeRequestTime = 0.0;
    std::optional<uint32_t> m_rangeStart;  // where SelectRange begins
    std::string m_hierarchyFilter;
    std::string m_refusedEdit;  // why the last edit was refused; "": it was not
    std::string m_refusedPose;  // why the last pose was refused; "": it was not
    struct ChosenCamera {
        uint32_t camera = 0;
        scene::CameraView view;
    };
    std::optional<ChosenCamera> m_chosenCamera;  // camera that UseCamera was given last
    template <typename Change>
    bool Try(Change&& change);  // returns false if the change was refused; the message says why
};

}  // namespace raygraph::editor
