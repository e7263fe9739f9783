// raygraph merge
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/merge.h"

namespace raygraph::cli {

void MergeCommand(const MergeArguments& arguments) {
    // The output may be one of the inputs: they are read before it is replaced
    CheckWritable(std::vector{arguments.output}, {});
    std::vector<NamedRender> parts;
    for (const std::filesystem::path& path : arguments.inputs)
        parts.push_back({path.string(), ReadRenderFile(path)});
    const size_t count = parts.size();
    const RenderFile merged = Merge(std::move(parts));
    WriteRenderFile(arguments.output, merged);
    if (arguments.isQuiet) return;
    PrintLine(arguments.output.string());
    PrintLine(std::to_string(SampleCount(merged.samples)) + " samples a pixel (" + ToText(merged.samples) +
              ") from " + std::to_string(count) + " renders");
}

}  // namespace raygraph::cli
