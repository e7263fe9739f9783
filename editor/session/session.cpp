#include "editor/session/session.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <set>
#include <utility>

#include "base/log.h"
#include "base/printable.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "editor/session/denoise.h"
#include "editor/session/file/render_file_parts.h"
#include "editor/session/group/shared_render.h"
#include "editor/session/settings/error_goal.h"
#include "editor/session/settings/light_settings.h"
#include "editor/session/settings/session_checks.h"
#include "passes/pixel_list.h"
#include "renderer/graph/readback_values.h"

namespace raygraph::session {

namespace {

FramePlan PlanOf(const SessionDesc& desc) {
    return {.view = desc.settings.view,
            .aovs = desc.aovs,
            .firstSample = desc.firstSample,
            .lightGroupCount = static_cast<uint32_t>(LightGroupNames(desc.settings.lightGroups).size()),
            .withVariance = desc.withVariance,
            .isAdaptive = desc.settings.isAdaptive,
            .withSums = desc.withSums,
            .isDenoised = desc.isDenoised,
            .denoiser = desc.denoiser,
            .batchSize = desc.batchSize,
            .raster = desc.settings.raster,
            .tonemap = WithAlphaOf(desc.tonemap, desc.settings),
            .backdrop = desc.settings.paths.isEnvironmentHidden ? desc.backdrop : std::nullopt};
}

// Devices of different kinds are named "A + B", devices of one kind "A".
RenderFile Describe(const SceneInput& input, const PictureSettings& settings,
                    std::span<rhi::Device* const> devices) {
    RenderFile render = DescribeRender(input, settings, devices.front()->Info());
    std::set<std::string> names{render.device};
    for (const rhi::Device* device : devices)
        if (names.insert(device->Info().name).second) render.device += " + " + device->Info().name;
    return render;
}

SessionDesc WithLight(const SessionDesc& desc, const SceneInput& input) {
    SessionDesc decided = desc;
    decided.settings.light = ChooseLight(input, desc.settings, desc.resumed, desc.group);
    return decided;
}

// Must be called before the AOVs that were not requested are dropped.
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

struct Session::Impl {
    Impl(std::span<rhi::Device* const> devices, SceneInput&& of, const SessionDesc& desc)
        : input(std::move(of)),
          aovs(desc.aovs),
          firstSample(desc.firstSample),
          isSingle(!passes::IsAverageable(desc.settings.view)),
          canEstimateError(desc.withVariance && passes::ShowsLight(desc.settings.view)),
          described(Describe(input, desc.settings, devices)),
          plan(PlanOf(desc)),
          shared(devices, RequireInput(desc, devices.size()), desc.settings, desc.tracing, desc.group) {
        if (desc.tracing.traversal == Traversal::Software && !shared.DriverTraversalReason().empty())
            WarnDriverTraversal(devices.front()->Log(), shared.DriverTraversalReason());
        if (desc.isDenoised)
            WarnIfTooLarge(devices.front()->Info(), RenderedPart(desc.settings).Extent(), desc.denoiser,
                           devices.front()->Log());
        Begin(desc.resumed);
    }

    // Another scene or environment on one computer would be mixed into the picture without a word.
    void RequireSameInput(ProcessGroup* group) const {
        if (group == nullptr) return;
        const std::string content = input.hash + input.environmentHash + described.version;
        std::string ofRoot = content;
        ofRoot.resize(128);
        std::string own = ofRoot;
        group->Broadcast(std::as_writable_bytes(std::span(ofRoot)));
        if (own != ofRoot)
            throw MakeError(
                ErrorKind::BadInput,
                "{}: process {} has another scene, environment or program version than the first one",
                Printable(input.file), group->Rank());
    }

    // Returns the input if it makes a session possible; throws otherwise.
    SceneInput& RequireInput(const SessionDesc& desc, size_t deviceCount) {
        RequireValidDesc(desc);
        RequireAdaptive(desc, deviceCount);
        RequireDenoisable(desc, deviceCount);
        if (desc.resumed != nullptr) RequireSame(*desc.resumed, described);
        RequireSameInput(desc.group);
        return input;
    }
    void Begin(const ResumedRender* resumed) {
        FramePlan begun = plan;
        if (resumed != nullptr) begun.continues = &resumed->render;
        described.measuredError = shared.Begin(begun);
    }
    bool RestoreSurfaces(const StopRule& rule, const std::function<void(const ProgressState&)>& progress) {
        const auto show = [&](uint32_t restored) {
            if (!progress) return;
            ProgressState state;
            state.samplesDone = shared.SampleCount();
            state.samplesWanted = rule.samples;
            state.samplesRestored = restored;
            progress(state);
        };
        return shared.RestoreSurfaces([&] { return rule.isStopRequested && rule.isStopRequested(); }, show);
    }
    // Returns how many samples the picture can have, since indices have 32 bits.
    uint32_t MaxSampleCount() const {
        const uint64_t indices = (uint64_t{1} << 32) - firstSample;
        return static_cast<uint32_t>(std::min<uint64_t>(indices, std::numeric_limits<uint32_t>::max()));
    }
    // Returns the number of samples at which the run pauses next.
    uint32_t NextPause(const StopRule& rule, const ErrorTarget& goal) const {
        const uint64_t most = MaxSampleCount();
        return static_cast<uint32_t>(std::min<uint64_t>(
            {most, rule.samples.value_or(most), goal.NextStop(shared.SampleCount()).value_or(most)}));
    }
    RunSummary Run(const StopRule& rule, const std::function<void(const ProgressState&)>& progress);
    ProgressState StateAt(const Stopwatch& watch, uint32_t before, const StopRule& rule,
                          const RunSummary& soFar, uint32_t doneAtFirst);

    SceneInput input;
    AovSet aovs;
    uint32_t firstSample;
    bool isSingle, canEstimateError;
    RenderFile described;
    FramePlan plan;
    SharedRender shared;
};

ProgressState Session::Impl::StateAt(const Stopwatch& watch, uint32_t before, const StopRule& rule,
                                     const RunSummary& soFar, uint32_t doneAtFirst) {
    const double seconds = watch.Seconds();
    ProgressState state;
    state.samplesDone = shared.SamplesDone();
    state.samplesWanted = rule.samples;
    const double timed = seconds - soFar.firstSampleSeconds;
    const double fresh = static_cast<double>(state.samplesDone) - before - doneAtFirst;
    if (doneAtFirst > 0 && fresh > 0.0 && timed > 0.0) {
        const double rate = fresh / timed;
        state.samplesPerSecond = rate * static_cast<double>(PixelCount(described.size));
        if (rule.samples) state.secondsLeft = (*rule.samples - state.samplesDone) / rate;
    }
    if (rule.seconds)
        state.secondsLeft =
            std::min(std::max(0.0, *rule.seconds - seconds), state.secondsLeft.value_or(*rule.seconds));
    state.relativeError = shared.RelativeError();
    return state;
}

RunSummary Session::Impl::Run(const StopRule& rule,
                              const std::function<void(const ProgressState&)>& progress) {
    using End = SharedRender::RoundEnd;
    RunSummary summary;
    if (!RestoreSurfaces(rule, progress)) {
        summary.wasStopped = true;
        return summary;
    }
    const uint32_t before = shared.SampleCount();
    ErrorTarget goal(rule.relativeError);
    if (described.measuredError) goal.Measured(*described.measuredError);
    const Stopwatch watch;
    uint32_t doneAtFirst = 0;  // samples of this run at its first finished one
    const auto isAskedToEnd = [&] {
        return (rule.isStopRequested && rule.isStopRequested()) ||
               (rule.isPauseRequested && rule.isPauseRequested());
    };
    const auto tick = [&] {
        if (shared.IsRoot() && doneAtFirst == 0 && shared.SampleCount() > before) shared.WaitForSamples();
        // Who sees samples may rely on their being saved, and may end the run with them
        bool isStopped = isAskedToEnd();
        if (shared.IsRoot()) {
            const uint32_t done = shared.SamplesDone() - before;
            if (doneAtFirst == 0 && done > 0) {
                doneAtFirst = done;
                summary.firstSampleSeconds = watch.Seconds();
            }
            if (progress) progress(StateAt(watch, before, rule, summary, doneAtFirst));
        }
        isStopped |= isAskedToEnd();
        if (isStopped) return End::Stopped;
        return shared.IsRoot() && rule.seconds && watch.Seconds() >= *rule.seconds ? End::Late
                                                                                   : End::Complete;
    };
    const auto isComplete = [&] {
        const uint32_t samples = shared.SampleCount();
        return (rule.samples && samples >= *rule.samples) || goal.IsReachedAt(samples) ||
               samples == MaxSampleCount();
    };
    for (bool isDone = before > 0 && isComplete(); !isDone;) {
        const End end = shared.RenderTo(NextPause(rule, goal), progress && canEstimateError, tick);
        const uint32_t samples = shared.SampleCount();
        if (goal.IsMeasuringAt(samples) && !goal.IsReachedAt(samples)) {
            described.measuredError = shared.MeasureError();
            goal.Measured(*described.measuredError);
        }
        isDone = end != End::Complete || isComplete();
        summary.wasStopped = end == End::Stopped && !isComplete();
    }
    summary.seconds = watch.Seconds();
    if (const uint32_t fresh = shared.SampleCount() - before; doneAtFirst > 0 && fresh > doneAtFirst)
        summary.samplesPerSecond = (fresh - doneAtFirst) * static_cast<double>(PixelCount(described.size)) /
                                   (summary.seconds - summary.firstSampleSeconds);
    shared.Finish(described);
    return summary;
}

Session::Session(rhi::Device& device, SceneInput input, const SessionDesc& desc) {
    rhi::Device* const only = &device;
    const SessionDesc decided = WithLight(desc, input);
    m_impl = std::make_unique<Impl>(std::span(&only, 1), std::move(input), decided);
}

Session::Session(std::span<rhi::Device* const> devices, SceneInput input, const SessionDesc& desc) {
    if (devices.empty()) Reject("there is no device");
    const SessionDesc decided = WithLight(desc, input);
    m_impl = std::make_unique<Impl>(devices, std::move(input), decided);
}

Session::~Session() = default;

RunSummary Session::Run(const StopRule& requested,
                        const std::function<void(const ProgressState&)>& progress) {
    StopRule rule = requested;
    if (m_impl->isSingle) rule.samples = 1;
    RequireValidRule(rule, m_impl->firstSample, m_impl->shared.SampleCount(), m_impl->canEstimateError);
    return m_impl->Run(rule, progress);
}

void Session::StartPicture(const NextPicture& next) {
    RenderFile described = m_impl->described;
    if (next.at) {
        if (!m_impl->input.isAnimated) Reject("a picture at another time, of a scene without one");
        PictureSettings checked;
        checked.at = next.at;
        RequireReadable(checked);
        described.settings["at"] = AtText(*next.at);
    }
    if (next.camera) {
        RequireCamera(*next.camera);
        described.settings["camera"] = *next.camera;
    }
    if (next.resumed != nullptr) {
        RequireResumable(*next.resumed);
        RequireSame(*next.resumed, described);
        const RenderFile& render = next.resumed->render;
        if (render.samples.front().first != m_impl->firstSample || AovsOf(render) != m_impl->aovs)
            Reject(Text("first sample and AOVs are not those of {}", next.resumed->path));
    }
    m_impl->described = std::move(described);
    if (next.camera) m_impl->shared.SetCamera(*next.camera);
    if (next.at) m_impl->shared.SetTime(*next.at);
    m_impl->Begin(next.resumed);
}

void Session::RequireCamera(const std::string& camera) const {
    m_impl->shared.RequireCamera(camera);
}

bool Session::HasResult() const {
    return m_impl->shared.HasPicture();
}

SessionResult Session::Result() const {
    if (!m_impl->shared.HasPicture()) Reject("there is no result before a run");
    SessionResult result{.render = m_impl->shared.Picture(m_impl->described)};
    RenderFile& render = result.render;
    result.statistics = render.adaptive
                            ? Measure(render.radiance, render.variance, render.adaptive->counts)
                            : Measure(render.radiance, render.variance,
                                      static_cast<uint32_t>(session::SampleCount(render.samples)));
    result.removed = RemovedOf(render);
    KeepOnly(render, m_impl->aovs);
    if (!m_impl->plan.withSums) render.sums = {};  // several devices need them
    return result;
}

image::Image8 Session::Display() const {
    if (!m_impl->shared.HasPicture()) Reject("there is no picture before a run");
    return m_impl->shared.Display();
}

uint32_t Session::SampleCount() const {
    return m_impl->shared.SampleCount();
}

uint64_t Session::NonFiniteSamples() {
    return m_impl->shared.NonFiniteSamples();
}

SessionStatistics Session::Statistics() {
    DeviceRender& first = m_impl->shared.First();
    return {.passes = first.Frames().Times().Summary(),
            .scene = first.Scene().Scene().Statistics(),
            .pipelinesMs = first.Scene().GraphRenderer().PipelineCreationMs()};
}

std::optional<double> Session::RaysPerSample() {
    return m_impl->shared.First().Frames().RaysPerSample();
}

const SceneInput& Session::Input() const {
    return m_impl->input;
}

}  // namespace raygraph::session
