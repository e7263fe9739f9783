// RenderDialog asks for a render of what the editor shows, hands it to a RenderQueue, and lists what is in
// the queue. Threads: main thread only.
#pragma once

#include <array>
#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "editor/app/file_dialog.h"
#include "editor/app/render_queue.h"
#include "editor/app/workspace.h"
#include "passes/tiles.h"
#include "shaders/shared/choice.h"

namespace raygraph::editor {

// Says what ends a render; Clean leaves it to `render`.
#define RAYGRAPH_RENDER_STOPS(X, Of)      \
    X(Of, Clean, 0, "it looks clean", "") \
    X(Of, Samples, 1, "samples", "")      \
    X(Of, Error, 2, "error", "")          \
    X(Of, Time, 3, "time", "")
RAYGRAPH_CHOICE(RenderStop, RAYGRAPH_RENDER_STOPS)

#define RAYGRAPH_RENDERED_PICTURES(X, Of) \
    X(Of, View, 0, "this view", "")       \
    X(Of, Cameras, 1, "all cameras", "")  \
    X(Of, Frames, 2, "animation", "")
RAYGRAPH_CHOICE(RenderedPictures, RAYGRAPH_RENDERED_PICTURES)

struct RenderRequest {
    RenderedPictures pictures = RenderedPictures::View;
    double first = 0.0, last = 0.0;  // seconds, of Frames
    float framesPerSecond = 24.0f;
    Extent2D size{};
    std::optional<passes::Region> crop;
    RenderStop stop = RenderStop::Clean;
    uint32_t samples = 256;  // for RenderStop::Samples
    float percent = 1.0f;    // for RenderStop::Error
    float minutes = 1.0f;    // for RenderStop::Time
    bool isDenoised = true;
    // They end in .png, .jpg, .exr or .hdr; a relative one is in the current folder. Several pictures need
    // {camera} or a run of # in the name (docs/cli.md).
    std::vector<std::filesystem::path> outputs;
};

// Returns why there can be no such render now, in a line; "": there can.
std::string WhyNotRendered(const Workspace& work, const RenderRequest& request);

// Returns the task of the path-traced pictures. `command` is the program with the first arguments. Unsaved
// edits are written to a file in a folder of its own in the cache, which may throw as scene::SaveGltf does.
RenderTask TaskOf(const Workspace& work, const RenderRequest& request, std::vector<std::string> command);

class RenderDialog {
  public:
    // `command` is TaskOf's; empty: there is no program that renders.
    explicit RenderDialog(std::vector<std::string> command) : m_command(std::move(command)) {}

    void Open(const Workspace& work);
    bool IsOpen() const { return m_isOpen; }
    void Close() { m_isOpen = false; }
    // Fills in the fields: a size, a number of samples, and a file without denoising.
    void Fill(Extent2D size, uint32_t samples, const std::filesystem::path& file);
    void Draw(Workspace& work, FileDialog& files);
    // Draws the progress of the running job into the status line.
    void DrawStatus();
    // Goes on with the queue; called once a frame. The message reports jobs that have ended.
    void Update(Workspace& work);
    const RenderQueue& Queue() const { return m_queue; }
    // Chooses the name and the format of a file, and no other format.
    void SetFile(std::filesystem::path file);
    // Returns what the fields ask for.
    RenderRequest Request() const;
    // Returns why that cannot be queued now, in a line; "": it can.
    std::string WhyNot(const Workspace& work, const RenderRequest& request) const;

  private:
    void SetName(const std::string& name);
    void Start(Workspace& work, const RenderRequest& request);
    void DrawPictures(const Workspace& work);
    void DrawOptions();
    bool DrawFile(FileDialog& files);  // returns whether Enter was pressed
    void DrawQueue();

    std::vector<std::string> m_command;
    RenderQueue m_queue;
    bool m_isOpen = false, m_isNew = false;  // new: no frame has drawn it
    int m_openedCount = 0;
    std::filesystem::path m_scene;    // that the name is of
    RenderRequest m_request;          // without outputs
    passes::Region m_crop{};          // of the fields
    std::array<char, 1024> m_file{};  // as it is typed, without extension
    std::array<bool, 4> m_formats{true, false, false, false};
};

}  // namespace raygraph::editor
