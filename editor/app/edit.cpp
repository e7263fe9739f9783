#include "editor/app/edit.h"

#include "editor/app/editor.h"
#include "editor/app/script.h"
#include "editor/app/settings.h"
#include "editor/app/window.h"
#include "rhi/swapchain.h"

namespace raygraph::editor {

namespace {

void PlayScript(const EditOptions& options, const OpenDevice& openDevice) {
    Script script(options.script);
    const std::unique_ptr<rhi::Device> device = openDevice({});
    PictureScreen screen;
    Editor editor(*device, {.shaders = options.shaders, .log = options.log});
    if (!options.scene.empty()) editor.Work().Open(options.scene);
    script.Play(editor, screen);
}

void RunWindow(const EditOptions& options, const OpenDevice& openDevice) {
    const std::filesystem::path config = ConfigFolder();
    std::string ignored;  // the editor says it
    Window window("Raygraph", config.empty() ? Settings().window : ReadSettings(config, ignored).window);
    const std::unique_ptr<rhi::Device> device = openDevice(window.SurfaceExtensions());
    rhi::Swapchain swapchain(
        *device, {.name = "window", .makeSurface = window.SurfaceMaker(), .extent = window.Extent()});
    WindowScreen screen(swapchain);
    Editor editor(*device, {.shaders = options.shaders, .log = options.log});
    window.ShareClipboard();
    if (!config.empty()) editor.UseConfig(config);
    if (!options.scene.empty()) editor.Work().Open(options.scene);
    std::string title;
    for (FrameInput input = window.Poll(); editor.Frame(input, screen);) {
        const Document& document = editor.Work().document;
        const std::string name = document.File().filename().string();
        const std::string wanted =
            (name.empty() ? "" : name + (document.IsEdited() ? " (edited) - " : " - ")) + "Raygraph";
        if (wanted != title) window.SetTitle(title = wanted);
        input = window.Poll(input.extent.IsEmpty() ? 0.1 : 0.0);
    }
    editor.KeepSettings();
}

}  // namespace

void RunEditor(const EditOptions& options, const OpenDevice& openDevice) {
    if (options.script.empty())
        RunWindow(options, openDevice);
    else
        PlayScript(options, openDevice);
}

}  // namespace raygraph::editor
