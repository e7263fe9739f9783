#include "editor/cli/command_files.h"

namespace raygraph::cli {

namespace {

using Paths = std::vector<std::filesystem::path>;

Paths Given(Paths paths) {
    std::erase(paths, std::filesystem::path());
    return paths;
}

}  // namespace

CommandFiles FilesOf(const RenderArguments& arguments) {
    Paths outputs{arguments.report};
    for (const OutputFile& picture : PicturesOf(arguments)) outputs.push_back(picture.path);
    return {.inputs = Given({arguments.scene, arguments.environment}),
            .updated = Given({arguments.resume}),
            .outputs = Given(std::move(outputs))};
}

CommandFiles FilesOf(const BenchArguments& arguments) {
    return {.inputs = Given({arguments.scene, arguments.environment}),
            .updated = Given({arguments.compare}),
            .outputs = Given({arguments.json})};
}

CommandFiles FilesOf(const InfoArguments& arguments) {
    return {.inputs = Given({arguments.scene}), .updated = {}, .outputs = {}};
}

CommandFiles FilesOf(const GraphArguments& arguments) {
    return {.inputs = {arguments.scene}, .updated = {}, .outputs = {}};
}

CommandFiles FilesOf(const MergeArguments& arguments) {
    return {.inputs = {}, .updated = arguments.inputs, .outputs = {arguments.output}};
}

CommandFiles FilesOf(const EditArguments& arguments) {
    return {.inputs = Given({arguments.scene, arguments.script}), .updated = {}, .outputs = {}};
}

void CheckWritable(const CommandFiles& files) {
    CheckWritable(files.outputs, files.inputs);
}

std::vector<OutputFile> PicturesOf(const RenderArguments& arguments) {
    if (!arguments.outputs.empty()) return arguments.outputs;
    return {ParseOutput(arguments.resume.empty() ? kDefaultPicture : arguments.resume)};
}

}  // namespace raygraph::cli
