#include "editor/session/form_choice.h"

#include <algorithm>
#include <array>
#include <bit>

#include "base/text.h"
#include "base/version.h"
#include "editor/session/form_text.h"
#include "passes/scene_bindings.h"

namespace raygraph::session {

namespace {

using passes::FormSettings;
using passes::IntegratorForm;

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

std::string KeyOf(const rhi::DeviceInfo& device, uint32_t samples, const SceneIds& ids,
                  const passes::TraceSettings& settings) {
    const Version version = LibraryVersion();
    const uint64_t pixels = passes::RegionOf(settings).PixelCount();
    std::string key = Text("{} | {} | {}.{}.{} | features {:x} | 2^{} pixels | {} at once", device.name,
                           device.driver, version.major, version.minor, version.patch,
                           passes::TraceFeatures(ids, settings), std::bit_width(pixels) - 1, samples);
    if (passes::TracesItself(ids, settings)) key += " | own traversal";
    return key;
}

SceneIds DeclareOnce(DeviceScene& scene) {
    scene.GraphRenderer().BeginFrame();
    const SceneIds ids = scene.Declare(0);
    scene.GraphRenderer().Device().WaitFor(scene.GraphRenderer().Execute());
    return ids;
}

}  // namespace

std::optional<FormSettings> FormMemory::Find(std::string_view key) const {
    const std::optional<std::string> known = m_memory.Find(key);
    if (!known) return std::nullopt;
    try {
        return ParseForm(*known);
    } catch (const Error&) {
        return std::nullopt;
    }
}

void FormMemory::Remember(std::string_view key, const FormSettings& form) const {
    m_memory.Remember(key, FormText(form));
}

double MsOfTrace(const PassTimes& times) {
    double sum = 0.0;
    for (const PassTime& pass : times.Summary()) sum += passes::IsOfTrace(pass.name) ? pass.gpuMsMedian : 0.0;
    return sum;
}

std::vector<FormTime> MeasureForms(DeviceScene& scene, std::span<const FormSettings> forms) {
    Renderer& renderer = scene.GraphRenderer();
    if (renderer.Device().Info().timestampPeriodNs <= 0.0) return {};
    const uint32_t samples = SamplesOf(scene);
    const auto run = [&](const FormSettings& form, uint32_t count) {
        uint64_t last = 0;
        for (uint32_t i = 0; i < count; ++i) {
            renderer.BeginFrame();
            const SceneIds ids = scene.Declare(i);
            passes::TraceSettings settings = scene.SettingsFor(i);
            settings.form = form;
            settings.sampleCount = samples;
            renderer.Present(passes::Trace(renderer, ids, settings).radiance);
            last = renderer.Execute();
        }
        renderer.Device().WaitFor(last);
    };
    std::vector<FormTime> times;
    for (const FormSettings& form : forms) {
        run(form, kWarmUpFrames);
        for (uint32_t i = 0; i < kMaxFramesToSettle && !scene.Scene().IsSettled(); ++i) run(form, 1);
        std::ignore = renderer.TakeTimings();
        run(form, kTimedFrames);
        PassTimes ofForm;
        ofForm.Add(renderer.TakeTimings());
        times.push_back({form, MsOfTrace(ofForm) / samples});
    }
    return times;
}

FormSettings ChooseForm(DeviceScene& scene, const FormMemory& memory) {
    const rhi::Device& device = scene.GraphRenderer().Device();
    if (device.Info().type == rhi::DeviceType::Cpu) return {.kind = IntegratorForm::Loop};
    const std::string key = KeyOf(device.Info(), SamplesOf(scene), DeclareOnce(scene), scene.SettingsFor(0));
    std::optional<FormSettings> form = memory.Find(key);
    std::string how = "remembered";
    if (!form) {
        const std::vector<FormTime> times = MeasureForms(scene, kMeasured);
        if (times.empty()) return {.kind = IntegratorForm::Loop};
        how = "measured:";
        for (const FormTime& time : times)
            how += Text(" {} {:.3f} ms", FormText(time.form), time.msPerSample);
        form = std::ranges::min_element(times, {}, &FormTime::msPerSample)->form;
        memory.Remember(key, *form);
    }
    Say(device.Log(), LogLevel::Info, log_category::kShaders, "the integrator's form is {} ({})",
        FormText(*form), how);
    return *form;
}

}  // namespace raygraph::session
