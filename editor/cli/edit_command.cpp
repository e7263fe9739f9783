// raygraph edit: hands over to the editor.
#include "editor/cli/commands.h"

#ifdef RAYGRAPH_HAS_EDITOR
#include "editor/app/edit.h"
#else
#include "base/error.h"
#endif

namespace raygraph::cli {

void EditCommand(const EditArguments& arguments) {
#ifdef RAYGRAPH_HAS_EDITOR
    editor::RunEditor({.scene = arguments.scene,
                       .script = arguments.script,
                       .shaders = arguments.shaders,
                       .device = arguments.device,
                       .isValidating = arguments.isValidating});
#else
    throw Error(ErrorKind::Usage, "edit " + arguments.scene.string() + ": this program has no editor");
#endif
}

}  // namespace raygraph::cli
