#include "editor/app/edit.h"

#include <memory>
#include <mutex>

#include "base/error.h"
#include "editor/app/editor.h"
#include "editor/app/script.h"
#include "editor/app/window.h"
#include "rhi/swapchain.h"

namespace raygraph::editor {

namespace {

// The first validation message, from any thread.
class Watch {
  public:
    void Add(const rhi::Message& message) {
        if (!message.isValidation || message.severity == rhi::MessageSeverity::Info) return;
        const std::scoped_lock lock(m_mutex);
        if (m_first.empty()) m_first = message.text;
    }
    void RequireValid() const {
        const std::scoped_lock lock(m_mutex);
        if (!m_first.empty()) throw Error(ErrorKind::Vulkan, "validation: " + m_first);
    }

  private:
    mutable std::mutex m_mutex;
    std::string m_first;
};

std::unique_ptr<rhi::Device> OpenDevice(const EditOptions& options, Watch& watch,
                                        std::vector<std::string> surfaceExtensions) {
    return rhi::Device::Create({.select = options.device,
                                .validation = options.isValidating,
                                .onMessage = [&watch](const rhi::Message& message) { watch.Add(message); },
                                .surfaceExtensions = std::move(surfaceExtensions)});
}

void PlayScript(const EditOptions& options, Watch& watch) {
    Script script(options.script);
    const std::unique_ptr<rhi::Device> device = OpenDevice(options, watch, {});
    PictureScreen screen;
    Editor editor(*device, options.shaders);
    if (!options.scene.empty()) editor.Work().Open(options.scene);
    script.Play(editor, screen);
}

void RunWindow(const EditOptions& options, Watch& watch) {
    Window window("Raygraph", {1440, 900});
    const std::unique_ptr<rhi::Device> device = OpenDevice(options, watch, window.SurfaceExtensions());
    rhi::Swapchain swapchain(
        *device, {.name = "window", .makeSurface = window.SurfaceMaker(), .extent = window.Extent()});
    WindowScreen screen(swapchain);
    Editor editor(*device, options.shaders);
    if (!options.scene.empty()) editor.Work().Open(options.scene);
    std::string title;
    for (FrameInput input = window.Poll(); editor.Frame(input, screen);) {
        const Document& document = editor.Work().document;
        const std::string name = document.File().filename().string();
        const std::string wanted =
            (name.empty() ? "" : name + (document.EditCount() > 0 ? " (edited) - " : " - ")) + "Raygraph";
        if (wanted != title) window.SetTitle(title = wanted);
        input = window.Poll(input.extent.IsEmpty() ? 0.1 : 0.0);
    }
}

}  // namespace

void RunEditor(const EditOptions& options) {
    Watch watch;
    if (options.script.empty())
        RunWindow(options, watch);
    else
        PlayScript(options, watch);
    watch.RequireValid();
}

}  // namespace raygraph::editor
