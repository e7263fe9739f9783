#include "editor/cli/command_files.h"

#include <algorithm>

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
    // Anything but a render in place of the resumed one would destroy it
    Paths renders;
    for (const OutputFile& picture : PicturesOf(arguments))
        if (picture.kind == OutputKind::Exr) renders.push_back(picture.path);
    return {.inputs = Given({arguments.scene, arguments.environment}),
            .updated = Given({arguments.resume}),
            .outputs = Given(std::move(outputs)),
            .replacing = std::move(renders)};
}

CommandFiles FilesOf(const BenchArguments& arguments) {
    return {.inputs = Given({arguments.scene, arguments.environment}),
            .updated = Given({arguments.compare}),
            .outputs = Given({arguments.json}),
            .replacing = {}};
}

CommandFiles FilesOf(const InfoArguments& arguments) {
    return {.inputs = Given({arguments.scene}), .updated = {}, .outputs = {}, .replacing = {}};
}

CommandFiles FilesOf(const GraphArguments& arguments) {
    return {.inputs = {arguments.scene}, .updated = {}, .outputs = {}, .replacing = {}};
}

CommandFiles FilesOf(const MergeArguments& arguments) {
    return {.inputs = {},
            .updated = arguments.inputs,
            .outputs = {arguments.output},
            .replacing = {arguments.output}};
}

CommandFiles FilesOf(const EditArguments& arguments) {
    return {
        .inputs = Given({arguments.scene, arguments.script}), .updated = {}, .outputs = {}, .replacing = {}};
}

void CheckWritable(const CommandFiles& files) {
    CheckWritable(files.outputs, files.inputs);
    Paths others = files.outputs;
    std::erase_if(others, [&](const std::filesystem::path& output) {
        return std::ranges::find(files.replacing, output) != files.replacing.end();
    });
    CheckWritable(others, files.updated);
}

std::vector<OutputFile> PicturesOf(const RenderArguments& arguments) {
    if (!arguments.outputs.empty()) return arguments.outputs;
    return {ParseOutput(arguments.resume.empty() ? kDefaultPicture : arguments.resume)};
}

}  // namespace raygraph::cli
