// raygraph merge
#include "base/text.h"
#include "editor/cli/command_files.h"
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/session/merge.h"
#include "renderer/image/exr_threads.h"

namespace raygraph::cli {

void MergeCommand(const MergeArguments& arguments, Console& console) {
    const Log log = console.log.ForLibraries();
    CheckWritable(FilesOf(arguments));
    const image::ExrThreads threads;
    std::vector<NamedRender> parts;
    for (const std::filesystem::path& path : arguments.inputs)
        parts.push_back({path.string(), ReadRenderFile(path, log)});
    const size_t count = parts.size();
    const RenderFile merged = Merge(std::move(parts));
    WriteRenderFile(arguments.output, merged, log);
    if (arguments.isQuiet) return;
    PrintLine(arguments.output.string());
    PrintLine(Text("{} samples a pixel ({}) from {} renders", SampleCount(merged.samples),
                   ToText(merged.samples), count));
}

}  // namespace raygraph::cli
