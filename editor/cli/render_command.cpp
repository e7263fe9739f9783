// raygraph render: from the command line to the files.
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/os/process.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "editor/cli/command_files.h"
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/device_setup.h"
#include "editor/cli/render_report.h"
#include "editor/cli/render_session.h"
#include "editor/cli/resume.h"
#include "editor/cli/version.h"

namespace raygraph::cli {

namespace {

constexpr uint32_t kDefaultSamples = 64;

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
    for (const Bias bias : kBiases)
        if (IsOn(settings.paths.biases, bias) && settings.view != View::RayCost)
            refuse("only path-traced renders know " + Option(bias));
    if (settings.view == View::Raster) {
        if (arguments.error) refuse("give --spp; --error is for path-traced renders");
        return;
    }
    if (!IsMeanMeaningful(settings.view) &&
        (arguments.seconds || arguments.error || arguments.samples.value_or(1) > 1))
        refuse("it is not averaged over samples; leave out --spp, --time and --error");
    if (arguments.error) refuse("only light has an error to estimate");
    if (WritesKind(arguments, OutputKind::Hdr)) refuse("an .hdr holds radiance; write an .exr");
    if (arguments.exposureEv != 0.0f) refuse("there is no light that --exposure could scale");
}

Job PlanJob(const RenderArguments& arguments) {
    Job job;
    if (!arguments.resume.empty()) {
        job.resumed = ReadResumedRender(arguments.resume);
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
    if (!job.aovs.IsEmpty() && !WritesKind(arguments, OutputKind::Exr))
        throw Error(ErrorKind::Usage,
                    "--aov: its channels are written to an .exr, and there is no -o OUT.exr");
    if (!job.settings.lightGroups.empty() && !WritesKind(arguments, OutputKind::Exr))
        throw Error(ErrorKind::Usage,
                    "--light-group: its channels are written to an .exr, and there is no -o OUT.exr");
    const bool isSingle = !IsMeanMeaningful(job.settings.view);
    const bool isOpenEnded = arguments.seconds || (arguments.error && !arguments.samples);
    if (!isOpenEnded) job.samplesWanted = isSingle ? 1 : arguments.samples.value_or(kDefaultSamples);
    const uint64_t last = uint64_t{job.firstSample} + job.samplesWanted.value_or(1) - 1;
    if (last > std::numeric_limits<uint32_t>::max())
        throw MakeError(ErrorKind::Usage, "--sample-offset {}: sample {} is beyond the last, 4294967295",
                        job.firstSample, last);
    return job;
}

// The render as it will be written, but for the pictures.
RenderFile DescribeRender(const Job& job, const SceneInput& input, const rhi::DeviceInfo& device) {
    RenderFile render;
    render.size = job.settings.size;
    render.settings = Texts(job.settings);
    render.sceneFile = input.file;
    render.sceneHash = input.hash;
    render.environmentFile = input.environmentFile;
    render.environmentHash = input.environmentHash;
    render.version = kVersion;
    render.device = device.name;
    render.driver = device.driver;
    return render;
}

void RequireSameInputs(const ResumedRender& resumed, const RenderFile& render) {
    const std::string mismatch = FirstMismatch(resumed.render, render);
    if (!mismatch.empty())
        throw MakeError(ErrorKind::BadInput, "{} cannot be resumed: {}", resumed.path.string(), mismatch);
}

void WarnOfDarkness(ProgramLog& log, const Job& job, const SceneInput& input) {
    if (!ShowsLight(job.settings.view)) return;
    const bool hasPunctual = !input.data.lights.empty();
    if (job.settings.view == View::PathTraced && hasPunctual && !job.settings.paths.lights.isOn)
        log.Warn(input.file + ": --nee off finds no punctual light; they are not rendered");
    const bool hasBackground = job.settings.background != std::array<float, 3>{};
    if (!hasBackground && input.environmentFile.empty() && !scene::HasEmission(input.data) && !hasPunctual)
        log.Warn(input.file +
                 ": nothing emits light, the picture will be black; give --env FILE or "
                 "--background R,G,B");
}

// How the samples went.
struct Rendered {
    double seconds = 0.0;             // all samples of this run
    double firstSampleSeconds = 0.0;  // of these, until the first was done
    bool wasStopped = false;
};

ProgressState StateOf(RenderSession& session, const Job& job, const Rendered& soFar, double seconds,
                      const std::optional<double>& timeLimit) {
    ProgressState state;
    state.samplesDone = session.SamplesDone();
    state.samplesWanted = job.samplesWanted;
    const double timed = seconds - soFar.firstSampleSeconds;
    const double fresh = static_cast<double>(state.samplesDone) - job.samplesBefore - 1.0;
    if (fresh > 0.0 && timed > 0.0) {
        const double rate = fresh / timed;
        state.samplesPerSecond = rate * static_cast<double>(job.settings.size.PixelCount());
        if (job.samplesWanted) state.secondsLeft = (*job.samplesWanted - state.samplesDone) / rate;
    }
    if (timeLimit) state.secondsLeft = std::max(0.0, *timeLimit - seconds);
    state.relativeError = session.RelativeError();
    return state;
}

// Says after how many samples the relative error will be at the one that is wanted. The number depends on
// the samples' own variance: that biases the picture, by an amount that falls with their number, so no
// render stops before kLeast.
class ErrorGoal {
  public:
    explicit ErrorGoal(const std::optional<double>& wanted) : m_wanted(wanted) {}

    bool IsMeasuringAt(uint32_t samples) const {
        return m_wanted && samples >= kLeast && (std::has_single_bit(samples) || samples == m_needed);
    }
    void Measured(uint32_t samples, const std::optional<double>& error) {
        if (!error) return;
        const double needed = std::ceil(samples * (*error / *m_wanted) * (*error / *m_wanted));
        m_needed = static_cast<uint32_t>(std::clamp(needed, double{kLeast}, 4294967294.0));
    }
    bool IsReachedAt(uint32_t samples) const { return m_needed > 0 && samples >= m_needed; }

  private:
    static constexpr uint32_t kLeast = 64;
    std::optional<double> m_wanted;
    uint32_t m_needed = 0;  // 0: not known yet
};

Rendered RenderSamples(RenderSession& session, const Job& job, const RenderArguments& arguments,
                       Progress& progress) {
    const std::optional<double>& timeLimit = arguments.seconds;
    ErrorGoal goal(arguments.error);
    const os::InterruptWatch interrupt;
    const Stopwatch watch;
    Rendered rendered;
    progress.Show("  building acceleration structures, compiling shaders");
    for (bool isLast = false; !isLast;) {
        const uint32_t samples = session.SamplesSubmitted() + 1;  // with this one
        const bool isStopped = interrupt.IsRequested();
        const bool isComplete = job.samplesWanted && samples >= *job.samplesWanted;
        const bool isLate = timeLimit && watch.Seconds() >= *timeLimit;
        isLast = isComplete || isStopped || isLate || goal.IsReachedAt(samples) ||
                 job.firstSample + samples == 0;  // no index left
        const bool isMeasuring = goal.IsMeasuringAt(samples) && !isLast;
        session.RenderSample(isLast, isMeasuring || (progress.IsOn() && std::has_single_bit(samples)));
        if (isMeasuring) {
            session.WaitForSamples();
            goal.Measured(samples, session.RelativeError());
        }
        if (samples == job.samplesBefore + 1) {
            session.WaitForSamples();
            rendered.firstSampleSeconds = watch.Seconds();
        }
        rendered.wasStopped = isStopped && !isComplete;
        if (progress.IsDue())
            progress.Show(FormatProgress(StateOf(session, job, rendered, watch.Seconds(), timeLimit)));
    }
    session.WaitForSamples();
    rendered.seconds = watch.Seconds();
    progress.Clear();
    return rendered;
}

// Before WriteOutputs drops what was not asked for. None of a bias for which no sample was traced twice.
std::map<Bias, RemovedLight> RemovedOf(const RenderFile& render) {
    std::map<Bias, RemovedLight> all;
    for (const Bias bias : kBiases) {
        const size_t i = static_cast<size_t>(bias);
        if (!render.removed[i].empty() && render.removedSamples > 0)
            all[bias] = MeasureRemoved(render.removed[i], render.removedVariance[i], render.removedSamples,
                                       render.radiance);
    }
    return all;
}

void WriteOutputs(const RenderArguments& arguments, RenderSession& session, RenderFile& render,
                  const AovSet& aovs) {
    const image::Image8 display =
        WritesKind(arguments, OutputKind::Png) ? session.TakeDisplay(render) : image::Image8{};
    KeepOnly(render, aovs);
    for (const OutputFile& output : arguments.outputs) {
        switch (output.kind) {
            case OutputKind::Png:
                image::WritePng(output.path, display);
                break;
            case OutputKind::Exr:
                WriteRenderFile(output.path, render);
                break;
            case OutputKind::Hdr:
                image::WriteHdr(output.path, {render.size.width, render.size.height, render.radiance});
                break;
        }
    }
}

void PrintSummary(const RenderArguments& arguments, const RenderFile& render, const Job& job,
                  const Rendered& rendered, const std::optional<double>& samplesPerSecond,
                  const ImageStatistics& statistics, const std::map<Bias, RemovedLight>& removed) {
    for (const OutputFile& output : arguments.outputs) PrintLine(output.path.string());
    if (!arguments.report.empty()) PrintLine(arguments.report.string());
    const uint64_t samples = SampleCount(render.samples);
    std::string line = Text("{} {} a pixel", samples, samples == 1 ? "sample" : "samples");
    if (job.samplesBefore > 0) line += Text(", {} of them new", samples - job.samplesBefore);
    line += ", " + ToText(render.size) + ", in " + DurationText(rendered.seconds);
    if (samplesPerSecond) line += ", " + FormatRate(*samplesPerSecond);
    if (arguments.error && statistics.relativeError)
        line += ", relative error " + ToText(static_cast<float>(*statistics.relativeError));
    for (const auto& [bias, light] : removed) line += ", " + Describe(bias, light);
    PrintLine(line + ", on " + render.device);
}

}  // namespace

void RenderCommand(RenderArguments arguments, Console& console) {
    arguments.outputs = PicturesOf(arguments);
    // Before anything else: an hour of rendering must not end in a file that cannot be written
    CheckWritable(FilesOf(arguments));
    Job job = PlanJob(arguments);

    Progress& progress = console.progress;
    const Log log = console.log.ForLibraries();
    SceneInput input = LoadInput(arguments.scene, job.settings.scene, arguments.environment, log,
                                 [&](std::string_view stage, float fraction) {
                                     if (progress.IsDue()) progress.Show(FormatLoading(stage, fraction));
                                 });
    WarnOfDarkness(console.log, job, input);
    const std::unique_ptr<rhi::Device> device = OpenDevice({arguments.device, arguments.isValidating}, log);
    RenderFile render = DescribeRender(job, input, device->Info());
    if (job.resumed) RequireSameInputs(*job.resumed, render);

    DeviceScene scene(*device, input, job.settings);
    RenderSession session(
        scene, {.view = job.settings.view,
                .aovs = job.aovs,
                .lightGroupCount = static_cast<uint32_t>(LightGroupNames(job.settings.lightGroups).size()),
                .withVariance = WritesKind(arguments, OutputKind::Exr) || !arguments.report.empty() ||
                                progress.IsOn() || arguments.error.has_value(),
                .withSums = WritesKind(arguments, OutputKind::Exr),
                .firstSample = job.firstSample,
                .raster = job.settings.raster,
                .tonemap = {.exposureEv = arguments.exposureEv, .tonemapOperator = arguments.tonemap},
                .continues = job.resumed ? &job.resumed->render : nullptr});
    job.resumed.reset();
    const Rendered rendered = RenderSamples(session, job, arguments, progress);
    session.TakePicture(render);

    const ImageStatistics statistics =
        Measure(render.radiance, render.variance, static_cast<uint32_t>(SampleCount(render.samples)));
    const uint32_t fresh = session.SamplesSubmitted() - job.samplesBefore;
    const double timedSeconds = rendered.seconds - rendered.firstSampleSeconds;
    std::optional<double> samplesPerSecond;
    if (fresh > 1)
        samplesPerSecond = (fresh - 1) * static_cast<double>(render.size.PixelCount()) / timedSeconds;
    const std::map<Bias, RemovedLight> removed = RemovedOf(render);
    std::optional<Report> report;
    if (!arguments.report.empty()) {
        report = DescribeRun({.device = *device, .scene = scene, .session = session, .input = input});
        report->settings = SettingsForReport(arguments, render, job.samplesWanted);
        report->samples = SampleCount(render.samples);
        report->wasStopped = rendered.wasStopped;
        report->timingsMs.firstSample = 1e3 * rendered.firstSampleSeconds;
        report->timingsMs.render = 1e3 * rendered.seconds;
        report->throughput.samplesPerSecond = samplesPerSecond;
        report->image = statistics;
        report->nonFiniteSamples = session.NonFiniteSamples();
        report->removed = removed;
    }
    console.log.RequireValid();  // before anything is written: an invalid run leaves the old files

    WriteOutputs(arguments, session, render, job.aovs);
    if (report) WriteTextFile(arguments.report, ToJson(*report));
    if (rendered.wasStopped) {
        std::string text = Text("stopped after {}", session.SamplesSubmitted());
        if (job.samplesWanted) text += Text(" of {}", *job.samplesWanted);
        console.log.Warn(text + " samples; what there is was written");
    }
    if (const uint64_t count = session.NonFiniteSamples(); count > 0)
        console.log.Warn(Text("{} {} infinite or NaN, and counted as black", count,
                              count == 1 ? "sample was" : "samples were"));
    if (arguments.isQuiet) return;
    PrintSummary(arguments, render, job, rendered, samplesPerSecond, statistics, removed);
}

}  // namespace raygraph::cli
