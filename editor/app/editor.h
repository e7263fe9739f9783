// The editor: a workspace, panels around a picture of it, keys and mouse. One frame at a time, from any
// source of input onto any screen.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "editor/app/input.h"
#include "editor/app/screen.h"
#include "editor/app/ui.h"
#include "editor/app/workspace.h"

namespace raygraph::editor {

class Editor {
  public:
    explicit Editor(rhi::Device& device, const std::filesystem::path& shaders = {});

    Workspace& Work() { return m_work; }
    // Takes the input, draws the next frame. False: the user wants to leave.
    bool Frame(const FrameInput& input, Screen& screen);
    // Until it is false, a script that waits goes on waiting: for a scene, a pick or a file.
    bool IsBusy() const;
    // Why the last frame was not drawn, one line; empty: it was.
    const std::string& FrameError() const { return m_frameError; }
    // The picture as shown, or the whole window, as .png once the next frame has been drawn.
    void SavePicture(const std::filesystem::path& file) { m_pictureFile = file; }
    void SaveWindow(const std::filesystem::path& file) { m_windowFile = file; }

  private:
    void BuildUi(const FrameInput& input);
    void MenuBar();
    void OpenDialog();
    void ViewArea(const FrameInput& input, float left, float top, float width, float height);
    void StatusBar(float top, float width, float height);
    void UseBookmark(size_t slot, bool isKept);
    void Keys(const FrameInput& input);
    void Mouse(const FrameInput& input);
    void Fly(const FrameInput& input);
    void TakePick();
    void Draw(Screen& screen, const FrameInput& input);
    void FinishSaving();

    Workspace m_work;
    Ui m_ui;
    bool m_isLeaving = false;
    bool m_isOpening = false;  // the dialog is to be shown
    char m_openPath[1024] = {};
    // The picture's place in the window, pixels
    glm::ivec2 m_viewOrigin{0};
    bool m_isOverView = false;
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
    std::string m_frameError;
};

}  // namespace raygraph::editor
