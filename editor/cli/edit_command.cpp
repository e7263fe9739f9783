// Implements `raygraph edit`, which calls the editor.
#include "editor/cli/commands.h"

#ifdef RAYGRAPH_HAS_EDITOR
#include <array>
#include <cmath>
#include <utility>

#include "base/os.h"
#include "editor/app/edit.h"
#include "editor/cli/device_setup.h"
#else
#include "base/text.h"
#endif

namespace raygraph::cli {

#ifdef RAYGRAPH_HAS_EDITOR
namespace {

// Returns the words with which this program renders on the editor's device.
std::vector<std::string> RenderProgram(const std::string& device) {
    const std::filesystem::path program = os::ProgramFile();
    if (program.empty()) return {};
    std::vector<std::string> words{program.string(), "render"};
    if (!device.empty()) words.push_back("--device=" + device);
    return words;
}

// Returns how the view of the first scene is changed by what the command line gives.
editor::ChangeView ChangeOf(const EditArguments& arguments) {
    return [arguments, settings = SettingsFrom(arguments.given)](editor::SceneView& seen) {
        const auto isGiven = [&](const char* name) { return arguments.given.contains(name); };
        const auto take = [](const std::array<float, 3>& rgb) { return glm::vec3(rgb[0], rgb[1], rgb[2]); };
        if (isGiven("camera")) seen.camera = settings.camera;
        if (isGiven("aperture")) seen.aperture = settings.aperture;
        if (isGiven("focus")) seen.focus = settings.focusDistance;
        if (isGiven("light") || settings.background || !arguments.environment.empty())
            seen.ResetEnvironment();  // what is given replaces a stored environment as a whole
        if (isGiven("light")) seen.light = settings.light;
        if (!arguments.environment.empty()) seen.environment = arguments.environment;
        if (isGiven("env-rotation")) seen.rotation = settings.environmentRotation;
        if (isGiven("env-tint")) seen.radiance = take(settings.environmentTint);
        if (settings.background) {
            seen.usesScene = false;
            seen.radiance = take(*settings.background);
        }
        if (!arguments.backdrop.empty()) seen.backdrop = arguments.backdrop;
        if (isGiven("ground")) seen.hasGround = settings.hasGround;
        seen.exposureEv = arguments.exposureEv.value_or(seen.exposureEv);
        seen.tonemap = arguments.tonemap.value_or(seen.tonemap);
        if (arguments.whitePoint)
            seen.whitePoint = static_cast<int>(std::lround(*arguments.whitePoint->kelvin));
    };
}

}  // namespace
#endif

void EditCommand(const EditArguments& arguments, [[maybe_unused]] Console& console) {
#ifdef RAYGRAPH_HAS_EDITOR
    if (arguments.isListingKeys) return PrintLine(editor::KeyList());
    os::MapLargeBlocks();  // scenes are allocated and freed beside frames
    const auto history = std::make_shared<editor::LogHistory>();
    console.log.AddListener([history](const LogMessage& message) { history->Add(message); });
    const Log log = console.log.ForLibraries();
    const PictureSettings settings = SettingsFrom(arguments.given);
    const std::optional<EditView>& view = arguments.view;
    editor::RunEditor({.scene = arguments.scene,
                       .variant = arguments.variant,
                       .root = arguments.root,
                       .environment = arguments.environment,
                       .changeView = ChangeOf(arguments),
                       .view = view ? std::optional(view->view) : std::nullopt,
                       .surface = view ? view->surface : std::nullopt,
                       .compared = view ? std::optional(view->compared) : std::nullopt,
                       .pointsAndLines = arguments.pointsAndLines,
                       .script = arguments.script,
                       .shaders = arguments.shaders,
                       .textureBudget = settings.textureBudget,
                       .render = RenderProgram(arguments.device),
                       .log = history},
                      [&](std::vector<std::string> surfaceExtensions) {
                          return OpenDevice({.select = arguments.device,
                                             .isValidating = arguments.isValidating,
                                             .surfaceExtensions = std::move(surfaceExtensions)},
                                            log);
                      });
    console.log.RequireValid();
#else
    throw MakeError(ErrorKind::Usage, "edit {}: this program has no editor; raygraph render needs none",
                    arguments.scene.string());
#endif
}

}  // namespace raygraph::cli
