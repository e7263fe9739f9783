// Implements `raygraph render`: from the command line to the files.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/files.h"
#include "base/os.h"
#include "base/printable.h"
#include "base/text.h"
#include "editor/cli/command_files.h"
#include "editor/cli/commands.h"
#include "editor/cli/console.h"
#include "editor/cli/device_setup.h"
#include "editor/cli/rendering.h"
#include "editor/session/settings/light_settings.h"
#include "editor/session/settings/parse.h"
#include "renderer/image/exr.h"

namespace raygraph::cli {

namespace {

void WarnIfUnlit(ProgramLog& log, const RenderJob& job, const SceneInput& input) {
    if (!ShowsLight(job.settings.view)) return;
    if (input.isAnimated && !input.animations.empty())
        return;  // a scene that is dark at rest may emit at another time
    const bool hasPunctual = scene::HasVisibleLight(input.data);
    if (job.settings.view == View::PathTraced && hasPunctual && !job.settings.paths.lights.isOn)
        log.Warn(input.file + ": --nee off finds no punctual light; they are not rendered");
    const auto& background = job.settings.background;
    const bool hasSky =
        background ? *background != std::array<float, 3>{}
                   : input.data.environment.IsPresent() || job.settings.light == DefaultLight::Studio;
    if (!hasSky && input.environmentFile.empty() && !scene::HasEmission(input.data) && !hasPunctual)
        log.Warn(
            Text("{}: nothing emits light, the picture will be black; give --light studio, --env FILE or "
                 "{}--background R,G,B",
                 input.file, background ? "another " : ""));
}

// Renders the pictures one after another with the scene that is on the devices already.
class Pictures {
  public:
    Pictures(const RenderArguments& arguments, RenderJob& job, Console& console, ProcessGroup* group)
        : m_arguments(arguments),
          m_job(job),
          m_console(console),
          m_group(group),
          m_planned(PicturesToRender(arguments)) {}

    // Goes to the next incomplete picture; returns false if there is none. `resumed` is the render it
    // continues.
    bool FindNext() {
        for (; m_next < m_planned.size(); ++m_next) {
            m_resumed.reset();
            bool isComplete = false;
            if (IsRoot()) {
                m_resumed = m_next == 0
                                ? std::move(m_job.resumed)
                                : ResumedFor(m_arguments, Current().name, m_console.log.ForLibraries());
                isComplete = m_arguments.checkpointMinutes && m_resumed &&
                             IsComplete(m_resumed->render,
                                        {.samples = m_job.samplesWanted, .relativeError = m_job.error}) &&
                             HasAllFiles();
            }
            if (m_group != nullptr) m_group->Broadcast(std::as_writable_bytes(std::span(&isComplete, 1)));
            if (!isComplete) return true;
            if (!IsRoot()) continue;
            RequireSameRequest(*m_resumed, m_arguments, m_job, Current());
            ReportComplete();
        }
        return false;
    }
    const PlannedPicture& Current() const { return m_planned[m_next]; }
    const ResumedRender* Resumed() const { return m_resumed ? &*m_resumed : nullptr; }
    void ReleaseResumed() { m_resumed.reset(); }
    void Take() { ++m_next; }
    size_t Left() const { return m_planned.size() - m_next; }
    size_t Count() const { return m_planned.size(); }

  private:
    bool IsRoot() const { return m_group == nullptr || m_group->IsRoot(); }
    // The render is written before all other files. One that is older, or that was not asked for then, has
    // fewer samples; an empty one has none, and a device or a pipe stores nothing.
    bool HasAllFiles() const {
        const auto writtenAt = [](const std::filesystem::path& file) {
            std::error_code error;
            const bool hasContent =
                !AtomicFile::IsStream(file) && std::filesystem::file_size(file, error) > 0 && !error;
            const auto time = std::filesystem::last_write_time(file, error);
            return hasContent && !error ? time : std::filesystem::file_time_type::min();
        };
        const std::vector<std::filesystem::path> outputs = FilesOf(m_arguments, Current().name).outputs;
        return std::ranges::all_of(outputs, [&](const std::filesystem::path& output) {
            return writtenAt(output) >= writtenAt(m_resumed->path);
        });
    }
    void ReportComplete() const {
        if (!m_arguments.isQuiet)
            PrintLine(Text("{} is complete: {} a pixel", m_resumed->path,
                           Counted(SampleCount(m_resumed->render.samples), "sample")));
    }

    const RenderArguments& m_arguments;
    RenderJob& m_job;
    Console& m_console;
    ProcessGroup* m_group;
    std::vector<PlannedPicture> m_planned;
    size_t m_next = 0;
    std::optional<ResumedRender> m_resumed;
};

std::optional<passes::BackdropSettings> BackdropFor(const RenderArguments& arguments,
                                                    const PictureSettings& settings,
                                                    const SceneInput& input) {
    std::optional<passes::BackdropSettings> chosen = BackdropOf(arguments, settings);
    const bool hasMap = !input.environment.rgba.empty() ||
                        (!settings.background &&
                         (settings.light == DefaultLight::Studio || input.data.environment.IsPresent()));
    if (chosen && !chosen->color && chosen->blurDegrees > 0.0f && !hasMap)
        throw MakeError(ErrorKind::Usage,
                        "--backdrop blur: {} has no map to blur; it needs --env or --light studio",
                        input.file);
    return chosen;
}

// The root plans the job, and sends it to the others.
RenderJob SharedJob(const RenderArguments& arguments, Console& console, ProcessGroup* group) {
    const Log log = console.log.ForLibraries();
    if (group == nullptr) return PlanJob(arguments, log);
    RenderJob job;
    std::string text;
    if (group->IsRoot()) {
        CheckWritable(FilesOf(arguments), console.log.ForLibraries());
        job = PlanJob(arguments, log);
        text = JobText(job);
    }
    uint64_t size = group->Sum(text.size());
    text.resize(size);
    group->Broadcast(std::as_writable_bytes(std::span(text)));
    return group->IsRoot() ? std::move(job) : JobFrom(text);
}

}  // namespace

void RequireMapFor(const SettingTexts& given, const SceneInput& input, DefaultLight light,
                   const char* needs) {
    if (!input.environmentFile.empty() || input.data.environment.IsPresent()) return;
    if (light == DefaultLight::Studio) return;
    for (const char* option : {"env-rotation", "env-tint"})
        if (given.contains(option))
            throw MakeError(ErrorKind::Usage, "--{} is of a map: it needs {}; {} has none", option, needs,
                            input.file);
}

ExitCode RenderCommand(RenderArguments arguments, Console& console, ProcessGroup* group) {
    // Until there is a sample, ending at once loses nothing
    os::SignalWatch signals([] { std::_Exit(static_cast<int>(ExitCode::TryAgain)); });
    // A shard without samples or frames is no failure: the others have them all
    if (const std::string why = NothingToRenderReason(arguments); !why.empty()) {
        if (!arguments.isQuiet) PrintLine(why + "; nothing is written");
        return ExitCode::Done;
    }
    arguments.outputs = PicturesOf(arguments);
    if (group != nullptr && !arguments.denoise) arguments.denoise = false;  // processes cannot do it together
    // Check this first: an hour of rendering must not end in a file that cannot be written
    if (group == nullptr) CheckWritable(FilesOf(arguments), console.log.ForLibraries());
    const Log log = console.log.ForLibraries();
    RenderJob job = SharedJob(arguments, console, group);
    Pictures pictures(arguments, job, console, group);
    if (!pictures.FindNext()) return ExitCode::Done;
    PictureSettings& settings = job.settings;
    if (pictures.Current().at) settings.at = pictures.Current().at;
    if (pictures.Current().camera) settings.camera = *pictures.Current().camera;

    // A driver takes a third of a second to make a device, longer than most scenes take to load
    std::future<std::vector<std::unique_ptr<rhi::Device>>> opening = std::async(
        std::launch::async | std::launch::deferred, [&] { return OpenDevices(arguments, group, log); });
    Progress& progress = console.progress;
    std::optional<image::ExrThreads> threads(std::in_place);
    InputOptions options = InputOptionsFor(settings);
    options.root = arguments.root;
    options.environment = arguments.environment;
    options.log = log;
    options.progress = [&](std::string_view stage, float fraction) { progress.ShowLoading(stage, fraction); };
    SceneInput input = LoadInput(arguments.scene, options);
    threads.reset();
    settings.light = ChooseLight(input, settings, pictures.Resumed(), group);
    if (settings.light == DefaultLight::Studio)
        WriteLog(log, LogLevel::Info, log_category::kScene, "{} is lit by the studio", input.file);
    if (pictures.Resumed() == nullptr)
        RequireMapFor(arguments.given, input, settings.light, "--env or --light studio");
    WarnIfUnlit(console.log, job, input);
    const std::optional<passes::BackdropSettings> backdrop = BackdropFor(arguments, settings, input);
    std::vector<std::unique_ptr<rhi::Device>> devices = opening.get();
    std::vector<rhi::Device*> used;
    for (const auto& device : devices) used.push_back(device.get());
    const bool hasExr = WritesKind(arguments, OutputKind::Exr);
    const passes::TonemapSettings display = DisplayFor(arguments, settings, input);
    std::optional<Session> session;
    session.emplace(
        used, std::move(input),
        SessionDesc{
            .settings = settings,
            .aovs = job.aovs,
            .firstSample = job.firstSample,
            .withVariance = hasExr || !arguments.report.empty() || progress.IsOn() || job.error.has_value() ||
                            group != nullptr || settings.isAdaptive || job.isDenoised,
            .withSums = hasExr && arguments.exrType != ExrType::Half,
            .isDenoised = job.isDenoised,
            .denoiser = static_cast<passes::Denoiser>(arguments.denoiser.value_or(FileDenoiser::Network)),
            .tonemap = display,
            .backdrop = backdrop,
            .resumed = pictures.Resumed(),
            .tracing = arguments.tracing,
            .group = group});
    // An hour of rendering must not end in a camera that is not there, either
    for (const std::string& camera : arguments.cameras) session->RequireCamera(camera);
    progress.ShowStep("building acceleration structures, compiling shaders");
    pictures.ReleaseResumed();

    Rendering rendering(arguments, job, used, *session, signals, console, group);
    const auto renderCurrent = [&] {
        std::function<void()> giveBack;
        if (pictures.Left() == 1 && !arguments.isContactSheet)
            giveBack = [&] {
                session.reset();
                devices.clear();
            };
        rendering.RenderPicture(pictures.Current(), giveBack);
    };
    renderCurrent();
    for (pictures.Take(); !rendering.IsStopRequested() && pictures.FindNext(); pictures.Take()) {
        const PlannedPicture& picture = pictures.Current();
        session->StartPicture({.at = picture.at, .camera = picture.camera, .resumed = pictures.Resumed()});
        pictures.ReleaseResumed();
        renderCurrent();
    }
    if (arguments.isContactSheet && (group == nullptr || group->IsRoot())) rendering.WriteContactSheet();
    if (rendering.IsStopped() && pictures.Left() > 0)
        console.log.Warn(Text("{} of {} pictures were not begun", pictures.Left(), pictures.Count()));
    const bool isUnfinished = rendering.IsIncomplete() || pictures.Left() > 0;
    if (rendering.IsTerminated() && isUnfinished && rendering.IsSaved()) return ExitCode::TryAgain;
    return rendering.Result();
}

}  // namespace raygraph::cli
