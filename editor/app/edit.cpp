#include "editor/app/edit.h"

#include "editor/app/editor.h"
#include "editor/app/script.h"
#include "editor/app/window.h"
#include "rhi/swapchain.h"

namespace raygraph::editor {

namespace {

void PlayScript(const EditOptions& options, const OpenDevice& openDevice) {
    Script script(options.script);
    const std::unique_ptr<rhi::Device> device = openDevice({});
    PictureScreen screen;
    Editor editor(*device, options.shaders);
    if (!options.scene.empty()) editor.Work().Open(options.scene);
    script.Play(editor, screen);
}

void RunWindow(const EditOptions& options, const OpenDevice& openDevice) {
    Window window("Raygraph", {1440, 900});
    const std::unique_ptr<rhi::Device> device = openDevice(window.SurfaceExtensions());
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

void RunEditor(const EditOptions& options, const OpenDevice& openDevice) {
    if (options.script.empty())
        RunWindow(options, openDevice);
    else
        PlayScript(options, openDevice);
}

}  // namespace raygraph::editor
