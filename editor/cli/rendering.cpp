#include "editor/cli/rendering.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>
#include <vector>

#include "base/files.h"
#include "base/os.h"
#include "base/printable.h"
#include "base/text.h"
#include "editor/cli/aov_request.h"
#include "editor/cli/command_files.h"
#include "editor/cli/contact_sheet.h"
#include "editor/cli/outputs.h"
#include "editor/cli/program_log.h"
#include "editor/cli/report.h"
#include "editor/cli/resume_settings.h"
#include "editor/session/settings/light_settings.h"
#include "editor/session/settings/parse.h"
#include "editor/session/settings/setting_table.h"
#include "passes/tonemap.h"
#include "renderer/image/exr.h"

namespace raygraph::cli {

namespace {

std::string SummaryOf(const RenderJob& job, const SessionResult& result, const RunSummary& run,
                      uint32_t samplesBefore, size_t deviceCount) {
    const RenderFile& render = result.render;
    const uint64_t samples = SampleCount(render.samples);
    std::string line = Counted(samples, "sample") + " a pixel";
    if (render.adaptive) {
        const auto [least, most] = std::ranges::minmax(render.adaptive->counts);
        line += Text(" on average ({} to {})", least, most);
    }
    if (samplesBefore > 0) line += Text(", {} of them new", samples - samplesBefore);
    line += ", " + session::ToText(render.size) + ", in " + DurationText(run.seconds);
    if (run.samplesPerSecond) line += ", " + FormatRate(*run.samplesPerSecond);
    if (job.error && result.statistics.relativeError)
        line += ", relative error " + session::ToText(static_cast<float>(*result.statistics.relativeError));
    for (const auto& [bias, light] : result.removed) line += ", " + Describe(bias, light);
    if (const auto light = render.settings.find(kLightSetting);
        light != render.settings.end() && light->second == Name(DefaultLight::Studio))
        line += ", lit by the studio";
    if (job.isDenoised) line += ", denoised";
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
    // Another process may have samples already
    if (m_group != nullptr) m_signals.StartDeferring();
}

void Rendering::RenderPicture(const PlannedPicture& picture, const std::function<void()>& giveBack) {
    const uint32_t before = m_session.SampleCount();
    m_sinceSave = {};
    m_notSaved.clear();
    const RunSummary run = Run(picture, before);
    m_signals.StartDeferring();  // also where no sample was wanted: files are written now
    if (m_group != nullptr) {
        // Nothing is written if any process had validation messages.
        if (!m_group->IsRoot()) m_console.log.RequireValid();
        m_group->Sum(0);
        if (!m_group->IsRoot()) {
            m_saved.insert(PicturesOf(m_arguments, picture.name)
                               .front()
                               .path);  // only the root knows whether this is true
            return;
        }
    }
    if (!m_session.HasResult() && m_isTerminated) {
        m_isIncomplete = true;
        m_saved.insert(Named(m_arguments.resume, picture.name));  // this file has all samples that there are
        m_console.log.Warn("stopped while albedo and normals were restored; nothing was written");
        return;
    }
    if (!m_session.HasResult())
        throw MakeError(ErrorKind::Io,
                        "{}: stopped while its albedo and normals were restored; nothing was written",
                        m_arguments.resume);
    if (m_arguments.isContactSheet)
        AddToSheet(run, before);
    else
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
                  .relativeError = m_job.error,
                  .isStopRequested =
                      [&] {
                          // Until there is a sample, compiling shaders may take long, and ending at once
                          // loses nothing
                          if (m_session.SampleCount() > samplesBefore) m_signals.StartDeferring();
                          return m_signals.IsInterrupted() || m_signals.IsTerminated();
                      },
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
        case OutputKind::Jpg:
            image::WriteJpeg(picture.path, *display);
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
    m_console.log.RequireValid();  // an invalid run keeps the old files

    OutputWriter outputs(
        [&](const std::filesystem::path& file, std::string_view why) { LogNotWritten(file, why, isEnd); });
    std::vector<OutputFile> pictures = PicturesOf(m_arguments, planned.name);
    std::vector<std::filesystem::path> files;  // in the order of the command line
    for (const OutputFile& picture : pictures) files.push_back(picture.path);
    const std::filesystem::path resumed =
        m_arguments.resume.empty() ? std::filesystem::path() : Named(m_arguments.resume, planned.name);
    std::optional<image::Image8> display;
    if (std::ranges::any_of(pictures, [](const OutputFile& o) { return IsDisplayed(o.kind); }))
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
        if (isStream && !isEnd) continue;  // the reader of a stream takes its first end for the end of all
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
            if (m_job.error) report.settings["error"] = session::ToText(static_cast<float>(*m_job.error));
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
                // Without a thread, all is freed at the end
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
            WriteLog(m_console.log.ForLibraries(), LogLevel::Info, kProgramCategory, "{}, {}", saved,
                     Counted(samples, "sample"));
        return;
    }
    if (m_result == ExitCode::Done) m_result = outputs.Result();
    if (m_arguments.isQuiet) return;
    for (const std::filesystem::path& file : files) PrintLine(file.string());
    PrintLine(SummaryOf(m_job, result, run, samplesBefore, m_devices.size()));
}

void Rendering::AddToSheet(const RunSummary& run, uint32_t samplesBefore) {
    const SessionResult result = m_session.Result();
    m_console.progress.Clear();
    m_sheet.push_back(m_session.Display());
    m_sheetSummary = SummaryOf(m_job, result, run, samplesBefore, m_devices.size());
    Warn(run, m_session.SampleCount(), m_session.NonFiniteSamples(), "");
}

void Rendering::WriteContactSheet() {
    if (m_sheet.empty()) return;
    m_console.log.RequireValid();
    const image::Image8 sheet = ContactSheet(m_sheet);
    OutputWriter outputs(
        [&](const std::filesystem::path& file, std::string_view why) { LogNotWritten(file, why, true); });
    const std::vector<OutputFile> pictures = PicturesOf(m_arguments);
    for (const OutputFile& picture : pictures)
        outputs.Add(picture.path, [&] { WritePicture(picture, {}, sheet); });
    outputs.WriteAll();
    m_result = outputs.Result();
    std::vector<std::filesystem::path> written;
    for (const OutputFile& picture : pictures)
        if (outputs.HasWritten(picture.path)) written.push_back(picture.path);
    m_saved.insert(written.begin(), written.end());
    if (!written.empty()) m_console.progress.ShowWritten("", written);
    if (m_arguments.isQuiet) return;
    for (const std::filesystem::path& file : written) PrintLine(file.string());
    PrintLine(Text("{}, {}x{}; the last: {}", Counted(m_sheet.size(), "picture"), sheet.width, sheet.height,
                   m_sheetSummary));
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

// --- Planning a job ---

namespace {

// Returns the option of the first setting that differs; "" if none does.
std::string FirstChangedOption(const PictureSettings& a, const PictureSettings& b) {
    for (const PictureSetting& setting : PictureSettingTable())
        if (setting.text(a) != setting.text(b)) return std::string("--") + setting.name;
    return "";
}

// Refuses options and outputs that views other than the path-traced one would ignore.
void CheckView(const RenderArguments& arguments, const PictureSettings& settings) {
    const auto refuse = [&](const std::string& what) {
        throw MakeError(ErrorKind::Usage, "--view {}: {}", Name(settings.view), what);
    };
    if (settings.view != View::Raster && settings.raster.shadows != passes::RasterSettings{}.shadows)
        refuse("--shadows is for --view raster");
    if (settings.crop && !CanCrop(settings.view))
        refuse("it is drawn as a whole; --crop is for views of rays");
    if (settings.view == View::PathTraced) return;
    if (settings.paths.isEnvironmentHidden) refuse("only path-traced renders know --transparent");
    if (settings.hasGround) refuse("only path-traced renders know --ground");
    if (!arguments.resume.empty()) refuse("only path-traced renders are resumed");
    if (!settings.lightGroups.empty()) refuse("only path-traced renders have light for --light-group");
    if (!passes::CountsPaths(settings.view)) {
        // These are the settings that the view uses
        PictureSettings its = settings;
        its.paths = {.sampler = settings.paths.sampler, .seed = settings.paths.seed};
        its.aperture = PictureSettings{}.aperture;  // these views have a pinhole camera
        its.focusDistance = PictureSettings{}.focusDistance;
        if (settings.view == View::Raster) its.paths.scattering = settings.paths.scattering;
        if (const std::string option = FirstChangedOption(its, settings); !option.empty())
            refuse("only path-traced renders know " + option);
        if (!ShowsLight(settings.view)) {
            its.environmentRotation = PictureSettings{}.environmentRotation;
            its.environmentTint = PictureSettings{}.environmentTint;
            its.background = PictureSettings{}.background;
            its.light = PictureSettings{}.light;
            if (!arguments.environment.empty()) refuse("there is no light that --env could give");
            if (const std::string option = FirstChangedOption(its, settings); !option.empty())
                refuse("there is no light for " + option);
        }
    }
    if (settings.view == View::Raster) {
        if (arguments.error) refuse("give --spp; --error is for path-traced renders");
        return;
    }
    if (!IsAverageable(settings.view) &&
        (arguments.seconds || arguments.error || arguments.samples.value_or(1) > 1))
        refuse("it is not averaged over samples; leave out --spp, --time and --error");
    if (arguments.error) refuse("only light has an error to estimate");
    if (WritesKind(arguments, OutputKind::Hdr)) refuse("an .hdr holds radiance; write an .exr");
    if (arguments.exposureEv) refuse("there is no light that --exposure could scale");
    if (arguments.tonemap) refuse("there is no light that --tonemap could map");
    if (arguments.whitePoint) refuse("there is no light that --white-point could balance");
}

// Refuses to drop channels that were asked for, or that the resumed file has.
void RequireExrForChannels(const RenderArguments& arguments, const RenderJob& job) {
    if (WritesKind(arguments, OutputKind::Exr)) return;
    const auto refuse = [&](const char* option, const std::string& ofFile) {
        throw MakeError(ErrorKind::Usage, "{} are written to an .exr, and there is no -o OUT.exr",
                        job.resumed ? Text("{}: its channels of {}", job.resumed->path, ofFile)
                                    : std::string(option) + ": its channels");
    };
    if (!job.aovs.IsEmpty()) refuse("--aov", ListOf(job.aovs));
    if (!job.settings.lightGroups.empty()) refuse("--light-group", "groups of lights");
}

}  // namespace

PictureSettings StoredSettings(const std::filesystem::path& file, const std::filesystem::path& scene,
                               const std::filesystem::path& environment, const SettingTexts& given,
                               const Log& log) {
    if (file.empty()) return {};
    const RenderFile render = ReadRenderFile(file, log);
    PictureSettings settings = SettingsFrom(render.settings);
    const bool replacesLighting = !environment.empty() || given.contains("background");
    if (!render.environmentFile.empty() && !replacesLighting)
        WriteLog(log, LogLevel::Warning, log_category::kScene,
                 "{} was lit by the map {}, which is no setting: --env gives one again", file,
                 Printable(render.environmentFile));
    // A given light replaces the stored one
    const auto light = given.find(kLightSetting);
    const bool isStudio = light != given.end() && light->second == Name(DefaultLight::Studio);
    if (!environment.empty() || isStudio) settings.background.reset();
    // The choice made for one scene does not hold for another
    if (replacesLighting || render.sceneFile != scene.filename().string())
        settings.light = DefaultLight::Auto;
    if (given.contains("background")) {
        settings.environmentRotation = PictureSettings{}.environmentRotation;
        settings.environmentTint = PictureSettings{}.environmentTint;
    }
    return settings;
}

passes::TonemapSettings DisplayFor(const RenderArguments& arguments, const PictureSettings& settings,
                                   const SceneInput& input) {
    passes::TonemapSettings display = DisplayOf(arguments);
    if (!arguments.whitePoint || arguments.whitePoint->kelvin) return display;
    const std::optional<glm::dvec3> light = LightColor(input, settings);
    if (!light)
        throw MakeError(ErrorKind::BadInput, "--white-point auto: {} has no light to take the color of",
                        Printable(input.file));
    display.whiteBalance = passes::WhiteBalance(passes::ChromaticityOf(*light));
    return display;
}

bool WritesKind(const RenderArguments& arguments, OutputKind kind) {
    return std::ranges::any_of(arguments.outputs, [&](const OutputFile& o) { return o.kind == kind; });
}

namespace {

void PlanSamples(const RenderArguments& arguments, RenderJob& job) {
    job.error = arguments.error;
    job.samplesWanted = arguments.samples;
    if (!IsAverageable(job.settings.view)) {
        job.samplesWanted = 1;
    } else if (!arguments.GivesSampling()) {
        const bool isShard = arguments.shard && !arguments.frames;
        job.samplesWanted = RenderArguments::kDefaultSamples;
        if (job.settings.view != View::PathTraced || isShard) return;
        // The error does not look at alpha, where the shadow on a ground is
        if (!job.settings.hasGround)
            job.error = job.isDenoised ? RenderArguments::kDenoisedError : RenderArguments::kCleanError;
        job.samplesWanted =
            job.isDenoised ? RenderArguments::kMostDenoisedSamples : RenderArguments::kMostSamples;
    }
}

}  // namespace

RenderJob PlanJob(const RenderArguments& arguments, const Log& log) {
    RenderJob job;
    const image::ExrThreads threads;
    const PlannedPicture first = PicturesToRender(arguments).front();
    job.resumed = ResumedFor(arguments, first.name, log);
    const bool rendersSeveral = arguments.frames || !arguments.cameras.empty();
    if (job.resumed && !rendersSeveral) {
        const RenderFile& render = job.resumed->render;
        job.settings = SettingsOf(*job.resumed, arguments);
        job.aovs = AovsOf(render);
        job.firstSample = render.samples.front().first;
    } else {
        // The session makes sure that each picture's render has these settings
        job.settings =
            SettingsFrom(arguments.given, StoredSettings(arguments.settingsFrom, arguments.scene,
                                                         arguments.environment, arguments.given, log));
        if (first.at) job.settings.at = first.at;
        if (arguments.aovs) job.aovs = AovsFor(*arguments.aovs, job.settings);
        job.firstSample = arguments.sampleOffset.value_or(0);
    }
    if (arguments.shard && !arguments.frames && job.settings.isAdaptive)
        throw Error(ErrorKind::Usage,
                    "--shard: an adaptive render decides by all of its samples which are next, so that there "
                    "is nothing to divide beforehand; leave out --adaptive or --shard");
    if (arguments.shard && !arguments.frames && !IsAverageable(job.settings.view))
        throw MakeError(ErrorKind::Usage,
                        "--shard: --view {} is not averaged over samples, so that there is nothing to divide",
                        Name(job.settings.view));
    CheckView(arguments, job.settings);
    const std::string notDenoised = NotDenoisedReason(job.settings);
    if (arguments.denoise == true && !notDenoised.empty())
        throw MakeError(ErrorKind::Usage, "--denoise: {}", notDenoised);
    const bool isShown =
        std::ranges::all_of(arguments.outputs, [](const OutputFile& o) { return IsDisplayed(o.kind); });
    job.isDenoised =
        arguments.denoise.value_or(isShown && !arguments.GivesSampling() && notDenoised.empty() &&
                                   arguments.resume.empty() && arguments.devices.empty());
    if (job.settings.paths.isEnvironmentHidden && !BackdropOf(arguments, job.settings) &&
        WritesKind(arguments, OutputKind::Jpg))
        throw Error(ErrorKind::Usage, "--transparent: a .jpg has no alpha; write a .png");
    RequireExrForChannels(arguments, job);
    PlanSamples(arguments, job);
    const uint64_t last = uint64_t{job.firstSample} + job.samplesWanted.value_or(1) - 1;
    if (last > std::numeric_limits<uint32_t>::max())
        throw MakeError(ErrorKind::Usage, "--sample-offset {}: sample {} is beyond the last, 4294967295",
                        job.firstSample, last);
    return job;
}

std::optional<ResumedRender> ResumedFor(const RenderArguments& arguments, const PictureName& name,
                                        const Log& log) {
    if (arguments.resume.empty()) return std::nullopt;
    const std::filesystem::path path = Named(arguments.resume, name);
    // Only a missing file counts: one that cannot be read now may be the last good one
    std::error_code error;
    if (arguments.checkpointMinutes &&
        std::filesystem::status(path, error).type() == std::filesystem::file_type::not_found)
        return std::nullopt;
    return ReadResumedRender(path, log);
}

void RequireSameRequest(const ResumedRender& complete, const RenderArguments& arguments, const RenderJob& job,
                        const PlannedPicture& picture) {
    const RenderFile& render = complete.render;
    const auto require = [&](bool isRequested, const std::string& difference) {
        if (!isRequested)
            throw MakeError(ErrorKind::BadInput,
                            "{} is complete, but another picture than the one that is asked for: {}",
                            complete.path, Printable(difference, 1024));
    };
    const auto names = [](const std::string& kept, const std::filesystem::path& asked) {
        const auto quoted = [](const std::string& name) { return name.empty() ? "none" : name; };
        return Text("{} against {}", quoted(kept), quoted(asked.filename().string()));
    };
    require(render.sceneFile == arguments.scene.filename().string(),
            "scene: " + names(render.sceneFile, arguments.scene));
    require(render.environmentFile == arguments.environment.filename().string(),
            "environment map: " + names(render.environmentFile, arguments.environment));
    SettingTexts asked = Texts(job.settings);
    if (picture.at) asked["at"] = AtText(picture.at);
    if (picture.camera) asked["camera"] = *picture.camera;
    const std::string difference = FirstDifference(render.settings, asked);
    require(difference.empty(), difference);
    const uint32_t first = render.samples.front().first;
    require(first == job.firstSample, Text("first sample: {} against {}", first, job.firstSample));
    require(AovsOf(render) == job.aovs, "its channels are those of other --aov");
}

std::string JobText(const RenderJob& job) {
    nlohmann::json json{{"settings", Texts(job.settings)}, {"first", job.firstSample}};
    json["aovs"] = nlohmann::json::array();
    for (const Aov aov : kAovs)
        if (job.aovs.Has(aov)) json["aovs"].push_back(Name(aov));
    if (job.samplesWanted) json["samples"] = *job.samplesWanted;
    if (job.error) json["error"] = *job.error;
    json["denoised"] = job.isDenoised;
    // CBOR takes names and patterns that are not valid UTF-8, which text may not hold
    const std::vector<uint8_t> bytes = nlohmann::json::to_cbor(json);
    return {bytes.begin(), bytes.end()};
}

RenderJob JobFrom(const std::string& text) {
    try {
        const nlohmann::json json = nlohmann::json::from_cbor(text);
        RenderJob job;
        job.settings = SettingsFrom(json.at("settings").get<SettingTexts>());
        for (const auto& name : json.at("aovs")) job.aovs.Set(ParseChoice<Aov>(name.get<std::string>()));
        job.firstSample = json.at("first").get<uint32_t>();
        if (json.contains("samples")) job.samplesWanted = json.at("samples").get<uint32_t>();
        if (json.contains("error")) job.error = json.at("error").get<double>();
        job.isDenoised = json.at("denoised").get<bool>();
        return job;
    } catch (const nlohmann::json::exception& error) {
        throw MakeError(ErrorKind::BadInput, "the render that is asked for cannot be read: {}", error.what());
    }
}

// --- The report of a render ---

namespace {

void DescribeScene(Report& report, const SceneInput& input) {
    const scene::SceneStatistics& statistics = input.statistics;
    report.scene = {.file = input.file,
                    .trianglesUnique = statistics.uniqueTriangles,
                    .trianglesPlaced = statistics.placedTriangles,
                    .pointsPlaced = statistics.placedSpheres,
                    .segmentsPlaced = statistics.placedCapsules,
                    .instances = statistics.instanceCount,
                    .materials = statistics.materialCount,
                    .textures = statistics.textureCount,
                    .lights = statistics.lightCount};
}

void DescribeAcceleration(Report& report, const GpuSceneStatistics& statistics) {
    report.acceleration = {.blasCount = statistics.blasCount,
                           .bytesBuilt = statistics.blasBytesBuilt,
                           .bytesCompacted = statistics.blasBytesCompacted,
                           .tlasBytes = statistics.tlasBytes,
                           .compactionDisabledReason = statistics.isCompactionOff
                                                           ? statistics.compactionDisabledReason
                                                           : std::string()};
}

}  // namespace

Report DescribeRun(std::span<rhi::Device* const> devices, Session& session, const SessionResult& result,
                   const RunSummary& run) {
    Report report;
    DescribeScene(report, session.Input());
    const rhi::Device& device = *devices.front();
    const rhi::DeviceInfo& info = device.Info();
    for (const rhi::Device* each : devices) report.devices.push_back(each->Info().name);
    report.device = {info.name, info.driver, Name(info.type)};

    const SessionStatistics statistics = session.Statistics();
    const auto totalMs = [&](std::string_view pass) {
        const auto time = std::ranges::find(statistics.passes, pass, &PassTime::name);
        return time == statistics.passes.end() ? 0.0 : time->gpuMsTotal;
    };
    report.passes = statistics.passes;
    report.samples = SampleCount(result.render.samples);
    if (const auto& adaptive = result.render.adaptive) {
        const auto [least, most] = std::ranges::minmax(adaptive->counts);
        report.samplesOfPixels = Report::SamplesOfPixels{least, most};
    }
    report.wasStopped = run.wasStopped;
    report.timingsMs = {.load = session.Input().loadMs,
                        .upload = statistics.scene.uploadMs,
                        .blasBuild = totalMs("BuildBlas"),
                        .compaction = totalMs("CompactBlas"),
                        .pipelines = statistics.pipelinesMs,
                        .firstSample = 1e3 * run.firstSampleSeconds,
                        .render = 1e3 * run.seconds};
    DescribeAcceleration(report, statistics.scene);

    report.throughput = {run.samplesPerSecond, session.RaysPerSample()};
    report.image = result.statistics;
    report.nonFiniteSamples = session.NonFiniteSamples();
    report.removed = result.removed;
    const rhi::MemoryStatistics memory = device.Memory();
    report.memory = {.devicePeakBytes = memory.peakBytes,
                     .hostPeakBytes = os::PeakResidentBytes(),
                     .deviceFallbackBytes = memory.fallbackBytes,
                     .isBudgetOfDriver = info.optional.memoryBudget,
                     .heaps = device.MemoryHeaps(),
                     .textureBytes = statistics.scene.textureBytes,
                     .textureBudgetBytes = statistics.scene.textureBudget,
                     .reducedTextures = statistics.scene.reducedTextures};
    return report;
}

}  // namespace raygraph::cli
