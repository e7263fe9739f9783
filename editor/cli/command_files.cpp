#include "editor/cli/command_files.h"

#include <algorithm>

namespace raygraph::cli {

namespace {

using Paths = std::vector<std::filesystem::path>;

Paths Given(Paths paths) {
    std::erase(paths, std::filesystem::path());
    return paths;
}

std::filesystem::path Named(const std::filesystem::path& path, const std::optional<int64_t>& number) {
    return number ? Numbered(path, *number) : path;
}

}  // namespace

CommandFiles FilesOf(const RenderArguments& arguments) {
    if (!arguments.frames) return FilesOf(arguments, {});
    CommandFiles files;
    for (uint32_t frame = 0; frame < arguments.frames->Count(); ++frame) {
        const CommandFiles its = FilesOf(arguments, arguments.frames->NumberOf(frame));
        files.inputs = its.inputs;
        files.outputs.insert(files.outputs.end(), its.outputs.begin(), its.outputs.end());
    }
    return files;
}

CommandFiles FilesOf(const RenderArguments& arguments, const std::optional<int64_t>& number) {
    Paths outputs;
    if (!arguments.report.empty()) outputs.push_back(Named(arguments.report, number));
    // Anything but a render in place of the resumed one would destroy it
    Paths renders;
    for (const OutputFile& picture : PicturesOf(arguments, number)) {
        outputs.push_back(picture.path);
        if (picture.kind == OutputKind::Exr) renders.push_back(picture.path);
    }
    return {.inputs = Given({arguments.scene, arguments.environment}),
            .updated = Given({arguments.resume}),
            .outputs = std::move(outputs),
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
            .outputs = Given({arguments.output, arguments.report}),
            .replacing = {arguments.output}};
}

CommandFiles FilesOf(const EditArguments& arguments) {
    return {.inputs = Given({arguments.scene, arguments.environment, arguments.script}),
            .updated = {},
            .outputs = {},
            .replacing = {}};
}

void CheckWritable(const CommandFiles& files) {
    CheckWritable(files.outputs, files.inputs);
    if (files.updated.empty()) return;
    Paths others = files.outputs;
    std::erase_if(others, [&](const std::filesystem::path& output) {
        return std::ranges::find(files.replacing, output) != files.replacing.end();
    });
    CheckWritable(others, files.updated);
}

std::vector<OutputFile> PicturesOf(const RenderArguments& arguments, const std::optional<int64_t>& number) {
    std::vector<OutputFile> pictures = arguments.outputs;
    if (pictures.empty() && arguments.frames)
        pictures = {ParseOutput(kDefaultFrames)};
    else if (pictures.empty())
        pictures = {ParseOutput(arguments.resume.empty() ? kDefaultPicture : arguments.resume)};
    for (OutputFile& picture : pictures) picture.path = Named(picture.path, number);
    return pictures;
}

}  // namespace raygraph::cli
