#include "editor/session/tracing_choice.h"

#include <algorithm>
#include <array>
#include <bit>
#include <optional>

#include "base/log.h"
#include "base/text.h"
#include "base/version.h"
#include "editor/session/form_text.h"
#include "editor/session/parse.h"
#include "passes/scene_bindings.h"

namespace raygraph::session {

namespace {

using passes::FormSettings;
using passes::IntegratorForm;
using passes::Traversal;

constexpr std::array kMeasured{
    FormSettings{IntegratorForm::Loop, 4}, FormSettings{IntegratorForm::Wavefront, 2},
    FormSettings{IntegratorForm::Wavefront, 4}, FormSettings{IntegratorForm::Wavefront, 8},
    FormSettings{IntegratorForm::Wavefront, 16}};
constexpr uint32_t kWarmUpFrames = 2, kMaxFramesToSettle = 64, kTimedFrames = 5;

// As a frame of a render has.
uint32_t SamplesOf(DeviceScene& scene) {
    return scene.IsBlurred() ? 1
                             : passes::SamplesAtOnce(scene.GraphRenderer().Device(), scene.SettingsFor(0));
}

std::string KeyOf(DeviceScene& scene, const SceneIds& ids, const TracingChoice& wanted) {
    const rhi::DeviceInfo& device = scene.GraphRenderer().Device().Info();
    const Version version = LibraryVersion();
    const passes::TraceSettings settings = scene.SettingsFor(0);
    const GpuSceneStatistics& statistics = scene.Scene().Statistics();
    return Text(
        "{} | {} | {}.{}.{} | features {:x} | {} pixels, {} triangles, {} instances, powers of two | {} level"
        "{} | {} at once | of {}",
        device.name, device.driver, version.major, version.minor, version.patch,
        passes::TraceFeatures(ids, settings),
        std::bit_width(uint64_t{passes::RegionOf(settings).PixelCount()}),
        std::bit_width(statistics.trianglesPlaced), std::bit_width(statistics.instanceCount),
        ids.hasOneWideLevel ? 1 : 2, ids.hasOneWideLevel ? "" : "s", SamplesOf(scene), TracingText(wanted));
}

// Where each sample has its own time, the host builds the tree over the instances for each. For one that
// takes as long as own traversal saves in so many pixels on a CPU, and on a GPU in thousands.
constexpr uint64_t kPixelsPerMovedInstance = 8;

bool SavesTime(DeviceScene& scene, bool isCpu) {
    if (!scene.IsBlurred()) return true;
    return isCpu && passes::RegionOf(scene.SettingsFor(0)).PixelCount() >=
                        kPixelsPerMovedInstance * scene.Scene().Statistics().instanceCount;
}

SceneIds DeclareOnce(DeviceScene& scene) {
    scene.GraphRenderer().BeginFrame();
    const SceneIds ids = scene.Declare(0);
    scene.GraphRenderer().Device().WaitFor(scene.GraphRenderer().Execute());
    return ids;
}

std::optional<TracingChoice> Find(const ChoiceMemory& memory, std::string_view key) {
    const std::optional<std::string> known = memory.Find(key);
    if (!known) return std::nullopt;
    try {
        return ParseTracing(*known);
    } catch (const Error&) {
        return std::nullopt;  // something else is written there
    }
}

bool IsOf(const TracingChoice& wanted, const TracingChoice& choice) {
    if (choice.form.kind == IntegratorForm::Auto || choice.traversal == Traversal::Auto) return false;
    return (wanted.form.kind == IntegratorForm::Auto || wanted.form == choice.form) &&
           (wanted.traversal == Traversal::Auto || wanted.traversal == choice.traversal);
}

// All that `wanted` leaves open, one after the other.
std::vector<TracingChoice> ChoicesFor(const TracingChoice& wanted) {
    std::vector<TracingChoice> choices;
    for (const Traversal traversal : {Traversal::Driver, Traversal::Own}) {
        if (wanted.traversal != Traversal::Auto && wanted.traversal != traversal) continue;
        if (wanted.form.kind != IntegratorForm::Auto) choices.push_back({wanted.form, traversal});
        for (const FormSettings& form : kMeasured)
            if (wanted.form.kind == IntegratorForm::Auto) choices.push_back({form, traversal});
    }
    return choices;
}

}  // namespace

TracingChoice ParseTracing(std::string_view text) {
    const size_t space = text.find(' ');
    TracingChoice choice;
    choice.traversal = ParseChoice<Traversal>(std::string(text.substr(0, space)));
    choice.form = ParseForm(space == std::string_view::npos ? std::string_view() : text.substr(space + 1));
    return choice;
}

std::string TracingText(const TracingChoice& choice) {
    return Text("{} {}", Name(choice.traversal), FormText(choice.form));
}

double MsOfTrace(const PassTimes& times) {
    double sum = 0.0;
    for (const PassTime& pass : times.Summary()) sum += passes::IsOfTrace(pass.name) ? pass.gpuMsMedian : 0.0;
    return sum;
}

std::vector<TracingTime> MeasureTracing(DeviceScene& scene, std::span<const TracingChoice> choices) {
    Renderer& renderer = scene.GraphRenderer();
    if (renderer.Device().Info().timestampPeriodNs <= 0.0) return {};
    const uint32_t samples = SamplesOf(scene);
    const auto run = [&](const TracingChoice& choice, uint32_t count) {
        uint64_t last = 0;
        for (uint32_t i = 0; i < count; ++i) {
            renderer.BeginFrame();
            const SceneIds ids = scene.Declare(i);
            passes::TraceSettings settings = scene.SettingsFor(i);
            settings.form = choice.form;
            settings.traversal = choice.traversal;
            settings.sampleCount = samples;
            renderer.Present(passes::Trace(renderer, ids, settings).radiance);
            last = renderer.Execute();
        }
        renderer.Device().WaitFor(last);
    };
    std::vector<TracingTime> times;
    for (const TracingChoice& choice : choices) {
        run(choice, kWarmUpFrames);
        for (uint32_t i = 0; i < kMaxFramesToSettle && !scene.Scene().IsSettled(); ++i) run(choice, 1);
        std::ignore = renderer.TakeTimings();
        run(choice, kTimedFrames);
        PassTimes ofChoice;
        ofChoice.Add(renderer.TakeTimings());
        times.push_back({choice, MsOfTrace(ofChoice) / samples});
    }
    return times;
}

TracingChoice ChooseTracing(DeviceScene& scene, const TracingChoice& asked, const ChoiceMemory& memory) {
    const rhi::Device& device = scene.GraphRenderer().Device();
    TracingChoice wanted = asked;
    if (!scene.WhyNoOwnTraversal().empty()) wanted.traversal = Traversal::Driver;
    const bool isCpu = device.Info().type == rhi::DeviceType::Cpu;
    if (wanted.traversal == Traversal::Auto && !SavesTime(scene, isCpu)) wanted.traversal = Traversal::Driver;
    if (isCpu || device.Info().timestampPeriodNs <= 0.0) {
        if (wanted.form.kind == IntegratorForm::Auto) wanted.form.kind = IntegratorForm::Loop;
        if (wanted.traversal == Traversal::Auto)
            wanted.traversal = isCpu ? Traversal::Own : Traversal::Driver;
    }
    const std::vector<TracingChoice> choices = ChoicesFor(wanted);
    if (choices.size() == 1) return choices.front();
    const std::string key = KeyOf(scene, DeclareOnce(scene), wanted);
    std::optional<TracingChoice> chosen = Find(memory, key);
    std::string how = "remembered";
    if (!chosen || !IsOf(wanted, *chosen)) {
        const std::vector<TracingTime> times = MeasureTracing(scene, choices);
        how = "measured:";
        for (const TracingTime& time : times)
            how += Text(" {} {:.3f} ms", TracingText(time.choice), time.msPerSample);
        chosen = std::ranges::min_element(times, {}, &TracingTime::msPerSample)->choice;
        memory.Remember(key, TracingText(*chosen));
    }
    Say(device.Log(), LogLevel::Info, log_category::kShaders, "traversal and integrator's form: {} ({})",
        TracingText(*chosen), how);
    return *chosen;
}

void WarnOfDriver(const Log& log, const std::string& whyNotOwn) {
    Say(log, LogLevel::Warning, log_category::kScene,
        "the driver's traversal is used in place of Raygraph's own: {}", whyNotOwn);
}

}  // namespace raygraph::session
