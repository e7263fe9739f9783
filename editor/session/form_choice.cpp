#include "editor/session/form_choice.h"

#include <algorithm>
#include <array>
#include <bit>
#include <fstream>
#include <iterator>

#include "base/atomic_file.h"
#include "base/extension.h"
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

// "KEY<tab>FORM" as a choice.
struct Line {
    std::string key;
    FormSettings form;
};

std::optional<Line> ParseLine(const std::string& text) {
    const size_t tab = text.find('\t');
    if (tab == std::string::npos) return std::nullopt;
    try {
        return Line{text.substr(0, tab), ParseForm(text.substr(tab + 1))};
    } catch (const Error&) {
        return std::nullopt;
    }
}

std::vector<Line> ReadLines(const std::filesystem::path& file) {
    std::vector<Line> lines;
    std::ifstream stream(file);
    for (std::string text; std::getline(stream, text);)
        if (std::optional<Line> line = ParseLine(text)) lines.push_back(*std::move(line));
    return lines;
}

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
    std::ranges::replace_if(
        key, [](char c) { return c == '\t' || c == '\n'; }, ' ');
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
    if (m_file.empty()) return std::nullopt;
    for (const Line& line : ReadLines(m_file))
        if (line.key == key) return line.form;
    return std::nullopt;
}

void FormMemory::Remember(std::string_view key, const FormSettings& form) const {
    if (m_file.empty()) return;
    std::string text;
    for (const Line& line : ReadLines(m_file))
        if (line.key != key) text += line.key + '\t' + FormText(line.form) + '\n';
    text.append(key).append(1, '\t').append(FormText(form)).append(1, '\n');
    try {
        std::filesystem::create_directories(m_file.parent_path());
        AtomicFile file(m_file);
        file.Write(std::as_bytes(std::span(text)));
        file.Commit();
    } catch (const std::exception&) {
        // It is measured again
    }
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
