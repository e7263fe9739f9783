// raygraph render: from the command line to the files.
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/os/process.h"
#include "base/text.h"
#include "editor/cli/bias_text.h"
#include "editor/cli/command_files.h"
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/device_setup.h"
#include "editor/cli/render_job.h"
#include "editor/cli/render_report.h"
#include "editor/session/parse.h"

namespace raygraph::cli {

namespace {

void WarnOfDarkness(ProgramLog& log, const RenderJob& job, const SceneInput& input) {
    if (!ShowsLight(job.settings.view)) return;
    if (input.isAnimated && !input.animations.empty()) return;  // what is dark at rest may shine
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

// The pictures of one frame, all to be written as they are named.
void WritePictures(std::span<const OutputFile> pictures, const Session& session, const RenderFile& render,
                   const Log& log) {
    for (const OutputFile& picture : pictures) {
        switch (picture.kind) {
            case OutputKind::Png:
                image::WritePng(picture.path, session.Display());
                break;
            case OutputKind::Exr:
                WriteRenderFile(picture.path, render, log);
                break;
            case OutputKind::Hdr:
                image::WriteHdr(picture.path, {render.size.width, render.size.height, render.radiance});
                break;
        }
    }
}

std::string SummaryOf(const RenderArguments& arguments, const SessionResult& result, const RenderJob& job,
                      const RunSummary& run) {
    const RenderFile& render = result.render;
    const uint64_t samples = SampleCount(render.samples);
    std::string line = Text("{} {} a pixel", samples, samples == 1 ? "sample" : "samples");
    if (job.samplesBefore > 0) line += Text(", {} of them new", samples - job.samplesBefore);
    line += ", " + ToText(render.size) + ", in " + DurationText(run.seconds);
    if (run.samplesPerSecond) line += ", " + FormatRate(*run.samplesPerSecond);
    if (arguments.error && result.statistics.relativeError)
        line += ", relative error " + ToText(static_cast<float>(*result.statistics.relativeError));
    for (const auto& [bias, light] : result.removed) line += ", " + Describe(bias, light);
    return line + ", on " + render.device;
}

// Renders pictures of one session and writes their files.
class Rendering {
  public:
    Rendering(const RenderArguments& arguments, const RenderJob& job, const rhi::Device& device,
              Session& session, Console& console)
        : m_arguments(arguments), m_job(job), m_device(device), m_session(session), m_console(console) {}

    // One picture; with a number in its files' names, if it is one of several.
    void RenderPicture(const std::optional<int64_t>& number, const std::string& label) {
        const std::vector<OutputFile> pictures = PicturesOf(m_arguments, number);
        const RunSummary run = Run(label);
        if (!m_session.HasResult())
            throw MakeError(ErrorKind::Io,
                            "{}: stopped while its albedo and normals were restored; nothing was written",
                            m_arguments.resume.string());
        const SessionResult result = m_session.Result();
        m_console.progress.ShowSamples(label, {.samplesDone = m_session.SampleCount(),
                                               .samplesWanted = m_job.samplesWanted,
                                               .samplesPerSecond = run.samplesPerSecond.value_or(0.0),
                                               .relativeError = result.statistics.relativeError,
                                               .secondsLeft = 0.0});
        m_console.progress.Clear();
        std::optional<Report> report;
        if (!m_arguments.report.empty()) {
            report = DescribeRun(m_device, m_session, result, run);
            report->settings = SettingsForReport(m_arguments, result.render, m_job.samplesWanted);
        }
        m_console.log.RequireValid();  // before anything is written: an invalid run leaves the old files

        WritePictures(pictures, m_session, result.render, m_console.log.ForLibraries());
        const std::filesystem::path reportFile =
            number && report ? Numbered(m_arguments.report, *number) : m_arguments.report;
        if (report) WriteTextFile(reportFile, ToJson(*report));
        Warn(run);
        m_console.progress.ShowWritten(label, FilesOf(m_arguments, number).outputs);
        if (m_arguments.isQuiet) return;
        for (const OutputFile& picture : pictures) PrintLine(picture.path.string());
        if (report) PrintLine(reportFile.string());
        PrintLine(SummaryOf(m_arguments, result, m_job, run));
    }

    bool IsInterrupted() const { return m_interrupt.IsRequested(); }

  private:
    RunSummary Run(const std::string& label) {
        Progress& progress = m_console.progress;
        std::function<void(const ProgressState&)> showProgress;
        if (progress.IsOn())
            showProgress = [&](const ProgressState& state) { progress.ShowSamples(label, state); };
        return m_session.Run({.samples = m_job.samplesWanted,
                              .seconds = m_arguments.seconds,
                              .relativeError = m_arguments.error,
                              .isStopRequested = [&] { return m_interrupt.IsRequested(); }},
                             showProgress);
    }

    void Warn(const RunSummary& run) {
        if (run.wasStopped) {
            std::string text = Text("stopped after {}", m_session.SampleCount());
            if (m_job.samplesWanted) text += Text(" of {}", *m_job.samplesWanted);
            m_console.log.Warn(text + " samples; what there is was written");
        }
        if (const uint64_t count = m_session.NonFiniteSamples(); count > 0)
            m_console.log.Warn(Text("{} {} infinite or NaN, and counted as black", count,
                                    count == 1 ? "sample was" : "samples were"));
    }

    const RenderArguments& m_arguments;
    const RenderJob& m_job;
    const rhi::Device& m_device;
    Session& m_session;
    Console& m_console;
    os::InterruptWatch m_interrupt;
};

// Each in the scene that is on the device already.
void RenderFrames(const FrameRange& frames, Session& session, Rendering& rendering, ProgramLog& log) {
    const uint32_t count = frames.Count();
    for (uint32_t frame = 0; frame < count; ++frame) {
        if (frame > 0) session.StartPicture(frames.TimeOf(frame));
        const std::string label = Text("  frame {} of {}", frame + 1, count);
        rendering.RenderPicture(frames.NumberOf(frame), label);
        if (!rendering.IsInterrupted()) continue;
        if (frame + 1 < count) log.Warn(Text("{} of {} frames were not begun", count - frame - 1, count));
        return;
    }
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
    RenderJob job = PlanJob(arguments, log);

    Progress& progress = console.progress;
    SceneInput input = LoadInput(arguments.scene, {.scene = job.settings.scene,
                                                   .variant = job.settings.variant,
                                                   .isAnimated = job.settings.at.has_value(),
                                                   .clips = job.settings.clips,
                                                   .pointsAndLines = job.settings.pointsAndLines,
                                                   .environment = arguments.environment,
                                                   .log = log,
                                                   .progress = [&](std::string_view stage, float fraction) {
                                                       progress.ShowLoading(stage, fraction);
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

    progress.ShowStep("building acceleration structures, compiling shaders");
    Rendering rendering(arguments, job, *device, session, console);
    if (arguments.frames)
        RenderFrames(*arguments.frames, session, rendering, console.log);
    else
        rendering.RenderPicture({}, "");
}

}  // namespace raygraph::cli
