// raygraph edit: hands over to the editor.
#include "editor/cli/commands.h"

#ifdef RAYGRAPH_HAS_EDITOR
#include <utility>

#include "editor/app/edit.h"
#include "editor/cli/device_setup.h"
#include "editor/cli/edit_picture.h"
#else
#include "base/error.h"
#endif

namespace raygraph::cli {

void EditCommand(const EditArguments& arguments) {
#ifdef RAYGRAPH_HAS_EDITOR
    DeviceMessages messages;
    const editor::SaveRender saveRender = [](const std::filesystem::path& file,
                                             editor::SavedRender&& render) {
        WriteRenderFile(file, RenderFileOf(std::move(render)));
    };
    editor::RunEditor({.scene = arguments.scene,
                       .script = arguments.script,
                       .shaders = arguments.shaders,
                       .saveRender = saveRender},
                      [&](std::vector<std::string> surfaceExtensions) {
                          return OpenDevice({.select = arguments.device,
                                             .isValidating = arguments.isValidating,
                                             .surfaceExtensions = std::move(surfaceExtensions)},
                                            messages);
                      });
    messages.RequireValid();
#else
    throw Error(ErrorKind::Usage, "edit " + arguments.scene.string() + ": this program has no editor");
#endif
}

}  // namespace raygraph::cli
