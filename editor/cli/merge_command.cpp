// Implements `raygraph merge`.
#include "base/printable.h"
#include "base/text.h"
#include "editor/cli/command_files.h"
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/merge_report.h"
#include "editor/cli/outputs.h"
#include "editor/cli/report.h"
#include "editor/session/file/merge.h"
#include "renderer/image/exr.h"

namespace raygraph::cli {

ExitCode MergeCommand(const MergeArguments& arguments, Console& console) {
    const Log log = console.log.ForLibraries();
    CheckWritable(FilesOf(arguments), log);
    const image::ExrThreads threads;
    // One file is read at a time, since a job array may have made more of them than fit into memory
    Merger merger;
    MergeReport report;
    for (const std::filesystem::path& path : arguments.inputs) {
        NamedRender part{path.string(), ReadRenderFile(path, log)};
        report.inputs.push_back(DescribePart(part));
        merger.Add(std::move(part));
    }
    const size_t count = arguments.inputs.size();
    const RenderFile merged = merger.Take();
    OutputWriter outputs([&](const auto&, std::string_view why) { console.log.Fail(why); });
    outputs.Add(arguments.output, [&] { WriteRenderFile(arguments.output, merged, log); });
    if (!arguments.report.empty()) {
        report.output = DescribePart({arguments.output.string(), merged});
        outputs.Add(arguments.report, [&] { WriteTextFile(arguments.report, ToJson(report)); });
    }
    outputs.WriteAll();
    if (arguments.isQuiet) return outputs.Result();
    for (const std::filesystem::path& file : outputs.Written()) PrintLine(file.string());
    PrintLine(Text("{} a pixel ({}) from {}", Counted(SampleCount(merged.samples), "sample"),
                   ToText(merged.samples), Counted(count, "render")));
    return outputs.Result();
}

}  // namespace raygraph::cli
