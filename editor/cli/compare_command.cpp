// Implements `raygraph compare`.
#include <memory>

#include "base/files.h"
#include "base/text.h"
#include "editor/cli/command_files.h"
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/device_setup.h"
#include "editor/cli/difference_report.h"
#include "editor/cli/outputs.h"
#include "editor/cli/report.h"
#include "editor/session/file/sample_ranges.h"
#include "editor/session/verify/difference.h"
#include "renderer/image/exr.h"

namespace raygraph::cli {

namespace {

void WriteDifference(const std::filesystem::path& path, const Picture& reference, const Picture& picture,
                     const PictureDifference& difference) {
    Texels minus = picture.radiance;
    for (size_t i = 0; i < minus.size(); ++i) minus[i] -= reference.radiance[i];
    const std::vector<float> stops = StopsBetween(reference.radiance, picture.radiance, 1e-6f);
    const std::span<const float> all(minus);
    const image::ExrPlane planes[] = {
        {.name = "R", .samples = all, .stride = 4},
        {.name = "G", .samples = all.subspan(1), .stride = 4},
        {.name = "B", .samples = all.subspan(2), .stride = 4},
        {.name = "stops", .samples = std::span<const float>(stops)},
        {.name = "flip", .samples = std::span<const float>(difference.flipMap)}};
    image::WriteExr(path, picture.size.width, picture.size.height, planes);
}

// Returns whether both files are renders that share samples of one seed, so that they have the same noise.
bool ShareSamples(const CompareArguments& arguments) {
    for (const std::filesystem::path& file : {arguments.reference, arguments.picture})
        if (LowerExtension(file) != ".exr") return false;
    try {
        const RenderFile a = ReadRenderFile(arguments.reference), b = ReadRenderFile(arguments.picture);
        return SettingsFrom(a.settings).paths.seed == SettingsFrom(b.settings).paths.seed &&
               session::Overlap(a.samples, b.samples);
    } catch (const Error&) {
        return false;  // it is of another renderer
    }
}

}  // namespace

ExitCode CompareCommand(const CompareArguments& arguments, Console& console) {
    const Log log = console.log.ForLibraries();
    CheckWritable(FilesOf(arguments), log);
    const image::ExrThreads threads;
    const Picture reference = ReadPicture(arguments.reference, arguments.transfer, log),
                  picture = ReadPicture(arguments.picture, arguments.transfer, log);
    const std::unique_ptr<rhi::Device> device = OpenDevice({arguments.device, arguments.isValidating}, log);
    Renderer renderer(*device);
    PictureDifference difference = Difference(renderer, reference, picture, arguments.transfer.exposureEv);
    if (!reference.variance.empty() && !picture.variance.empty() && ShareSamples(arguments)) {
        difference.z.reset();
        console.log.Warn(
            "both pictures have samples of the same seed, and so the same noise, with which their difference "
            "cannot "
            "be compared: render one with another --seed");
    }
    OutputWriter outputs([&](const auto&, std::string_view why) { console.log.Fail(why); });
    for (const OutputFile& output : arguments.outputs)
        outputs.Add(output.path, [&] {
            if (output.kind == OutputKind::Png)
                image::WritePng(output.path, ShowHeat(renderer, difference.flipMap, picture.size, 1.0f));
            else
                WriteDifference(output.path, reference, picture, difference);
        });
    if (!arguments.json.empty())
        outputs.Add(arguments.json,
                    [&] { WriteTextFile(arguments.json, CompareJson(reference, picture, difference)); });
    console.log.RequireValid();
    outputs.WriteAll();
    std::string text = DescribeDifference(difference);
    text.pop_back();
    PrintLine(text);
    return outputs.Result();
}

}  // namespace raygraph::cli
