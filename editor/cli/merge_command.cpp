// raygraph merge
#include "base/text.h"
#include "editor/cli/command_files.h"
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/merge_report.h"
#include "editor/cli/report.h"
#include "editor/session/merge.h"

namespace raygraph::cli {

void MergeCommand(const MergeArguments& arguments, Console& console) {
    const Log log = console.log.ForLibraries();
    CheckWritable(FilesOf(arguments));
    std::vector<NamedRender> parts;
    for (const std::filesystem::path& path : arguments.inputs)
        parts.push_back({path.string(), ReadRenderFile(path, log)});
    const size_t count = parts.size();
    MergeReport report;
    for (const NamedRender& part : parts) report.inputs.push_back(DescribePart(part));
    const RenderFile merged = Merge(std::move(parts));
    WriteRenderFile(arguments.output, merged, log);
    if (!arguments.report.empty()) {
        report.output = DescribePart({arguments.output.string(), merged});
        WriteTextFile(arguments.report, ToJson(report));
    }
    if (arguments.isQuiet) return;
    PrintLine(arguments.output.string());
    if (!arguments.report.empty()) PrintLine(arguments.report.string());
    PrintLine(Text("{} samples a pixel ({}) from {} renders", SampleCount(merged.samples),
                   ToText(merged.samples), count));
}

}  // namespace raygraph::cli
