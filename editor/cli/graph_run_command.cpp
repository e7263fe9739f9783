// Implements `raygraph graph run`.
#include <cstdio>
#include <string>

#include "base/text.h"
#include "editor/cli/command_files.h"
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/device_setup.h"
#include "editor/cli/outputs.h"
#include "editor/graph_run/graph_run.h"

namespace raygraph::cli {

namespace {

// Returns the files that the description names, with the outputs in the folder of the command line.
CommandFiles FilesOf(const GraphRunArguments& arguments, const graph_run::GraphFile& graph) {
    CommandFiles files = FilesOf(arguments);
    const auto addInput = [&](const std::filesystem::path& file) {
        if (!file.empty()) files.inputs.push_back(graph.folder / file);
    };
    for (const auto& [name, texture] : graph.textures) addInput(texture.file);
    for (const auto& [name, buffer] : graph.buffers) addInput(buffer.file);
    for (const graph_run::FilePass& pass : graph.passes) addInput(pass.shader);
    for (const graph_run::FileOutput& output : graph.outputs)
        files.outputs.push_back(arguments.folder / output.file);
    return files;
}

std::string TimesText(const graph_run::GraphRun& run) {
    std::string text;
    for (const graph_run::PassCost& pass : run.passes)
        text += Text("{:<32}  {:.3f} ms\n", Printable(pass.name), pass.gpuMs);
    return text;
}

}  // namespace

ExitCode GraphRunCommand(const GraphRunArguments& arguments, Console& console) {
    const Log log = console.log.ForLibraries();
    graph_run::GraphFile graph = graph_run::ReadGraphFile(arguments.description);
    if (arguments.frames) graph.frames = *arguments.frames;
    const CommandFiles files = FilesOf(arguments, graph);
    CheckWritable(files, log);
    graph_run::GraphRun run;
    {
        const std::unique_ptr<rhi::Device> device =
            OpenDevice({.select = arguments.device, .isValidating = arguments.isValidating}, log);
        run = graph_run::RunGraph(*device, graph);
    }
    console.log.RequireValid();
    OutputWriter outputs([&](const auto&, std::string_view why) { console.log.Fail(why); });
    for (size_t i = 0; i < files.outputs.size(); ++i)
        outputs.Add(files.outputs[i], [&, i] { graph_run::WriteOutput(run.outputs[i], files.outputs[i]); });
    outputs.WriteAll();
    // Graphviz reads the plan alone.
    std::string text = arguments.isDot ? run.dot : arguments.showsPlan ? run.plan : "";
    if (!text.empty() && !text.ends_with('\n')) text += '\n';
    if (arguments.showsTimes) text += TimesText(run);
    if (!arguments.isQuiet && !arguments.isDot)
        for (const std::filesystem::path& file : outputs.Written()) PrintLine(file.string());
    std::fputs(text.c_str(), stdout);
    return outputs.Result();
}

}  // namespace raygraph::cli
