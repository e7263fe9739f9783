// Implements `raygraph verify`.
#include <memory>

#include "base/files.h"
#include "base/os.h"
#include "base/text.h"
#include "editor/cli/command_files.h"
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/device_setup.h"
#include "editor/cli/outputs.h"
#include "editor/cli/report.h"
#include "editor/cli/verify_report.h"
#include "editor/session/settings/light_settings.h"
#include "editor/session/verify/verify.h"
#include "renderer/image/exr.h"

namespace raygraph::cli {

ExitCode VerifyCommand(const VerifyArguments& arguments, Console& console) {
    const Log log = console.log.ForLibraries();
    CheckWritable(FilesOf(arguments), log);
    const image::ExrThreads threads;
    std::vector<VerifiedPicture> verified;
    for (const std::filesystem::path& path : arguments.pictures)
        verified.push_back({arguments.scene.string(), ReadPicture(path, arguments.transfer, log), {}});
    PictureSettings settings = SettingsFrom(arguments.given);
    if (!arguments.given.contains("size")) settings.size = verified.front().picture.size;
    const std::unique_ptr<rhi::Device> device = OpenDevice({arguments.device, arguments.isValidating}, log);
    Progress& progress = console.progress;
    SceneInput input = LoadInput(arguments.scene, {.scene = settings.scene,
                                                   .variant = settings.variant,
                                                   .isAnimated = settings.at.has_value(),
                                                   .clips = settings.clips,
                                                   .pointsAndLines = settings.pointsAndLines,
                                                   .root = arguments.root,
                                                   .environment = arguments.environment,
                                                   .log = log,
                                                   .progress = [&](std::string_view stage, float fraction) {
                                                       progress.ShowLoading(stage, fraction);
                                                   }});
    RequireMapFor(arguments.given, input, ChooseLight(input, settings), "--env or --light studio");
    const std::filesystem::path cache = CacheFolder();
    VerifyDesc desc{
        .settings = settings,
        .tolerance = arguments.tolerance,
        .maxSamples = arguments.maxSamples,
        .cache = arguments.isCached && !cache.empty() ? cache / "references" : std::filesystem::path(),
        .exposureEv = arguments.transfer.exposureEv,
        .log = log};
    if (progress.IsOn())
        desc.progress = [&](const ProgressState& state) { progress.ShowSamples("reference", state); };
    Verify verify(*device, std::move(input), std::move(desc));
    Renderer renderer(*device);  // of the page
    bool areRight = true;
    for (VerifiedPicture& picture : verified) {
        picture.result = verify.Check(picture.picture);
        areRight = areRight && picture.result.verdict.isRight;
        progress.Clear();
        if (!arguments.html.empty())
            picture.shown = ShowPictures(renderer, verify.Reference(), picture.picture,
                                         picture.result.verdict, arguments.transfer.exposureEv);
        if (!arguments.isQuiet) PrintLine(DescribeVerdict(picture));
    }
    console.log.RequireValid();
    OutputWriter outputs([&](const auto&, std::string_view why) { console.log.Fail(why); });
    if (!arguments.json.empty())
        outputs.Add(arguments.json, [&] { WriteTextFile(arguments.json, VerifyJson(verified)); });
    if (!arguments.html.empty())
        outputs.Add(arguments.html, [&] { WriteTextFile(arguments.html, VerifyHtml(verified)); });
    outputs.WriteAll();
    if (outputs.Result() != ExitCode::Done) return outputs.Result();
    return areRight ? ExitCode::Done : ExitCode::Differs;
}

}  // namespace raygraph::cli
