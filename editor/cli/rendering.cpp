#include "editor/cli/rendering.h"

#include <algorithm>
#include <system_error>
#include <thread>

#include "base/atomic_file.h"
#include "base/counted.h"
#include "base/path_text.h"
#include "base/text.h"
#include "editor/cli/bias_text.h"
#include "editor/cli/command_files.h"
#include "editor/cli/log_levels.h"
#include "editor/cli/output_writer.h"
#include "editor/cli/render_report.h"
#include "editor/session/settings/parse.h"
#include "renderer/image/exr_threads.h"

namespace raygraph::cli {

namespace {

std::string SummaryOf(const RenderArguments& arguments, const SessionResult& result, const RunSummary& run,
                      uint32_t samplesBefore, size_t deviceCount) {
    const RenderFile& render = result.render;
    const uint64_t samples = SampleCount(render.samples);
    std::string line = Counted(samples, "sample") + " a pixel";
    if (render.adaptive) {
        const auto [least, most] = std::ranges::minmax(render.adaptive->counts);
        line += Text(" on average ({} to {})", least, most);
    }
    if (samplesBefore > 0) line += Text(", {} of them new", samples - samplesBefore);
    line += ", " + ToText(render.size) + ", in " + DurationText(run.seconds);
    if (run.samplesPerSecond) line += ", " + FormatRate(*run.samplesPerSecond);
    if (arguments.error && result.statistics.relativeError)
        line += ", relative error " + ToText(static_cast<float>(*result.statistics.relativeError));
    for (const auto& [bias, light] : result.removed) line += ", " + Describe(bias, light);
    if (const auto light = render.settings.find(kLightSetting);
        light != render.settings.end() && light->second == Name(DefaultLight::Studio))
        line += ", lit by the studio";
    line += ", on " + render.device;
    return deviceCount > 1 ? line + Text(", {} devices", deviceCount) : line;
}

std::string Joined(const std::vector<std::filesystem::path>& files) {
    std::string list;
    for (const std::filesystem::path& file : files) list += Text("{}{}", list.empty() ? "" : ", ", file);
    return list;
}

// Returns the sum of two consecutive runs.
RunSummary Joined(const RunSummary& first, const RunSummary& second) {
    RunSummary joined = second;
    joined.firstSampleSeconds = first.firstSampleSeconds;
    joined.seconds += first.seconds;
    const double seconds = first.seconds - first.firstSampleSeconds;
    if (first.samplesPerSecond && second.samplesPerSecond)
        joined.samplesPerSecond =
            (*first.samplesPerSecond * seconds + *second.samplesPerSecond * second.seconds) /
            (seconds + second.seconds);
    else if (first.samplesPerSecond)
        joined.samplesPerSecond = first.samplesPerSecond;
    return joined;
}

}  // namespace

Rendering::Rendering(const RenderArguments& arguments, const RenderJob& job,
                     std::span<rhi::Device* const> devices, Session& session, os::SignalWatch& signals,
                     Console& console, ProcessGroup* group)
    : m_arguments(arguments),
      m_job(job),
      m_devices(devices),
      m_session(session),
      m_signals(signals),
      m_console(console),
      m_group(group) {
    m_signals.StartDeferring();
}

void Rendering::RenderPicture(const PlannedPicture& picture, const std::function<void()>& giveBack) {
    const uint32_t before = m_session.SampleCount();
    m_sinceSave = {};
    m_notSaved.clear();
    const RunSummary run = Run(picture, before);
    if (m_group != nullptr) {
        // Nothing is written if any process had validation messages.
        if (!m_group->IsRoot()) m_console.log.RequireValid();
        m_group->Sum(0);
        if (!m_group->IsRoot()) {
            m_saved.insert(PicturesOf(m_arguments, picture.name)
                               .front()
                               .path);  // Only the root knows whether this is true.
            return;
        }
    }
    if (!m_session.HasResult() && m_isTerminated) {
        m_isIncomplete = true;
        m_saved.insert(Named(m_arguments.resume, picture.name));  // This file has all samples that there are.
        m_console.log.Warn("stopped while albedo and normals were restored; nothing was written");
        return;
    }
    if (!m_session.HasResult())
        throw MakeError(ErrorKind::Io,
                        "{}: stopped while its albedo and normals were restored; nothing was written",
                        m_arguments.resume);
    Write(picture, run, before, true, giveBack);
}

bool Rendering::IsSaveDue() const {
    // Time is measured by one clock: that of the process that writes.
    const bool isTimed = m_arguments.checkpointMinutes && (m_group == nullptr || m_group->IsRoot());
    return m_signals.IsSaveRequested() ||
           (isTimed && m_sinceSave.Seconds() >= 60.0 * *m_arguments.checkpointMinutes);
}

bool Rendering::IsStopRequested() {
    SynchronizeSignals();
    return IsStopped();
}

void Rendering::SynchronizeSignals() {
    uint64_t interrupted = m_signals.IsInterrupted() ? 1 : 0, terminated = m_signals.IsTerminated() ? 1 : 0;
    if (m_group != nullptr) {
        interrupted = m_group->Sum(interrupted);
        terminated = m_group->Sum(terminated);
    }
    m_isInterrupted = interrupted > 0;
    m_isTerminated = terminated > 0;
}

RunSummary Rendering::Run(const PlannedPicture& picture, uint32_t samplesBefore) {
    Progress& progress = m_console.progress;
    std::function<void(const ProgressState&)> showProgress;
    if (progress.IsOn())
        showProgress = [&](const ProgressState& state) { progress.ShowSamples(picture.label, state); };
    StopRule rule{.samples = m_job.samplesWanted,
                  .seconds = m_arguments.seconds,
                  .relativeError = m_arguments.error,
                  .isStopRequested = [&] { return m_signals.IsInterrupted() || m_signals.IsTerminated(); },
                  .isPauseRequested = [&] { return IsSaveDue(); }};
    // A render whose samples are complete, but whose files are not, may have more samples than asked for now.
    if (rule.samples) rule.samples = std::max(*rule.samples, samplesBefore);
    RunSummary whole;
    for (bool isFirst = true;; isFirst = false) {
        const RunSummary run = m_session.Run(rule, showProgress);
        whole = isFirst ? run : Joined(whole, run);
        SynchronizeSignals();
        m_isIncomplete = run.wasStopped && IsStopped();
        if (!run.wasStopped || IsStopped()) return whole;
        m_signals.ClearSaveRequest();
        if (m_group == nullptr || m_group->IsRoot()) Write(picture, whole, samplesBefore, false);
        m_sinceSave = {};
        if (rule.seconds) rule.seconds = *rule.seconds - run.seconds;
    }
}

void Rendering::WritePicture(const OutputFile& picture, const RenderFile& render,
                             const std::optional<image::Image8>& display) {
    switch (picture.kind) {
        case OutputKind::Png:
            image::WritePng(picture.path, *display);
            break;
        case OutputKind::Exr:
            WriteRenderFile(picture.path, render, m_console.log.ForLibraries(),
                            m_arguments.exrType.value_or(ExrType::Float));
            break;
        case OutputKind::Hdr:
            image::WriteHdr(picture.path, {render.size.width, render.size.height, render.radiance});
            break;
    }
}

void Rendering::Write(const PlannedPicture& planned, const RunSummary& run, uint32_t samplesBefore,
                      bool isEnd, const std::function<void()>& giveBack) {
    const SessionResult result = m_session.Result();
    const uint32_t samples = m_session.SampleCount();
    const uint64_t nonFiniteSamples = m_session.NonFiniteSamples();
    Progress& progress = m_console.progress;
    if (isEnd) {
        progress.ShowSamples(planned.label, {.samplesDone = samples,
                                             .samplesWanted = m_job.samplesWanted,
                                             .samplesPerSecond = run.samplesPerSecond.value_or(0.0),
                                             .relativeError = result.statistics.relativeError,
                                             .secondsLeft = 0.0});
        progress.Clear();
    }
    m_console.log.RequireValid();  // An invalid run keeps the old files.

    OutputWriter outputs(
        [&](const std::filesystem::path& file, std::string_view why) { LogNotWritten(file, why, isEnd); });
    std::vector<OutputFile> pictures = PicturesOf(m_arguments, planned.name);
    std::vector<std::filesystem::path> files;  // in the order of the command line
    for (const OutputFile& picture : pictures) files.push_back(picture.path);
    const std::filesystem::path resumed =
        m_arguments.resume.empty() ? std::filesystem::path() : Named(m_arguments.resume, planned.name);
    std::optional<image::Image8> display;
    if (std::ranges::any_of(pictures, [](const OutputFile& o) { return o.kind == OutputKind::Png; }))
        display = m_session.Display();
    const bool hasNewSamples = samples > samplesBefore;
    // The render that can be resumed comes first.
    std::ranges::stable_sort(pictures, {}, [&](const OutputFile& picture) {
        if (picture.path == resumed) return 0;
        return picture.kind == OutputKind::Exr ? 1 : 2;
    });
    const bool isResumable = NotResumableReason(result.render).empty();
    std::vector<std::filesystem::path> toResume, others;
    for (const OutputFile& picture : pictures) {
        const bool isStream = AtomicFile::IsStream(picture.path);
        if (isStream && !isEnd) continue;  // The reader of a stream takes its first end for the end of all.
        const bool isResumeTarget = isResumable && !isStream && picture.kind == OutputKind::Exr;
        (isResumeTarget ? toResume : others).push_back(picture.path);
        outputs.Add(picture.path, [&] {
            if (hasNewSamples || picture.path != resumed) WritePicture(picture, result.render, display);
        });
    }
    if (!m_arguments.report.empty() && isEnd) {
        files.push_back(Named(m_arguments.report, planned.name));
        outputs.Add(files.back(), [&, file = files.back()] {
            Report report = DescribeRun(m_devices, m_session, result, run);
            report.settings = SettingsForReport(m_arguments, result.render, m_job.samplesWanted);
            WriteTextFile(file, ToJson(report));
        });
    }
    {
        // Drivers take a tenth of a second to free a device, which counts after a short render alone: a crash
        // of one must not cost a long one its files. A report still asks the device, and a group is left
        // together.
        constexpr double kShortSeconds = 10.0;
        std::jthread givingBack;
        if (giveBack && m_arguments.report.empty() && m_group == nullptr && run.seconds < kShortSeconds) try {
                givingBack = std::jthread(giveBack);
            } catch (const std::system_error&) {
                // There is no thread to be had: all is freed at the end
            }
        const image::ExrThreads threads;
        outputs.WriteAll();
    }
    for (const std::filesystem::path& file : files) {
        if (outputs.HasWritten(file)) m_notSaved.erase(file);
        if (outputs.IsTorn(file)) m_saved.erase(file);
    }
    const bool hasResumable = !toResume.empty();
    for (auto* list : {&files, &toResume, &others})
        std::erase_if(*list, [&](const std::filesystem::path& file) { return !outputs.HasWritten(file); });
    const std::vector<std::filesystem::path>& kept = hasResumable ? toResume : others;
    m_saved.insert(kept.begin(), kept.end());
    const std::string saved = toResume.empty() ? "" : "resumable .exr saved: " + Joined(toResume);
    if (isEnd)
        Warn(run, samples, nonFiniteSamples,
             saved.empty() && outputs.Result() == ExitCode::Done ? "what there is was written" : saved);
    if (!files.empty()) progress.ShowWritten(planned.label, files);
    if (!isEnd) {
        if (!saved.empty())
            Say(m_console.log.ForLibraries(), LogLevel::Info, kProgramCategory, "{}, {}", saved,
                Counted(samples, "sample"));
        return;
    }
    if (m_result == ExitCode::Done) m_result = outputs.Result();
    if (m_arguments.isQuiet) return;
    for (const std::filesystem::path& file : files) PrintLine(file.string());
    PrintLine(SummaryOf(m_arguments, result, run, samplesBefore, m_devices.size()));
}

void Rendering::LogNotWritten(const std::filesystem::path& file, std::string_view why, bool isEnd) {
    // A failed write may succeed the next time, so the samples are kept.
    std::string& known = m_notSaved[file];
    if (isEnd)
        m_console.log.Fail(why);
    else if (known != why)
        m_console.log.Warn(Text("not saved, rendering goes on: {}", why));
    known = why;
}

void Rendering::Warn(const RunSummary& run, uint32_t samples, uint64_t nonFiniteSamples,
                     const std::string& outcome) {
    if (run.wasStopped) {
        const std::string done = m_job.samplesWanted
                                     ? Text("{} of {}", samples, Counted(*m_job.samplesWanted, "sample"))
                                     : Counted(samples, "sample");
        m_console.log.Warn("stopped after " + done + (outcome.empty() ? "" : "; " + outcome));
    }
    if (nonFiniteSamples > 0)
        m_console.log.Warn(Counted(nonFiniteSamples, "sample was", "samples were") +
                           " infinite or NaN, and counted as black");
}

}  // namespace raygraph::cli
