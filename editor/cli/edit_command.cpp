// Implements `raygraph edit`, which calls the editor.
#include "editor/cli/commands.h"

#ifdef RAYGRAPH_HAS_EDITOR
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
                       .camera = settings.camera,
                       .root = arguments.root,
                       .environment = arguments.environment,
                       .light = settings.light,
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
