#include "editor/app/edit.h"

#include <tuple>

#include "base/error.h"
#include "base/os.h"
#include "base/text.h"
#include "editor/app/actions.h"
#include "editor/app/script.h"
#include "editor/app/settings.h"
#include "editor/app/window.h"
#include "editor/session/settings/scene_input.h"
#include "renderer/scene/gltf/save_gltf.h"
#include "rhi/swapchain.h"

namespace raygraph::editor {

namespace {

// The interval, in seconds, between frames without input while pipelines are made, which takes time on a CPU
// device.
constexpr double kPreparingPoll = 0.2;
constexpr double kBusyPoll = 0.002;  // in seconds: the device is polled this often, which can delay a frame

void RequireEnvironment(const std::filesystem::path& file) {
    if (!file.empty() && !Workspace::IsEnvironment(file))
        throw MakeError(ErrorKind::BadInput, "{}: an environment map ends in .hdr or .exr", file);
}

// Applies the options on top of the stored settings.
void Begin(Workspace& work, const EditOptions& options) {
    work.pointsAndLines = options.pointsAndLines;
    work.root = options.root;
    viewport::ShowSettings show = work.view.Show();
    show.view = options.view.value_or(show.view);
    show.surface = options.surface.value_or(show.surface);
    show.compared = options.compared.value_or(show.compared);
    work.view.SetShow(show);
    if (options.changeView) {
        SceneView seen = work.ShownView();
        options.changeView(seen);
        seen.camera.clear();  // without a scene there is none to choose
        work.Use(seen);
    }
    if (!options.scene.empty()) work.Open(options.scene, options.variant, options.changeView);
}

void PlayScript(const EditOptions& options, const OpenDevice& openDevice) {
    Script script(options.script);
    const std::unique_ptr<rhi::Device> device = openDevice({});
    PictureScreen screen;
    Editor editor(*device, {.shaders = options.shaders,
                            .textureBudget = options.textureBudget,
                            .log = options.log,
                            .render = options.render});
    Begin(editor.Work(), options);
    script.Play(editor, screen);
}

// Opens the window. Without a display, the error tells how to make a picture, or that the file is no scene.
Window OpenWindow(const std::filesystem::path& config, const std::filesystem::path& scene) {
    std::string ignored;  // not used: the editor reports it
    try {
        return Window("Raygraph", config.empty() ? Settings().window : ReadSettings(config, ignored).window);
    } catch (const Error& error) {
        const bool isMap = Workspace::IsEnvironment(scene), isScene = !scene.empty() && !isMap;
        if (isScene) std::ignore = scene::ReadGltfJson(scene);
        const std::string file = isScene ? os::ForShell(scene.string()) : "FILE";
        const std::string picture = isScene ? os::ForShell(scene.filename().string() + ".png") : "FILE.png";
        throw MakeError(error.Kind(), "{}; without one: raygraph render {}{} -o {}", error.what(), file,
                        isMap ? " --env " + os::ForShell(scene.string()) : "", picture);
    }
}

void RunWindow(const EditOptions& options, const OpenDevice& openDevice) {
    const std::filesystem::path config = ConfigFolder();
    Window window = OpenWindow(config, options.scene);
    const std::unique_ptr<rhi::Device> device = openDevice(window.SurfaceExtensions());
    rhi::Swapchain swapchain(
        *device, {.name = "window", .makeSurface = window.SurfaceMaker(), .extent = window.Extent()});
    WindowScreen screen(swapchain);
    // Hides the window while the editor waits for threads that create pipelines, which can take seconds
    class Hidden {
      public:
        explicit Hidden(Window& window) : m_window(window) {}
        ~Hidden() { m_window.Hide(); }

      private:
        Window& m_window;
    };
    Editor editor(*device, {.shaders = options.shaders,
                            .textureBudget = options.textureBudget,
                            .log = options.log,
                            .render = options.render});
    const Hidden whenDone(window);
    window.ShareClipboard();
    viewport::BudgetSettings budget = editor.Work().view.Budget();
    budget.whilePreparing = viewport::PreparingView::Preview;
    editor.Work().view.SetBudget(budget);
    editor.Work().allowsLongFrames = true;
    editor.AllowDesktopDialogs();
    if (!config.empty()) editor.SetConfigFolder(config);
    Begin(editor.Work(), options);
    if (!options.view && !editor.StoredSettings().view) editor.Work().ChooseViewByTime();
    RunFrames(editor, screen,
              {.poll = [&](double seconds) { return window.Poll(seconds); },
               .setTitle = [&](const std::string& title) { window.SetTitle(title); }});
    editor.StoreSettings();
}

std::string TitleOf(const Document& document) {
    const std::string name = document.File().filename().string();
    return (name.empty() ? "" : name + (document.IsEdited() ? " (edited) - " : " - ")) + "Raygraph";
}

// Returns where unsaved edits were written, for the end of a message.
std::string RecoveryMessage(const Document& document) {
    if (!document.IsEdited()) return "";
    try {
        return "; unsaved edits are in " + document.SaveRecoveryCopy().string();
    } catch (const std::exception& error) {
        return Text("; unsaved edits are lost: {}", error.what());
    }
}

}  // namespace

void RunFrames(Editor& editor, Screen& screen, const FrameSource& window) {
    try {
        WithMemoryErrors("the editor", [&] {
            std::string title;
            for (FrameInput input = window.poll(0.0); editor.Frame(input, screen);) {
                const std::string wanted = TitleOf(editor.Work().document);
                if (wanted != title) window.setTitle(title = wanted);
                input = window.poll(input.extent.IsEmpty() ? 0.1
                                    : editor.IsPreparing() ? kPreparingPoll
                                                           : 0.0);
                // A window whose events wait for the device is taken for one that hangs
                while (!screen.IsReady(editor.Work().renderer)) input.Append(window.poll(kBusyPoll));
            }
        });
    } catch (const Error& error) {
        throw Error(error.Kind(), error.what() + RecoveryMessage(editor.Work().document), error.Result());
    }
}

void RunEditor(const EditOptions& options, const OpenDevice& openDevice) {
    RequireEnvironment(options.environment);
    session::RequireRoot(options.root);
    if (options.script.empty())
        RunWindow(options, openDevice);
    else
        PlayScript(options, openDevice);
}

std::string KeyList() {
    const KeyBindings bindings;
    std::vector<std::pair<std::string, std::string>> rows = GestureRows(bindings.Preset());
    for (const ActionRow& row : Actions())
        if (const std::string keys = bindings.TextOf(row.action); !keys.empty())
            rows.emplace_back(keys, row.help);
    std::string list;
    for (const auto& [keys, effect] : rows)
        list += Text("{}{:<32}{}", list.empty() ? "" : "\n", keys, effect);
    return list;
}

}  // namespace raygraph::editor
