// Editor holds a workspace, and draws panels around its picture. It takes keys and mouse from any source of
// input, and draws one frame at a time to any target.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "editor/app/actions.h"
#include "editor/app/file_dialog.h"
#include "editor/app/gizmo_view.h"
#include "editor/app/input.h"
#include "editor/app/render_dialog.h"
#include "editor/app/scene_loader.h"
#include "editor/app/ui.h"
#include "editor/app/unsaved_dialog.h"
#include "editor/app/window.h"
#include "editor/app/worker.h"
#include "editor/app/workspace.h"

namespace raygraph::editor {

struct EditorOptions {
    std::filesystem::path shaders;         // folder of shader sources for hot reload; "": none
    uint64_t textureBudget = 0;            // in bytes, see GpuSceneDesc
    std::shared_ptr<LogHistory> log = {};  // shown by the log panel; null: it is empty
    // The program that renders pictures, with its first arguments: "raygraph render"; empty: there is none.
    std::vector<std::string> render = {};
};

class Editor {
  public:
    explicit Editor(rhi::Device& device, EditorOptions options = {});

    Workspace& Work() { return m_work; }
    // Processes the input and draws the next frame. Returns false once the user quits, has confirmed the loss
    // of unsaved edits, and all pending pictures are written. Those that no frame provides (the window is
    // minimized, or shows no picture) are given up, which the message reports. After the user has quit, input
    // is ignored.
    bool Frame(const FrameInput& input, Screen& screen);
    bool IsQuitting() const { return m_isQuitting; }
    // Returns whether the question about unsaved edits is open. Opening and quitting wait for the answer.
    bool IsPrompting() const { return m_unsaved.IsPrompting(); }
    // Opens a scene or an environment map (Workspace::Open); for a scene it first asks about unsaved edits.
    void Open(const std::filesystem::path& file);
    // Returns the position of the picture's upper left corner in the window, in pixels, in the last frame.
    glm::ivec2 PictureOrigin() const { return m_viewOrigin; }
    // Returns whether a load, a pick or the writing of a file is pending; a script's `wait` waits for these.
    bool IsBusy() const;
    // Returns whether the first scene's file or pipelines are pending, and nothing else moves in the window.
    bool IsPreparing() const;
    // Returns why the last frame was not drawn, in one line; "": it was drawn.
    const std::string& FrameError() const { return m_frameError; }
    // Returns how many pictures, of the view or of the window, have been written so far.
    uint64_t SavedCount() const { return m_savedCount; }
    // Lets files be chosen in the desktop's own dialog, where it has one.
    void AllowDesktopDialogs() { m_dialog.AllowDesktop(true); }
    // Saves the shown picture as .png, or its linear data with AOVs as .exr. Another thread writes it while
    // frames go on; the message reports the result.
    void SavePicture(const std::filesystem::path& file);
    // Returns why that cannot be done now, in a line; "": it can.
    std::string WhyNotSaved(const std::filesystem::path& picture) const;
    // Reads the settings from a folder, and stores them there from then on (StoreSettings). If they cannot be
    // read, only the message changes. Without this call nothing is stored.
    void SetConfigFolder(const std::filesystem::path& folder);
    // Returns the settings that were read there.
    const Settings& StoredSettings() const { return m_kept; }
    // Writes the settings if they have changed; the message reports a failure.
    void StoreSettings();
    // Saves the open scene with its edits as .gltf or .glb before it returns. The new file is the open one
    // then.
    bool SaveScene(const std::filesystem::path& file) { return m_work.SaveScene(file); }
    // Opens the dialog for renders, in which a script fills in the fields.
    RenderDialog& OpenRenderDialog();
    // Saves the whole window as .png.
    void SaveWindow(const std::filesystem::path& file) { m_windowFile = file; }

  private:
    void BuildUi(const FrameInput& input);
    void MenuEntries(Menu menu);
    void MenuBar();
    void AddMenu();
    void ShowOpenDialog();
    void ShowSavePictureDialog();
    void ShowReplaceImageDialog(uint32_t texture);
    // Returns `stem` as the suggested name of a .png, which says if the picture is denoised.
    std::string PictureName(const std::string& stem) const;
    void ShowSaveSceneDialog();
    // Saves over the open file, if there are edits.
    void SaveEdits();
    // Returns the name of a file in the current folder that is not there yet: "fox-0001.png".
    std::filesystem::path ScreenshotName() const;
    // Gives the key to Workspace::actionToBind.
    void BindKey(const KeyPress& press);
    float LowerPanels(float left, float right, float bottom);
    float TimelineStrip(float left, float right, float bottom);
    void ViewArea(const FrameInput& input, float left, float top, float width, float height);
    void StatusBar(float top, float width, float height);
    void UseBookmark(size_t slot, bool isKept);
    // Copies a text to the clipboard, and shows it in the message.
    void Copy(const std::string& text);
    void Perform(Action action);
    void ReloadShaders();
    // Returns why the action does nothing now, as "there is nothing to undo"; "": it does something.
    std::string WhyNot(Action action) const;
    bool IsOn(Action action) const;
    void Keys(const FrameInput& input);
    void Mouse(const FrameInput& input);
    void Fly(const FrameInput& input);
    void ApplyPick();
    // Returns false if there is no frame.
    bool Draw(Screen& screen, const FrameInput& input);
    bool DrawFrame(Screen& screen, const FrameInput& input);
    // Draws the panels around the picture that the viewport drew last.
    void DrawLastPicture(Screen& screen, const FrameInput& input);
    void HandleCaptures();
    // Returns whether the picture has a whole sample, so that it is worth saving.
    bool HasSample() const;
    // Returns whether animations are paused because a handle is held or a picture is about to be taken.
    bool IsPlaybackPaused() const;
    // Hands readbacks that have arrived to the worker, and reports those that it has written.
    void FinishSaving();
    void WriteBeside(Worker::Task write);
    void ReportSaved(std::string text);
    // Must be called after the frame of a user who is quitting: returns whether a picture is still to be
    // written.
    bool IsSaving(bool hasDrawn);
    void Leave();
    // Calls `then` if there are no unsaved edits, else once the user has saved or discarded them. The
    // question names `loss` as the reason for which they would be lost: "closing the editor".
    void ConfirmDiscard(const std::string& loss, std::function<void()> then);
    void FinishLoading();
    // Gives frames more time once nobody waits for the next one.
    void ChooseBudget(const FrameInput& input);

    Workspace m_work;
    Ui m_ui;
    bool m_isQuitting = false;
    std::filesystem::path m_config;  // "": nothing is stored
    Settings m_kept;                 // the settings that the file has
    Extent2D m_windowSize{};         // points, in the last frame
    FileDialog m_dialog;
    RenderDialog m_render;
    // RenderQueue::AddedCount when the user was told that closing cancels the renders; 0: not told.
    uint64_t m_lostRenders = 0;
    uint64_t m_sceneCount = 0;  // of those that were shown: dialogs find out that theirs is gone
    UnsavedDialog m_unsaved;
    std::optional<LoadedScene> m_loaded;  // waits for an answer
    uint64_t m_discardedChanges = 0;      // Document::ChangeCount when the user agreed to lose the edits
    // Holds the position of the picture's corner in the window, in pixels, in the last frame.
    glm::ivec2 m_viewOrigin{0};
    GizmoView m_gizmo;
    bool m_isViewHovered = false;
    bool m_opensAddMenu = false;
    bool m_isPreparing = false;  // pipelines of the picture are being created
    bool m_isReloading = false;  // shader reload waits until no pipeline is being created
    // Is true while the first scene is loaded: the empty scene is not worth the creation of its pipelines.
    bool m_isAwaiting = false;
    FrameInput m_lastInput;
    float m_idleSeconds = 0.0f;         // seconds without input
    std::optional<MouseButton> m_drag;  // button of a drag that began over the picture
    glm::vec2 m_lastMouse{0.0f}, m_pressedAt{0.0f};
    bool m_hasMoved = false;
    viewport::View m_tracedView = viewport::View::PathTraced;  // to which keys of other views return
    viewport::Pick m_pick;
    bool m_isPicking = false;
    std::filesystem::path m_pictureFile, m_windowFile;
    struct Saving {
        std::filesystem::path file;
        Readback texels;
        bool isSwapped = false;        // BGRA texels
        bool hasAlpha = false;         // else the file is opaque
        uint32_t denoisedSamples = 0;  // ViewportProgress::denoisedSamples
    };
    std::vector<Saving> m_saving;
    struct SavingRender {
        std::filesystem::path file;
        viewport::Capture capture;
        ShownScene shown{};     // state of the captured frame, without data and hash
        FileContent content{};  // state of the captured frame
        bool isTaken = false;
    };
    std::vector<SavingRender> m_savingRenders;
    Worker m_worker;  // writes pictures; declared after what its tasks refer to
    uint64_t m_savedCount = 0;
    std::string m_frameError;    // "": the last frame was drawn
    std::string m_droppedFrame;  // last logged reason for which a frame with a target was dropped
};

}  // namespace raygraph::editor
