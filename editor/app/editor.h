// The editor: a workspace, panels around a picture of it, keys and mouse. One frame at a time, with any
// source of input and any target.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "editor/app/actions.h"
#include "editor/app/gizmo_view.h"
#include "editor/app/input.h"
#include "editor/app/path_dialog.h"
#include "editor/app/screen.h"
#include "editor/app/ui.h"
#include "editor/app/unsaved_dialog.h"
#include "editor/app/worker.h"
#include "editor/app/workspace.h"

namespace raygraph::editor {

struct EditorOptions {
    std::filesystem::path shaders;         // folder of sources to reload from; "": none
    uint64_t textureBudget = 0;            // as GpuSceneDesc
    std::shared_ptr<LogHistory> log = {};  // what the log panel shows; null: nothing
};

class Editor {
  public:
    explicit Editor(rhi::Device& device, EditorOptions options = {});

    Workspace& Work() { return m_work; }
    // Processes the input, draws the next frame. False: the user quits, has confirmed the loss of unsaved
    // edits, if any, and the pictures to be saved are written. A picture that no frame brings (the window is
    // minimized, or shows none) is given up, and the message says so. Who is quitting has no more input.
    bool Frame(const FrameInput& input, Screen& screen);
    bool IsLeaving() const { return m_isLeaving; }
    // Whether the question about unsaved edits is open (Open, and quitting); until it is answered
    // neither happens.
    bool IsAsking() const { return m_unsaved.IsAsking(); }
    // A scene or an environment map, as Workspace::Open; a scene after the user was asked about
    // unsaved edits.
    void Open(const std::filesystem::path& file);
    // Where the picture's upper left corner is in the window, pixels, as of the last frame.
    glm::ivec2 PictureOrigin() const { return m_viewOrigin; }
    // Whether `wait` of a script must go on waiting: for a scene, a pick or a file.
    bool IsBusy() const;
    // Whether what is to be shown waits for a first scene's file or for pipelines, and nothing else moves.
    bool IsPreparing() const;
    // Why the last frame was not drawn, one line; empty: it was.
    const std::string& FrameError() const { return m_frameError; }
    // How many pictures, of the view or of the window, have been written so far.
    uint64_t SavedCount() const { return m_savedCount; }
    // Saves the shown picture as .png, or its linear data with AOVs as .exr; the message reports the result
    // when it is written. That is done by another thread: frames go on.
    void SavePicture(const std::filesystem::path& file);
    // Reads the settings of a folder, and stores them there from then on (KeepSettings). If they cannot be
    // read, nothing changes except the message. Without this call nothing is stored.
    void UseConfig(const std::filesystem::path& folder);
    // Writes them if they have changed; the message reports a failure.
    void KeepSettings();
    // Saves the open scene with its edits as .gltf or .glb, at once. That file is the open one then.
    bool SaveScene(const std::filesystem::path& file) { return m_work.SaveScene(file); }
    // The whole window as .png.
    void SaveWindow(const std::filesystem::path& file) { m_windowFile = file; }

  private:
    void BuildUi(const FrameInput& input);
    void MenuEntries(Menu menu);
    void MenuBar();
    void AskToOpen();
    void AskToSavePicture();
    void AskToSaveScene();
    float LowerPanels(float left, float right, float bottom);
    float TimelineStrip(float left, float right, float bottom);
    void ViewArea(const FrameInput& input, float left, float top, float width, float height);
    void StatusBar(float top, float width, float height);
    void UseBookmark(size_t slot, bool isKept);
    void Do(Action action);
    void ReloadShaders();
    bool CanDo(Action action) const;
    bool IsOn(Action action) const;
    void Keys(const FrameInput& input);
    void Mouse(const FrameInput& input);
    void Fly(const FrameInput& input);
    void TakePick();
    // False: there is no frame.
    bool Draw(Screen& screen, const FrameInput& input);
    bool DrawFrame(Screen& screen, const FrameInput& input);
    // The panels around what the viewport showed last.
    void DrawKept(Screen& screen, const FrameInput& input);
    void NoteCaptured();
    // No time passes for what is animated: a handle is held, or a picture is to be taken.
    bool IsTimeHeld() const;
    // Hands to the worker what has arrived, and says what it has written.
    void FinishSaving();
    void WriteBeside(Worker::Task write);
    void NoteSaved(std::string text);
    // While quitting, after a frame: whether a picture is still to be written.
    bool IsStillSaving(bool hasDrawn);
    void Leave();
    // Calls `then` when there are no unsaved edits, or once the user has saved or discarded them. `loss` says
    // in the question by what they would be lost: "closing the editor".
    void BeforeLoss(const std::string& loss, std::function<void()> then);
    void FinishLoading();
    // Frames take longer once nobody waits for the next one.
    void ChooseBudget(const FrameInput& input);

    Workspace m_work;
    Ui m_ui;
    bool m_isLeaving = false;
    std::filesystem::path m_config;  // "": nothing is stored
    Settings m_kept;                 // as they are in the file
    Extent2D m_windowSize{};         // points, as of the last frame
    PathDialog m_dialog;
    UnsavedDialog m_unsaved;
    std::optional<LoadedScene> m_loaded;  // until an open question is answered
    uint64_t m_changesToLose = 0;         // those of the scene when opening the one that loads was agreed to
    // The picture's place in the window, pixels, as of the last frame
    glm::ivec2 m_viewOrigin{0};
    GizmoView m_gizmo;
    bool m_isOverView = false;
    bool m_isPreparing = false;  // pipelines of the picture are being created
    bool m_isReloading = false;  // shaders, once no pipeline is being created
    // The first scene is being loaded: the empty one before it is not worth its pipelines
    bool m_isAwaiting = false;
    FrameInput m_lastInput;
    float m_idleSeconds = 0.0f;         // since the user did something
    std::optional<MouseButton> m_drag;  // began over the picture
    glm::vec2 m_lastMouse{0.0f}, m_pressedAt{0.0f};
    bool m_hasMoved = false;
    viewport::Pick m_pick;
    bool m_isPicking = false;
    std::filesystem::path m_pictureFile, m_windowFile;
    struct Saving {
        std::filesystem::path file;
        Readback texels;
        bool isSwapped = false;  // BGRA
    };
    std::vector<Saving> m_saving;
    struct SavingRender {
        std::filesystem::path file;
        viewport::Capture capture;
        ShownScene shown{};     // in the captured frame, without data and hash
        FileContent content{};  // likewise
        bool isTaken = false;
    };
    std::vector<SavingRender> m_savingRenders;
    Worker m_worker;  // writes pictures; after what its tasks refer to
    uint64_t m_savedCount = 0;
    std::string m_frameError;    // of the last frame; "": it was drawn
    std::string m_droppedFrame;  // why the last one with a target was dropped, as logged
};

}  // namespace raygraph::editor
