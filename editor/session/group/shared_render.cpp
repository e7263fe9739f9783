#include "editor/session/group/shared_render.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <future>
#include <limits>
#include <thread>
#include <utility>

#include "base/check.h"
#include "base/stopwatch.h"
#include "editor/session/file/render_file_parts.h"
#include "editor/session/settings/error_goal.h"
#include "renderer/gpu_scene/materials/texture_set.h"

namespace raygraph::session {

namespace {

// A block keeps its device busy for this long. Messages between processes take longer than a lock.
constexpr double kBlockSeconds = 0.1, kBlockSecondsOfGroup = 1.0;
constexpr std::chrono::microseconds kTick = std::chrono::milliseconds(20);

// Gives all devices textures of the same detail: without a budget, that of the device with the least memory
// applies.
PictureSettings WithCommonTextureBudget(const PictureSettings& settings,
                                        std::span<rhi::Device* const> devices, ProcessGroup* group) {
    PictureSettings agreed = settings;
    if (settings.textureBudget > 0 || (devices.size() == 1 && group == nullptr)) return agreed;
    uint64_t budget = std::numeric_limits<uint64_t>::max();
    for (const rhi::Device* device : devices) budget = std::min(budget, DefaultTextureBudget(*device));
    if (group != nullptr) budget = group->Minimum(budget);
    agreed.textureBudget = std::max<uint64_t>(budget, 1);
    return agreed;
}

// Makes each device's render on a thread of its own, with an input of its own.
std::vector<std::unique_ptr<DeviceRender>> MakeDevices(std::span<rhi::Device* const> devices,
                                                       SceneInput& input, const PictureSettings& settings,
                                                       const TracingChoice& tracing) {
    std::vector<SceneInput> inputs(devices.size() - 1, input);
    std::vector<std::future<std::unique_ptr<DeviceRender>>> others;
    for (size_t i = 1; i < devices.size(); ++i)
        others.push_back(std::async(std::launch::async, [&, i] {
            return std::make_unique<DeviceRender>(*devices[i], inputs[i - 1], settings, tracing);
        }));
    std::vector<std::unique_ptr<DeviceRender>> made;
    made.push_back(std::make_unique<DeviceRender>(*devices.front(), input, settings, tracing));
    for (auto& other : others) made.push_back(other.get());
    return made;
}

void DealLocally(BlockDealer& dealer, BlockQueue& queue, const ProcessGroup::Tick& tick) {
    Stopwatch sinceTick;
    while (!queue.IsOver()) {
        if (queue.HasFailed()) queue.Close();
        if (const auto request = queue.TakeRequest(kTick))
            queue.Answer(request->device, dealer.Next(request->device, request->samplesPerSecond));
        if (sinceTick.Seconds() < std::chrono::duration<double>(kTick).count()) continue;
        tick(false);
        sinceTick = {};
    }
    tick(false);
}

}  // namespace

SharedRender::SharedRender(std::span<rhi::Device* const> devices, SceneInput& input,
                           const PictureSettings& settings, const TracingChoice& tracing, ProcessGroup* group)
    : m_group(group) {
    TracingChoice chosen = tracing;
    if (settings.view == View::PathTraced) {
        if (IsRoot()) chosen = ChooseTracing(*devices.front(), tracing);
        if (m_group != nullptr) m_group->Broadcast(std::as_writable_bytes(std::span(&chosen, 1)));
    }
    m_devices = MakeDevices(devices, input, WithCommonTextureBudget(settings, devices, group), chosen);
    if (settings.view == View::PathTraced && chosen.traversal == Traversal::Software) SynchronizeTraversal();
    m_deviceCount = static_cast<uint32_t>(m_devices.size());
    if (m_group != nullptr) m_deviceCount = static_cast<uint32_t>(m_group->Sum(m_deviceCount));
}

void SharedRender::SynchronizeTraversal() {
    for (const auto& device : m_devices)
        if (m_driverTraversalReason.empty())
            m_driverTraversalReason = device->Scene().NoSoftwareTraversalReason();
    const bool isSoftware = m_driverTraversalReason.empty();
    if (m_group != nullptr && m_group->Minimum(isSoftware ? 1 : 0) == 0 && isSoftware)
        m_driverTraversalReason = "another process cannot";
    if (m_driverTraversalReason.empty()) return;
    for (const auto& device : m_devices) device->Scene().TraceByDriver();
}

std::optional<MeasuredError> SharedRender::Begin(const FramePlan& requested) {
    // All processes need these values of a render that the root continues
    struct {
        uint32_t sampleCount = 0;
        uint32_t retraced = 0;       // a bit for each bias
        uint32_t measuredCount = 0;  // 0: nothing was measured
        double measuredError = 0.0;
    } known;
    FramePlan plan = requested;
    plan.hasUnblurred = IsRoot();
    plan.retraced = BiasesToRetrace(First().Scene().SettingsFor(0).biases, plan.continues);
    const auto bit = [](Bias bias) { return 1u << static_cast<uint32_t>(bias); };
    for (const Bias bias : kBiases)
        if (plan.retraced[static_cast<size_t>(bias)]) known.retraced |= bit(bias);
    if (plan.continues != nullptr) {
        known.sampleCount = plan.continues->samples.front().count;
        const auto& measured = plan.continues->measuredError;
        if (measured && measured->relativeError) {
            known.measuredCount = measured->samples;
            known.measuredError = *measured->relativeError;
        }
    }
    if (m_group != nullptr) m_group->Broadcast(std::as_writable_bytes(std::span(&known, 1)));
    for (const Bias bias : kBiases)
        plan.retraced[static_cast<size_t>(bias)] = (known.retraced & bit(bias)) != 0;
    if (!IsAlone()) plan.withSums = true;  // the picture is made of the sums
    for (const auto& device : m_devices) {
        device->Begin(plan);
        plan.continues = nullptr;
        plan.hasUnblurred = false;
    }
    m_isAdaptive = plan.isAdaptive;
    m_firstSample = plan.firstSample;
    m_sampleCount = known.sampleCount;
    m_pooled.reset();
    if (known.measuredCount == 0) return std::nullopt;
    return MeasuredError{known.measuredCount, known.measuredError};
}

void SharedRender::SetTime(double at) {
    for (const auto& device : m_devices) {
        device->Frames().WaitForSamples();
        std::ignore = device->Frames().Times();  // discards those of the last picture
        device->Scene().SetTime(at);
    }
}

void SharedRender::SetCamera(const std::string& camera) {
    for (const auto& device : m_devices) device->Scene().SetCamera(camera);
}

bool SharedRender::RestoreSurfaces(const std::function<bool()>& isStopRequested,
                                   const std::function<void(uint32_t)>& onRestored) {
    SampleFrames& frames = First().Frames();
    uint64_t stopped = 0;
    while (frames.SamplesToRestore() > 0) {
        if (isStopRequested()) {
            stopped = 1;
            break;
        }
        frames.RestoreSample();
        onRestored(m_sampleCount - frames.SamplesToRestore());
    }
    if (m_group != nullptr) stopped = m_group->Sum(stopped);
    return stopped == 0;
}

uint32_t SharedRender::SamplesDone() {
    if (IsAlone()) return First().Frames().SamplesDone();
    return m_dealer != nullptr ? m_samplesOfRounds + m_dealer->DoneCount() : m_sampleCount;
}

void SharedRender::WaitForSamples() {
    if (IsAlone()) First().Frames().WaitForSamples();
}

std::optional<double> SharedRender::RelativeError() const {
    const double ofOne = First().ErrorOfOneSample();
    if (ofOne <= 0.0 || m_sampleCount == 0) return std::nullopt;
    return ofOne / std::sqrt(static_cast<double>(m_sampleCount));
}

SharedRender::RoundEnd SharedRender::RunRound(BlockDealer* dealer, bool isEstimating,
                                              const std::function<RoundEnd()>& tick) {
    RoundEnd end = RoundEnd::Complete;
    const auto askToGoOn = [&](bool isStopRequested) {
        if (dealer != nullptr) m_sampleCount = m_samplesOfRounds + dealer->DealtCount();
        const RoundEnd requested = tick();
        if (end == RoundEnd::Complete) end = isStopRequested ? RoundEnd::Stopped : requested;
        if (end != RoundEnd::Complete && dealer != nullptr) dealer->Stop();
        return end != RoundEnd::Complete;
    };
    if (IsAlone()) {
        First().RenderBlocks(*dealer, 0, isEstimating, [&] { askToGoOn(false); });
        return end;
    }
    BlockQueue queue(static_cast<uint32_t>(m_devices.size()));
    {
        std::vector<std::jthread> threads;
        try {
            for (uint32_t i = 0; i < m_devices.size(); ++i)
                threads.emplace_back([&, i] {
                    try {
                        m_devices[i]->RenderBlocks(queue, i, isEstimating && i == 0);
                    } catch (...) {
                        queue.Fail(i, std::current_exception());
                    }
                });
            if (m_group != nullptr)
                m_group->Deal(dealer, queue, askToGoOn);
            else
                DealLocally(*dealer, queue, askToGoOn);
        } catch (...) {
            queue.Close();
            throw;
        }
    }
    queue.RethrowError();
    return end;
}

SharedRender::RoundEnd SharedRender::RunAdaptive(uint32_t average, bool isEstimating,
                                                 const std::function<RoundEnd()>& tick) {
    RoundEnd end = RoundEnd::Complete;
    First().RenderAdaptive(average, isEstimating, [&] {
        m_sampleCount = First().Frames().SamplesSubmitted();
        end = tick();
        return end != RoundEnd::Complete;
    });
    return end;
}

SharedRender::RoundEnd SharedRender::RenderTo(uint32_t samples, bool isEstimating,
                                              const std::function<RoundEnd()>& tick) {
    RG_CHECK(samples > m_sampleCount);
    m_pooled.reset();
    if (m_isAdaptive) return RunAdaptive(samples, isEstimating, tick);
    m_samplesOfRounds = m_sampleCount;
    struct {
        RoundEnd end = RoundEnd::Complete;
        uint32_t dealt = 0;
    } result;
    if (IsRoot()) {
        BlockDealer dealer({m_firstSample + m_sampleCount, samples - m_sampleCount}, m_deviceCount,
                           m_group != nullptr ? kBlockSecondsOfGroup : kBlockSeconds,
                           First().PreferredBatchSize());
        m_dealer = &dealer;
        result.end = RunRound(&dealer, isEstimating, tick);
        m_dealer = nullptr;
        result.dealt = dealer.DealtCount();
    } else {
        result.end = RunRound(nullptr, false, tick);
    }
    if (m_group != nullptr) m_group->Broadcast(std::as_writable_bytes(std::span(&result, 1)));
    m_sampleCount = m_samplesOfRounds + result.dealt;
    return result.end;
}

MeasuredError SharedRender::MeasureError() {
    if (IsAlone()) return First().Frames().MeasureErrorNow();
    passes::ExactSums sums = First().Frames().RadianceSums();
    for (size_t i = 1; i < m_devices.size(); ++i)
        passes::AddSums(sums, m_devices[i]->Frames().RadianceSums());
    if (m_group != nullptr) m_group->AddAtRoot(sums);
    MeasuredError error;
    if (IsRoot())
        error = session::MeasureError(passes::MeanOf(sums, m_sampleCount),
                                      passes::VarianceOf(sums, m_sampleCount), m_sampleCount);
    struct {
        uint32_t samples = 0, hasError = 0;
        double relativeError = 0.0;
    } known{error.samples, error.relativeError ? 1u : 0u, error.relativeError.value_or(0.0)};
    if (m_group != nullptr) m_group->Broadcast(std::as_writable_bytes(std::span(&known, 1)));
    error.samples = known.samples;
    if (known.hasError != 0)
        error.relativeError = known.relativeError;
    else
        error.relativeError.reset();
    return error;
}

// Combines one device after another, so that the memory of the host is that of two pictures, however many
// devices there are.
void SharedRender::CombineSums(RenderFile& render) {
    bool isFirst = true;
    for (const auto& device : m_devices) {
        SampleFrames& frames = device->Frames();
        RenderFile part{.size = render.size};
        RenderFile& into = std::exchange(isFirst, false) ? render : part;
        frames.FinishPicture();
        frames.TakePicture(into);
        frames.DropPicture();
        if (&into == &render) continue;
        Add(render.sums, std::move(part.sums));
        render.removedSamples += part.removedSamples;
    }
    if (m_group != nullptr) {
        for (passes::ExactSums* sums : AllOf(render.sums))
            if (!sums->IsEmpty()) m_group->AddAtRoot(*sums);
        render.removedSamples = static_cast<uint32_t>(m_group->Sum(render.removedSamples));
    }
    render.samples = {{m_firstSample, m_sampleCount}};
}

void SharedRender::Finish(const RenderFile& described) {
    m_nonFiniteSamples = 0;
    for (const auto& device : m_devices) m_nonFiniteSamples += device->Frames().NonFiniteSamples();
    if (IsAlone()) {
        First().Frames().FinishPicture();
        return;
    }
    RenderFile render = described;
    CombineSums(render);
    if (m_group != nullptr) m_nonFiniteSamples = m_group->Sum(m_nonFiniteSamples);
    if (!IsRoot()) return;
    TakeMeans(render);
    m_display = First().Frames().DisplayOf(render.sums.radiance, m_sampleCount);
    m_pooled = std::move(render);
}

bool SharedRender::HasPicture() const {
    return IsAlone() ? First().Frames().HasPicture() : m_pooled.has_value();
}

RenderFile SharedRender::Picture(const RenderFile& described) const {
    if (m_pooled) return *m_pooled;
    RenderFile render = described;
    First().Frames().TakePicture(render);
    return render;
}

image::Image8 SharedRender::Display() const {
    return m_pooled ? m_display : First().Frames().TakeDisplay();
}

uint64_t SharedRender::NonFiniteSamples() {
    return IsAlone() ? First().Frames().NonFiniteSamples() : m_nonFiniteSamples;
}

// --- DeviceRender ---

namespace {

constexpr uint32_t kMostAtStep = 1u << 16;  // samples of a pixel, on average

}  // namespace

void DeviceRender::Estimate() {
    // The error is estimated at the first count that reaches each power of two
    const int width = std::bit_width(m_frames->SamplesSubmitted());
    if (std::exchange(m_estimatedWidth, width) != width) m_frames->MeasureError();
    const std::optional<MeasuredError>& error = m_frames->NewestError();
    if (error && error->relativeError)
        m_errorOfOneSample.store(*error->relativeError * std::sqrt(static_cast<double>(error->samples)),
                                 std::memory_order_relaxed);
}

void DeviceRender::RenderBlocks(BlockSource& source, uint32_t device, bool isEstimating,
                                const std::function<void()>& afterSamples) {
    // The speed is measured by finished samples, since frames are in flight
    Stopwatch watch;
    uint32_t doneBefore = m_frames->SamplesDone();
    const auto samples = [&] { return m_samples + (m_frames->SamplesDone() - doneBefore); };
    const auto speed = [&] {
        return m_isWarm && samples() > 0.0 ? samples() / (m_seconds + watch.Seconds()) : 0.0;
    };
    while (const auto block = source.Next(device, speed())) {
        for (uint32_t done = 0; done < block->count;) {
            const uint32_t count = std::min(block->count - done, PreferredBatchSize());
            m_frames->RenderSamples({block->first + done, count});
            done += count;
            if (!m_isWarm) {
                m_frames->WaitForSamples();
                doneBefore = m_frames->SamplesDone();
                watch = {};
                m_isWarm = true;
            }
            if (isEstimating) Estimate();
            if (afterSamples) afterSamples();
        }
    }
    m_frames->WaitForSamples();
    if (!m_isWarm) return;
    m_samples = samples();
    m_seconds += watch.Seconds();
}

void DeviceRender::RenderAdaptive(uint32_t average, bool isEstimating,
                                  const std::function<bool()>& afterFrames) {
    // A run may end between two steps, each of which takes about this long, whatever the cost of a sample
    constexpr double kShortest = 0.1, kLongest = 0.5;
    do {
        const Stopwatch watch;
        m_frames->RenderAdaptive(average, m_step);
        const double seconds = watch.Seconds();
        if (seconds > kLongest)
            m_step = std::max(m_step / 2, 1u);
        else if (seconds < kShortest)
            m_step = std::min(2 * m_step, kMostAtStep);
        if (isEstimating) Estimate();
    } while (!afterFrames() && m_frames->SamplesSubmitted() < average);
    m_frames->WaitForSamples();
}

}  // namespace raygraph::session
