#include "editor/cli/command_files.h"

#include <set>

#include "editor/cli/outputs.h"
#include "editor/cli/program_log.h"

namespace raygraph::cli {

namespace {

using Paths = std::vector<std::filesystem::path>;

Paths NonEmpty(Paths paths) {
    std::erase(paths, std::filesystem::path());
    return paths;
}

}  // namespace

CommandFiles FilesOf(const RenderArguments& arguments) {
    CommandFiles files;
    const auto append = [](Paths& to, const Paths& from) { to.insert(to.end(), from.begin(), from.end()); };
    if (arguments.isContactSheet) return FilesOf(arguments, PictureName{});
    for (const PlannedPicture& picture : PicturesToRender(arguments)) {
        const CommandFiles pictureFiles = FilesOf(arguments, picture.name);
        files.inputs = pictureFiles.inputs;
        append(files.updated, pictureFiles.updated);
        append(files.outputs, pictureFiles.outputs);
        append(files.replacing, pictureFiles.replacing);
    }
    return files;
}

CommandFiles FilesOf(const RenderArguments& arguments, const PictureName& name) {
    Paths outputs;
    if (!arguments.report.empty()) outputs.push_back(Named(arguments.report, name));
    // Only a render may replace the resumed one: another picture would destroy it
    Paths renders;
    for (const OutputFile& picture : PicturesOf(arguments, name)) {
        outputs.push_back(picture.path);
        if (picture.kind == OutputKind::Exr) renders.push_back(picture.path);
    }
    return {
        .inputs = NonEmpty({arguments.scene, arguments.environment, arguments.settingsFrom}),
        .updated = NonEmpty({arguments.resume.empty() ? Paths::value_type() : Named(arguments.resume, name)}),
        .outputs = std::move(outputs),
        .replacing = std::move(renders)};
}

CommandFiles FilesOf(const BenchArguments& arguments) {
    return {.inputs = NonEmpty({arguments.scene, arguments.environment}),
            .updated = NonEmpty({arguments.compare}),
            .outputs = NonEmpty({arguments.json}),
            .replacing = {}};
}

CommandFiles FilesOf(const InfoArguments& arguments) {
    return {.inputs = NonEmpty({arguments.scene}), .updated = {}, .outputs = {}, .replacing = {}};
}

CommandFiles FilesOf(const GraphArguments& arguments) {
    return {.inputs = {arguments.scene}, .updated = {}, .outputs = {}, .replacing = {}};
}

CommandFiles FilesOf(const GraphRunArguments& arguments) {
    return {.inputs = {arguments.description}, .updated = {}, .outputs = {}, .replacing = {}};
}

CommandFiles FilesOf(const ExplainArguments& arguments) {
    return {.inputs = NonEmpty({arguments.scene, arguments.environment, arguments.settingsFrom}),
            .updated = {},
            .outputs = NonEmpty({arguments.noiseMap, arguments.groupMap}),
            .replacing = {}};
}

CommandFiles FilesOf(const MergeArguments& arguments) {
    return {.inputs = {},
            .updated = arguments.inputs,
            .outputs = NonEmpty({arguments.output, arguments.report}),
            .replacing = {arguments.output}};
}

CommandFiles FilesOf(const DenoiseArguments& arguments) {
    CommandFiles files{.inputs = {}, .updated = {arguments.input}, .outputs = {}, .replacing = {}};
    for (const OutputFile& output : arguments.outputs) {
        files.outputs.push_back(output.path);
        if (output.kind == OutputKind::Exr) files.replacing.push_back(output.path);
    }
    return files;
}

CommandFiles FilesOf(const CompareArguments& arguments) {
    Paths outputs;
    for (const OutputFile& output : arguments.outputs) outputs.push_back(output.path);
    outputs.push_back(arguments.json);
    return {.inputs = NonEmpty({arguments.reference, arguments.picture}),
            .updated = {},
            .outputs = NonEmpty(std::move(outputs)),
            .replacing = {}};
}

CommandFiles FilesOf(const VerifyArguments& arguments) {
    Paths inputs = arguments.only.pictures;
    for (const auto& path :
         {arguments.only.scene, arguments.only.environment, arguments.only.mask, arguments.suite})
        inputs.push_back(path);
    return {.inputs = NonEmpty(std::move(inputs)),
            .updated = {},
            .outputs = NonEmpty({arguments.json, arguments.html}),
            .replacing = {}};
}

CommandFiles FilesOf(const EditArguments& arguments) {
    return {.inputs = NonEmpty({arguments.scene, arguments.environment, arguments.script}),
            .updated = {},
            .outputs = {},
            .replacing = {}};
}

void CheckWritable(const CommandFiles& files, const Log& log) {
    for (const std::string& warning : CheckOutputs(files.outputs, files.inputs))
        log.Send(LogLevel::Warning, kProgramCategory, warning);
    if (files.updated.empty()) return;
    const std::set<std::filesystem::path> replacing(files.replacing.begin(), files.replacing.end());
    Paths others = files.outputs;
    std::erase_if(others, [&](const std::filesystem::path& output) { return replacing.contains(output); });
    CheckOutputs(others, files.updated);
}

std::vector<OutputFile> PicturesOf(const RenderArguments& arguments, const PictureName& name) {
    std::vector<OutputFile> pictures = arguments.outputs;
    if (pictures.empty() && !arguments.resume.empty())
        pictures = {ParseOutput(arguments.resume)};
    else if (pictures.empty())
        pictures = {ParseOutput((arguments.frames || arguments.turntable) && !arguments.isContactSheet
                                    ? kDefaultFrames
                                    : kDefaultPicture)};
    for (OutputFile& picture : pictures) picture.path = Named(picture.path, name);
    return pictures;
}

}  // namespace raygraph::cli
