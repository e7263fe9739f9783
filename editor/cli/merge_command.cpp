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
    // One after another: a job array may have made more of them than memory holds
    Merger merger;
    for (const std::filesystem::path& path : arguments.inputs)
        merger.Add({path.string(), ReadRenderFile(path, log)});
    const size_t count = arguments.inputs.size();
    const RenderFile merged = merger.Take();
    WriteRenderFile(arguments.output, merged, log);
    if (arguments.isQuiet) return;
    PrintLine(arguments.output.string());
    PrintLine(Text("{} samples a pixel ({}) from {} {}", SampleCount(merged.samples), ToText(merged.samples),
                   count, count == 1 ? "render" : "renders"));
}

}  // namespace raygraph::cli
