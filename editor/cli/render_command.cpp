// raygraph render: from the command line to the files.
#include <algorithm>
#include <limits>

#include "base/os/process.h"
#include "base/text.h"
#include "editor/cli/bias_text.h"
#include "editor/cli/command_files.h"
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/device_setup.h"
#include "editor/cli/render_report.h"
#include "editor/cli/resume_settings.h"
#include "editor/session/parse.h"
#include "editor/session/setting_table.h"

namespace raygraph::cli {

namespace {

// What is to be rendered, after the command line and a resumed file have been brought together.
struct Job {
    PictureSettings settings;
    AovSet aovs;
    uint32_t firstSample = 0;
    uint32_t samplesBefore = 0;             // of a resumed render
    std::optional<uint32_t> samplesWanted;  // in all; none: until the time is up
    std::optional<ResumedRender> resumed;
};

bool WritesKind(const RenderArguments& arguments, OutputKind kind) {
    return std::ranges::any_of(arguments.outputs, [&](const OutputFile& o) { return o.kind == kind; });
}

// The option of the first setting that is not the same; "": all are.
std::string FirstOther(const PictureSettings& a, const PictureSettings& b) {
    for (const PictureSetting& setting : PictureSettingTable())
        if (setting.text(a) != setting.text(b)) return std::string("--") + setting.name;
    return "";
}

// Views other than the path-traced one have no use for some options and outputs: they are refused, not
// ignored.
void CheckView(const RenderArguments& arguments, const PictureSettings& settings) {
    const auto refuse = [&](const std::string& what) {
        throw MakeError(ErrorKind::Usage, "--view {}: {}", Name(settings.view), what);
    };
    if (settings.view != View::Raster && settings.raster.shadows != passes::RasterSettings{}.shadows)
        refuse("--shadows is for --view raster");
    if (settings.view == View::PathTraced) return;
    if (!arguments.resume.empty()) refuse("only path-traced renders are resumed");
    if (!settings.lightGroups.empty()) refuse("only path-traced renders have light for --light-group");
    if (settings.view != View::RayCost) {
        // The settings that the view has
        PictureSettings its = settings;
        its.paths = {.sampler = settings.paths.sampler, .seed = settings.paths.seed};
        its.aperture = PictureSettings{}.aperture;  // they see through a pinhole
        its.focusDistance = PictureSettings{}.focusDistance;
        if (settings.view == View::Raster) its.paths.scattering = settings.paths.scattering;
        if (const std::string option = FirstOther(its, settings); !option.empty())
            refuse("only path-traced renders know " + option);
        if (!ShowsLight(settings.view)) {
            its.environmentRotation = PictureSettings{}.environmentRotation;
            its.environmentTint = PictureSettings{}.environmentTint;
            its.background = PictureSettings{}.background;
            if (!arguments.environment.empty()) refuse("there is no light that --env could give");
            if (const std::string option = FirstOther(its, settings); !option.empty())
                refuse("there is no light for " + option);
        }
    }
    if (settings.view == View::Raster) {
        if (arguments.error) refuse("give --spp; --error is for path-traced renders");
        return;
    }
    if (!IsMeanMeaningful(settings.view) &&
        (arguments.seconds || arguments.error || arguments.samples.value_or(1) > 1))
        refuse("it is not averaged over samples; leave out --spp, --time and --error");
    if (arguments.error) refuse("only light has an error to estimate");
    if (WritesKind(arguments, OutputKind::Hdr)) refuse("an .hdr holds radiance; write an .exr");
    if (arguments.exposureEv) refuse("there is no light that --exposure could scale");
    if (arguments.tonemap) refuse("there is no light that --tonemap could map");
}

// Channels that were asked for, or that the resumed file has, are not dropped without a word.
void RequireExrForChannels(const RenderArguments& arguments, const Job& job) {
    if (WritesKind(arguments, OutputKind::Exr)) return;
    const auto refuse = [&](const char* option, const std::string& ofFile) {
        throw MakeError(ErrorKind::Usage, "{} are written to an .exr, and there is no -o OUT.exr",
                        job.resumed ? job.resumed->path.string() + ": its channels of " + ofFile
                                    : std::string(option) + ": its channels");
    };
    if (!job.aovs.IsEmpty()) refuse("--aov", ListOf(job.aovs));
    if (!job.settings.lightGroups.empty()) refuse("--light-group", "groups of lights");
}

Job PlanJob(const RenderArguments& arguments, const Log& log) {
    Job job;
    if (!arguments.resume.empty()) {
        job.resumed = ReadResumedRender(arguments.resume, log);
        const RenderFile& render = job.resumed->render;
        job.settings = SettingsOf(*job.resumed, arguments);
        job.aovs = AovsOf(render);
        job.firstSample = render.samples.front().first;
        job.samplesBefore = render.samples.front().count;
    } else {
        job.settings = SettingsFrom(arguments.given);
        if (arguments.aovs) job.aovs = AovsFor(*arguments.aovs, job.settings);
        job.firstSample = arguments.sampleOffset.value_or(0);
    }
    CheckView(arguments, job.settings);
    RequireExrForChannels(arguments, job);
    const bool isSingle = !IsMeanMeaningful(job.settings.view);
    const bool isOpenEnded = arguments.seconds || (arguments.error && !arguments.samples);
    if (!isOpenEnded)
        job.samplesWanted = isSingle ? 1 : arguments.samples.value_or(RenderArguments::kDefaultSamples);
    const uint64_t last = uint64_t{job.firstSample} + job.samplesWanted.value_or(1) - 1;
    if (last > std::numeric_limits<uint32_t>::max())
        throw MakeError(ErrorKind::Usage, "--sample-offset {}: sample {} is beyond the last, 4294967295",
                        job.firstSample, last);
    return job;
}

void WarnOfDarkness(ProgramLog& log, const Job& job, const SceneInput& input) {
    if (!ShowsLight(job.settings.view)) return;
    const bool hasPunctual = scene::HasVisibleLight(input.data);
    if (job.settings.view == View::PathTraced && hasPunctual && !job.settings.paths.lights.isOn)
        log.Warn(input.file + ": --nee off finds no punctual light; they are not rendered");
    const auto& background = job.settings.background;
    const bool hasSky =
        background ? *background != std::array<float, 3>{} : input.data.environment.IsPresent();
    if (!hasSky && input.environmentFile.empty() && !scene::HasEmission(input.data) && !hasPunctual)
        log.Warn(input.file +
                 ": nothing emits light, the picture will be black; give --env FILE or "
                 "--background R,G,B");
}

void WriteOutputs(const RenderArguments& arguments, const Session& session, const RenderFile& render,
                  const Log& log) {
    for (const OutputFile& output : arguments.outputs) {
        switch (output.kind) {
            case OutputKind::Png:
                image::WritePng(output.path, session.Display());
                break;
            case OutputKind::Exr:
                WriteRenderFile(output.path, render, log);
                break;
            case OutputKind::Hdr:
                image::WriteHdr(output.path, {render.size.width, render.size.height, render.radiance});
                break;
        }
    }
}

void PrintSummary(const RenderArguments& arguments, const SessionResult& result, const Job& job,
                  const RunSummary& run) {
    for (const OutputFile& output : arguments.outputs) PrintLine(output.path.string());
    if (!arguments.report.empty()) PrintLine(arguments.report.string());
    const RenderFile& render = result.render;
    const uint64_t samples = SampleCount(render.samples);
    std::string line = Text("{} {} a pixel", samples, samples == 1 ? "sample" : "samples");
    if (job.samplesBefore > 0) line += Text(", {} of them new", samples - job.samplesBefore);
    line += ", " + ToText(render.size) + ", in " + DurationText(run.seconds);
    if (run.samplesPerSecond) line += ", " + FormatRate(*run.samplesPerSecond);
    if (arguments.error && result.statistics.relativeError)
        line += ", relative error " + ToText(static_cast<float>(*result.statistics.relativeError));
    for (const auto& [bias, light] : result.removed) line += ", " + Describe(bias, light);
    PrintLine(line + ", on " + render.device);
}

}  // namespace

void RequireMapFor(const SettingTexts& given, const SceneInput& input) {
    if (!input.environmentFile.empty() || input.data.environment.IsPresent()) return;
    for (const char* option : {"env-rotation", "env-tint"})
        if (given.contains(option))
            throw MakeError(ErrorKind::Usage, "--{} is of a map: it needs --env; {} has none", option,
                            input.file);
}

void RenderCommand(RenderArguments arguments, Console& console) {
    arguments.outputs = PicturesOf(arguments);
    // Before anything else: an hour of rendering must not end in a file that cannot be written
    CheckWritable(FilesOf(arguments));
    const Log log = console.log.ForLibraries();
    Job job = PlanJob(arguments, log);

    Progress& progress = console.progress;
    SceneInput input = LoadInput(arguments.scene, {.scene = job.settings.scene,
                                                   .variant = job.settings.variant,
                                                   .at = job.settings.at,
                                                   .clips = job.settings.clips,
                                                   .pointsAndLines = job.settings.pointsAndLines,
                                                   .environment = arguments.environment,
                                                   .log = log,
                                                   .progress = [&](std::string_view stage, float fraction) {
                                                       if (progress.IsDue())
                                                           progress.Show(FormatLoading(stage, fraction));
                                                   }});
    if (!job.resumed) RequireMapFor(arguments.given, input);
    WarnOfDarkness(console.log, job, input);
    const std::unique_ptr<rhi::Device> device = OpenDevice({arguments.device, arguments.isValidating}, log);
    const bool hasExr = WritesKind(arguments, OutputKind::Exr);
    Session session(*device, std::move(input),
                    {.settings = job.settings,
                     .aovs = job.aovs,
                     .firstSample = job.firstSample,
                     .withVariance = hasExr || !arguments.report.empty() || progress.IsOn() ||
                                     arguments.error.has_value(),
                     .withSums = hasExr,
                     .tonemap = DisplayOf(arguments),
                     .resumed = job.resumed ? &*job.resumed : nullptr});
    job.resumed.reset();

    progress.Show("  building acceleration structures, compiling shaders");
    const os::InterruptWatch interrupt;
    std::function<void(const ProgressState&)> showProgress;
    if (progress.IsOn())
        showProgress = [&](const ProgressState& state) {
            if (progress.IsDue()) progress.Show(FormatProgress(state));
        };
    const RunSummary run = session.Run({.samples = job.samplesWanted,
                                        .seconds = arguments.seconds,
                                        .relativeError = arguments.error,
                                        .isStopRequested = [&] { return interrupt.IsRequested(); }},
                                       showProgress);
    progress.Clear();
    if (!session.HasResult())
        throw MakeError(ErrorKind::Io,
                        "{}: stopped while its albedo and normals were restored; nothing was written",
                        arguments.resume.string());

    const SessionResult result = session.Result();
    std::optional<Report> report;
    if (!arguments.report.empty()) {
        report = DescribeRun(*device, session, result, run);
        report->settings = SettingsForReport(arguments, result.render, job.samplesWanted);
    }
    console.log.RequireValid();  // before anything is written: an invalid run leaves the old files

    WriteOutputs(arguments, session, result.render, log);
    if (report) WriteTextFile(arguments.report, ToJson(*report));
    if (run.wasStopped) {
        std::string text = Text("stopped after {}", session.SampleCount());
        if (job.samplesWanted) text += Text(" of {}", *job.samplesWanted);
        console.log.Warn(text + " samples; what there is was written");
    }
    if (const uint64_t count = session.NonFiniteSamples(); count > 0)
        console.log.Warn(Text("{} {} infinite or NaN, and counted as black", count,
                              count == 1 ? "sample was" : "samples were"));
    if (arguments.isQuiet) return;
    PrintSummary(arguments, result, job, run);
}

}  // namespace raygraph::cli
