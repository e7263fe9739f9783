#include "editor/session/session.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>

#include "base/printable.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "base/version.h"
#include "editor/session/device_scene.h"
#include "editor/session/render_flaws.h"
#include "editor/session/sample_frames.h"

namespace raygraph::session {

namespace {

// Says after how many samples the relative error will be at the one that is wanted. The number depends on
// the samples' own variance: that biases the picture, by an amount that falls with their number, so no
// render stops before kMin.
class ErrorGoal {
  public:
    explicit ErrorGoal(const std::optional<double>& wanted) : m_wanted(wanted) {}

    bool IsMeasuringAt(uint32_t samples) const {
        return m_wanted && samples >= kMin && std::has_single_bit(samples);
    }
    void Measured(uint32_t samples, const std::optional<double>& error, bool isBlack) {
        if (isBlack) m_needed = kMin;  // nothing says that there is light to be found
        if (!error) return;
        const double needed = std::ceil(samples * (*error / *m_wanted) * (*error / *m_wanted));
        m_needed = static_cast<uint32_t>(std::clamp(needed, double{kMin}, 4294967294.0));
    }
    bool IsReachedAt(uint32_t samples) const { return m_needed > 0 && samples >= m_needed; }

  private:
    static constexpr uint32_t kMin = 64;
    std::optional<double> m_wanted;
    uint32_t m_needed = 0;  // 0: not known yet
};

[[noreturn]] void Refuse(const std::string& why) {
    throw Error(ErrorKind::Usage, "Session: " + why);
}

void RequirePossible(const SessionDesc& desc) {
    const PictureSettings& settings = desc.settings;
    RequireReadable(settings);
    for (const Aov aov : kAovs)
        if (desc.aovs.Has(aov) && !CanHave(aov, settings))
            Refuse(Text("the view {} with these biases has no {}", Name(settings.view), Name(aov)));
    if (settings.shutter && !passes::IsMeanMeaningful(settings.view))
        throw SettingError(ErrorKind::Usage,
                           Text("shutter: the view {} is not averaged over samples, so nothing is blurred",
                                Name(settings.view)));
    if (settings.crop && !CanCrop(settings.view))
        throw SettingError(ErrorKind::Usage,
                           Text("crop: the view {} is drawn as a whole", Name(settings.view)));
    if (!settings.lightGroups.empty() && settings.view != View::PathTraced)
        Refuse(Text("the view {} has no light by groups", Name(settings.view)));
    if (desc.resumed == nullptr) return;
    RequireResumable(*desc.resumed);
    const RenderFile& render = desc.resumed->render;
    if (desc.firstSample != render.samples.front().first || desc.aovs != AovsOf(render))
        Refuse(Text("first sample and AOVs are not those of {}", desc.resumed->path.string()));
    if (!desc.withVariance) Refuse("a render is resumed with its variance");
}

// A file records one choice, and a picture of another scene under it could never be made again.
void RequireChoice(const char* setting, const char* unnamed, const std::string& asked,
                   const std::string& loaded, const SceneInput& input) {
    if (loaded == asked) return;
    const auto called = [&](const std::string& choice) { return choice.empty() ? unnamed : Quoted(choice); };
    throw SettingError(ErrorKind::Usage, Text("{}: {} of {} is to be rendered, but {} was loaded", setting,
                                              called(asked), Printable(input.file), called(loaded)));
}

void RequireScene(const SceneInput& input, const PictureSettings& settings) {
    RequireChoice("scene", "the default one", settings.scene, input.scene, input);
    RequireChoice("variant", "none", settings.variant, input.variant, input);
    if (settings.at && !input.isAnimated)
        throw SettingError(ErrorKind::Usage, Text("at: {} is a time, but {} was loaded without animations",
                                                  AtText(settings.at), Printable(input.file)));
    if (!settings.at && input.isAnimated)
        throw SettingError(ErrorKind::Usage, Text("at: no time is given, but {} was loaded with animations",
                                                  Printable(input.file)));
    if (!settings.at && !settings.clips.empty())
        throw SettingError(ErrorKind::Usage, "clips: animations play at a time, and none is given");
    if (!settings.at && settings.shutter)
        throw SettingError(ErrorKind::Usage, "shutter: it is around a time, and none is given");
    const auto requireRadius = [&](const char* setting, const scene::RoundRadius& asked,
                                   const scene::RoundRadius& loaded) {
        if (loaded != asked)
            throw SettingError(ErrorKind::Usage,
                               Text("{}: {} is to be rendered with {}, but was loaded with {}", setting,
                                    Printable(input.file), ToText(asked), ToText(loaded)));
    };
    requireRadius("points", settings.pointsAndLines.points, input.pointsAndLines.points);
    requireRadius("lines", settings.pointsAndLines.lines, input.pointsAndLines.lines);
}

FramePlan PlanOf(const SessionDesc& desc) {
    passes::TonemapSettings tonemap = desc.tonemap;
    tonemap.isUnassociated = desc.settings.paths.isEnvironmentHidden;
    tonemap.isOpaque = !tonemap.isUnassociated;
    return {.view = desc.settings.view,
            .aovs = desc.aovs,
            .lightGroupCount = static_cast<uint32_t>(LightGroupNames(desc.settings.lightGroups).size()),
            .withVariance = desc.withVariance,
            .withSums = desc.withSums,
            .firstSample = desc.firstSample,
            .raster = desc.settings.raster,
            .tonemap = tonemap,
            .continues = desc.resumed != nullptr ? &desc.resumed->render : nullptr};
}

// Before the AOVs that were not asked for are dropped.
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

}  // namespace

RenderFile DescribeRender(const SceneInput& input, const PictureSettings& settings,
                          const rhi::DeviceInfo& device) {
    RequireScene(input, settings);
    const Version version = LibraryVersion();
    RenderFile render;
    render.size = RenderedPart(settings).Extent();
    render.settings = Texts(settings);
    render.sceneFile = input.file;
    render.sceneHash = input.hash;
    render.environmentFile = input.environmentFile;
    render.environmentHash = input.environmentHash;
    render.version = Text("{}.{}.{}", version.major, version.minor, version.patch);
    render.device = device.name;
    render.driver = device.driver;
    return render;
}

SessionDesc Resuming(const ResumedRender& render) {
    RequireResumable(render);
    return {.settings = SettingsFrom(render.render.settings),
            .aovs = AovsOf(render.render),
            .firstSample = render.render.samples.front().first,
            .resumed = &render};
}

struct Session::Impl {
    Impl(rhi::Device& device, SceneInput&& of, const SessionDesc& desc)
        : input(std::move(of)),
          aovs(desc.aovs),
          firstSample(desc.firstSample),
          isSingle(!passes::IsMeanMeaningful(desc.settings.view)),
          withVariance(desc.withVariance),
          described(DescribeRender(input, desc.settings, device.Info())),
          scene(device, RequireSame(desc), desc.settings),
          plan(PlanOf(desc)) {
        frames = std::make_unique<SampleFrames>(scene, plan);
        plan.continues = nullptr;
    }

    // The input, if it is that of the resumed render.
    SceneInput& RequireSame(const SessionDesc& desc) {
        RequirePossible(desc);
        if (desc.resumed == nullptr) return input;
        const std::string mismatch = FirstMismatch(desc.resumed->render, described);
        if (!mismatch.empty())
            throw MakeError(ErrorKind::BadInput, "{} cannot be resumed: {}", desc.resumed->path.string(),
                            mismatch);
        return input;
    }
    void RequireRule(const StopRule& rule) const {
        if (!rule.samples && !rule.seconds && !rule.relativeError) Refuse("a run without an end");
        if (rule.relativeError && !(withVariance && frames->ShowsLight()))
            Refuse("there is no variance that an error could be estimated from");
        if (rule.relativeError && !(*rule.relativeError > 0.0))
            Refuse(Text("no render gets to a relative error of {}", *rule.relativeError));
        if (rule.seconds && !std::isfinite(*rule.seconds))
            Refuse(Text("a run of {} seconds has no end", *rule.seconds));
        const uint32_t before = frames->SamplesSubmitted();
        if (rule.samples && *rule.samples <= before)
            Refuse(Text("{} samples are asked for, and there are {}", *rule.samples, before));
        const uint64_t last = uint64_t{firstSample} + std::max(before + 1, rule.samples.value_or(1)) - 1;
        if (last > std::numeric_limits<uint32_t>::max())
            Refuse(Text("sample {} is beyond the last, 4294967295", last));
    }
    // Traces again what a resumed render has no sums of. False: a stop was requested first.
    bool RestoreSurfaces(const StopRule& rule, const std::function<void(const ProgressState&)>& progress) {
        const uint32_t count = frames->SamplesSubmitted();
        while (frames->SamplesToRestore() > 0) {
            if (rule.isStopRequested && rule.isStopRequested()) return false;
            frames->RestoreSample();
            if (!progress) continue;
            ProgressState state;
            state.samplesDone = count;
            state.samplesWanted = rule.samples;
            state.samplesRestored = count - frames->SamplesToRestore();
            progress(state);
        }
        return true;
    }
    ProgressState StateAt(const Stopwatch& watch, uint32_t before, const StopRule& rule,
                          const RunSummary& soFar) {
        const double seconds = watch.Seconds();
        ProgressState state;
        state.samplesDone = frames->SamplesDone();
        state.samplesWanted = rule.samples;
        const double timed = seconds - soFar.firstSampleSeconds;
        const double fresh = static_cast<double>(state.samplesDone) - before - 1.0;
        if (fresh > 0.0 && timed > 0.0) {
            const double rate = fresh / timed;
            state.samplesPerSecond = rate * static_cast<double>(PixelCount(described.size));
            if (rule.samples) state.secondsLeft = (*rule.samples - state.samplesDone) / rate;
        }
        if (rule.seconds)
            state.secondsLeft =
                std::min(std::max(0.0, *rule.seconds - seconds), state.secondsLeft.value_or(*rule.seconds));
        state.relativeError = frames->RelativeError();
        return state;
    }

    SceneInput input;
    AovSet aovs;
    uint32_t firstSample;
    bool isSingle, withVariance;
    RenderFile described;
    DeviceScene scene;
    FramePlan plan;
    std::unique_ptr<SampleFrames> frames;  // of the picture that is rendered
};

Session::Session(rhi::Device& device, SceneInput input, const SessionDesc& desc)
    : m_impl(std::make_unique<Impl>(device, std::move(input), desc)) {}

Session::~Session() = default;

RunSummary Session::Run(const StopRule& asked, const std::function<void(const ProgressState&)>& progress) {
    SampleFrames& frames = *m_impl->frames;
    StopRule rule = asked;
    if (m_impl->isSingle) rule.samples = 1;
    m_impl->RequireRule(rule);
    const uint32_t before = frames.SamplesSubmitted();
    ErrorGoal goal(rule.relativeError);
    RunSummary summary;
    if (!m_impl->RestoreSurfaces(rule, progress)) {
        summary.wasStopped = true;
        return summary;
    }
    const Stopwatch watch;
    for (bool isLast = false; !isLast;) {
        const uint32_t samples = frames.SamplesSubmitted() + 1;  // with this one
        const bool isStopped = rule.isStopRequested && rule.isStopRequested();
        const bool isComplete = rule.samples && samples >= *rule.samples;
        const bool isLate = rule.seconds && watch.Seconds() >= *rule.seconds;
        isLast = isComplete || isStopped || isLate || goal.IsReachedAt(samples) ||
                 m_impl->firstSample + samples == 0;  // no index left
        const bool isMeasuring = goal.IsMeasuringAt(samples) && !isLast;
        frames.RenderSample(isLast, isMeasuring || (progress && std::has_single_bit(samples)));
        if (isMeasuring) {
            frames.WaitForSamples();
            const std::optional<double> error = frames.RelativeError();
            goal.Measured(samples, error, frames.IsBlack());
        }
        if (samples == before + 1) {
            frames.WaitForSamples();
            summary.firstSampleSeconds = watch.Seconds();
        }
        summary.wasStopped = isStopped && !isComplete;
        if (progress) progress(m_impl->StateAt(watch, before, rule, summary));
    }
    frames.WaitForSamples();
    summary.seconds = watch.Seconds();
    if (const uint32_t fresh = frames.SamplesSubmitted() - before; fresh > 1)
        summary.samplesPerSecond = (fresh - 1) * static_cast<double>(PixelCount(m_impl->described.size)) /
                                   (summary.seconds - summary.firstSampleSeconds);
    return summary;
}

void Session::StartPicture(double at) {
    if (!m_impl->input.isAnimated) Refuse("a picture at another time, of a scene without one");
    PictureSettings checked;
    checked.at = at;
    RequireReadable(checked);
    m_impl->frames->WaitForSamples();
    std::ignore = m_impl->frames->Times();  // of the last picture
    auto frames = std::make_unique<SampleFrames>(m_impl->scene, m_impl->plan);
    m_impl->scene.SetTime(at);
    m_impl->described.settings["at"] = AtText(at);
    m_impl->frames = std::move(frames);
}

bool Session::HasResult() const {
    return m_impl->frames->HasPicture();
}

SessionResult Session::Result() const {
    if (!m_impl->frames->HasPicture()) Refuse("there is no result before a run");
    SessionResult result{.render = m_impl->described};
    RenderFile& render = result.render;
    m_impl->frames->TakePicture(render);
    result.statistics = Measure(render.radiance, render.variance,
                                static_cast<uint32_t>(session::SampleCount(render.samples)));
    result.removed = RemovedOf(render);
    KeepOnly(render, m_impl->aovs);
    return result;
}

image::Image8 Session::Display() const {
    if (!m_impl->frames->HasPicture()) Refuse("there is no picture before a run");
    return m_impl->frames->TakeDisplay();
}

uint32_t Session::SampleCount() const {
    return m_impl->frames->SamplesSubmitted();
}

uint64_t Session::NonFiniteSamples() {
    return m_impl->frames->NonFiniteSamples();
}

SessionStatistics Session::Statistics() {
    return {.passes = m_impl->frames->Times().Summary(),
            .scene = m_impl->scene.Scene().Statistics(),
            .pipelinesMs = m_impl->scene.GraphRenderer().PipelineCreationMs()};
}

std::optional<double> Session::MeasureRaysPerSample() {
    if (!m_impl->frames->TracesPaths()) return std::nullopt;
    return m_impl->frames->MeasureRaysPerSample();
}

const SceneInput& Session::Input() const {
    return m_impl->input;
}

}  // namespace raygraph::session
