#include "editor/session/explain/explain.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "base/text.h"
#include "editor/session/cpu/scene_copy.h"
#include "editor/session/cpu/trace.h"
#include "editor/session/frames/device_scene.h"
#include "editor/session/settings/light_settings.h"
#include "passes/trace.h"
#include "renderer/graph/readback_values.h"

namespace raygraph::session {

namespace {

// Rows of a texture of samples: below the least limit that a Vulkan device may have.
constexpr uint32_t kMostAtOnce = 4096;

bool HaveSameBits(const glm::vec3& a, const glm::vec3& b) {
    return std::memcmp(&a, &b, sizeof(a)) == 0;
}

PictureSettings Decided(const PictureSettings& settings, const SceneInput& input) {
    if (settings.view != View::PathTraced)
        throw SettingError(ErrorKind::Usage, Text("view: {} has no paths to explain", Name(settings.view)));
    PictureSettings decided = settings;
    decided.light = ChooseLight(input, settings);
    decided.crop.reset();  // the pixels of a part have the bits that they have in the whole
    return decided;
}

}  // namespace

double LuminanceOf(const glm::vec3& radiance) {
    return 0.2126 * double{radiance.x} + 0.7152 * double{radiance.y} + 0.0722 * double{radiance.z};
}

struct Explainer::Impl {
    Impl(rhi::Device& device, SceneInput&& input, const PictureSettings& of, const TracingChoice& tracing)
        : settings(of), names(input.data), scene(device, input, settings, ChooseTracing(device, tracing)) {}

    passes::TraceSettings SettingsFor(const glm::uvec2& pixel, uint32_t sample) const {
        passes::TraceSettings traced = scene.SettingsFor(sample);
        traced.region = {pixel.x, pixel.y, 1, 1};
        return traced;
    }

    // Samples that share a frame: all of them see the scene at one time, and with Roulette::Frame each has a
    // length of its own.
    std::vector<glm::vec3> ValuesOf(const glm::uvec2& pixel, uint32_t first, uint32_t count) {
        if (isOnCpu) return CpuValuesOf(pixel, first, count);
        const bool isOneByOne = scene.IsBlurred() || settings.paths.roulette.kind == Roulette::Frame;
        std::vector<glm::vec3> values;
        for (uint32_t done = 0; done < count;) {
            const uint32_t next = isOneByOne ? 1 : std::min(count - done, kMostAtOnce);
            Renderer& renderer = scene.GraphRenderer();
            renderer.BeginFrame();
            const SceneIds ids = scene.Declare(first + done);
            passes::TraceSettings traced = SettingsFor(pixel, first + done);
            traced.sampleCount = next;
            const passes::TraceIds outputs = passes::Trace(renderer, ids, traced);
            const Readback radiance = renderer.ReadBack(outputs.radiance);
            const Readback counts = renderer.ReadBack(outputs.counts);
            renderer.Execute();
            for (const glm::vec4& value : WaitForValues<glm::vec4>(radiance)) values.emplace_back(value);
            nonFiniteSamples += WaitForValues<passes::TraceCounts>(counts).front().nonFiniteSamples;
            done += next;
        }
        return values;
    }

    std::vector<gpu::PathVertexRecord> RecordOf(Explanation& explanation, uint32_t sample) {
        if (isOnCpu) {
            std::vector<gpu::PathVertexRecord> vertices = CpuPathOf(explanation.pixel, sample).vertices;
            explanation.origin = copy->ids.origin;
            explanation.names.NumberLights(copy->ids.lightSet);
            return vertices;
        }
        Renderer& renderer = scene.GraphRenderer();
        renderer.BeginFrame();
        const SceneIds ids = scene.Declare(sample);
        const passes::TraceIds traced =
            passes::Trace(renderer, ids, SettingsFor(explanation.pixel, sample), {.record = true});
        const Readback record = renderer.ReadBack(traced.record);
        renderer.Execute();
        explanation.origin = ids.origin;
        explanation.names.NumberLights(ids.lightSet);
        return passes::PathOf(record);
    }

    // Finds the discarded samples among the black ones.
    void FindDiscarded(Explanation& explanation) {
        for (size_t i = 0; i < explanation.values.size() && explanation.discarded.size() < nonFiniteSamples;
             ++i) {
            const uint32_t sample = explanation.firstSample + static_cast<uint32_t>(i);
            if (explanation.values[i] == glm::vec3(0.0f) && NonFiniteVertex(RecordOf(explanation, sample)))
                explanation.discarded.push_back(sample);
        }
    }

    // Returns the scene as a sample sees it.
    const SceneCopy& CopyFor(uint32_t sample) {
        if (!copy || scene.IsBlurred())
            copy = CopyScene(scene.GraphRenderer(), scene.Scene(), [&] { return scene.Declare(sample); });
        return *copy;
    }

    CpuPath CpuPathOf(const glm::uvec2& pixel, uint32_t sample) {
        const SceneCopy& copied = CopyFor(sample);
        return TraceOnCpu(copied, scene.SettingsFor(sample), pixel);
    }

    std::vector<glm::vec3> CpuValuesOf(const glm::uvec2& pixel, uint32_t first, uint32_t count) {
        std::vector<glm::vec3> values;
        for (uint32_t i = 0; i < count; ++i) {
            const CpuPath path = CpuPathOf(pixel, first + i);
            values.push_back(path.value);
            nonFiniteSamples += NonFiniteVertex(path.vertices) ? 1 : 0;
        }
        return values;
    }

    PictureSettings settings;
    PathNames names;
    DeviceScene scene;
    std::optional<SceneCopy> copy;  // for paths on the CPU
    uint64_t nonFiniteSamples = 0;  // of those of the last pixel
    bool isOnCpu = false;           // of the last request
};

Explainer::Explainer(rhi::Device& device, SceneInput input, const PictureSettings& settings,
                     const TracingChoice& tracing)
    : m_impl(std::make_unique<Impl>(device, std::move(input), Decided(settings, input), tracing)) {}

Explainer::~Explainer() = default;

Explanation Explainer::Explain(const ExplainRequest& request) {
    const Extent2D size = m_impl->settings.size;
    if (request.pixel.x >= size.width || request.pixel.y >= size.height)
        throw MakeError(ErrorKind::Usage, "pixel {},{} is outside of the picture, which has {}x{}",
                        request.pixel.x, request.pixel.y, size.width, size.height);
    const uint32_t first = request.sample.value_or(request.firstSample);
    const uint32_t count = request.sample ? 1 : request.sampleCount;
    if (count == 0) throw Error(ErrorKind::Usage, "no sample is to be explained");
    if (count - 1 > std::numeric_limits<uint32_t>::max() - first)
        throw MakeError(ErrorKind::Usage, "{} samples from {} on go beyond the last one, 4294967295", count,
                        first);

    m_impl->nonFiniteSamples = 0;
    m_impl->isOnCpu = request.isOnCpu;
    Explanation explanation =
        ExplainSamples(request.pixel, first, m_impl->ValuesOf(request.pixel, first, count));
    explanation.names = m_impl->names;
    m_impl->FindDiscarded(explanation);
    for (const uint32_t sample : BrightestOf(explanation, std::max(request.brightest, 1u)))
        explanation.paths.push_back(PathIn(explanation, sample, m_impl->RecordOf(explanation, sample)));
    return explanation;
}

namespace {

std::vector<double> LuminancesOf(std::span<const glm::vec3> values) {
    std::vector<double> luminances;
    for (const glm::vec3& value : values) luminances.push_back(LuminanceOf(value));
    return luminances;
}

struct Spread {
    double mean = 0.0;
    double squares = 0.0;  // sum of the squared deviations
};

Spread SpreadOf(std::span<const double> luminances) {
    Spread spread;
    spread.mean =
        std::accumulate(luminances.begin(), luminances.end(), 0.0) / static_cast<double>(luminances.size());
    for (const double luminance : luminances)
        spread.squares += (luminance - spread.mean) * (luminance - spread.mean);
    return spread;
}

}  // namespace

Explanation ExplainSamples(glm::uvec2 pixel, uint32_t firstSample, std::vector<glm::vec3> values) {
    Explanation explanation{.pixel = pixel, .firstSample = firstSample, .values = std::move(values)};
    const auto count = static_cast<double>(explanation.values.size());
    for (const glm::vec3& value : explanation.values) explanation.mean += glm::dvec3(value) / count;
    const Spread spread = SpreadOf(LuminancesOf(explanation.values));
    if (count > 1.0 && spread.mean > 0.0)
        explanation.relativeError = std::sqrt(spread.squares / (count - 1.0) / count) / spread.mean;
    return explanation;
}

std::vector<uint32_t> BrightestOf(const Explanation& explanation, size_t count) {
    const std::vector<double> luminances = LuminancesOf(explanation.values);
    std::vector<uint32_t> order(luminances.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto isDiscarded = [&](uint32_t i) {
        return std::ranges::count(explanation.discarded, explanation.firstSample + i) > 0;
    };
    std::ranges::stable_sort(order, [&](uint32_t a, uint32_t b) { return luminances[a] > luminances[b]; });
    std::ranges::stable_partition(order, isDiscarded);
    order.resize(std::min(order.size(), count));
    for (uint32_t& sample : order) sample += explanation.firstSample;
    return order;
}

std::optional<size_t> NonFiniteVertex(std::span<const gpu::PathVertexRecord> path) {
    glm::vec3 sum(0.0f);
    for (size_t i = 0; i < path.size(); ++i) {
        sum += path[i].emitted;
        sum += path[i].lit;
        if (!std::isfinite(sum.x) || !std::isfinite(sum.y) || !std::isfinite(sum.z)) return i;
    }
    return std::nullopt;
}

ExplainedPath PathIn(const Explanation& explanation, uint32_t sample,
                     std::vector<gpu::PathVertexRecord> vertices) {
    ExplainedPath path{.sample = sample,
                       .value = explanation.values.at(sample - explanation.firstSample),
                       .vertices = std::move(vertices)};
    path.isExact = HaveSameBits(passes::ValueOf(path.vertices), path.value);
    const Spread spread = SpreadOf(LuminancesOf(explanation.values));
    const double deviation = LuminanceOf(path.value) - spread.mean;
    if (spread.squares > 0.0) path.varianceShare = deviation * deviation / spread.squares;
    return path;
}

Explanation Explain(rhi::Device& device, SceneInput input, const PictureSettings& settings,
                    const ExplainRequest& request) {
    return Explainer(device, std::move(input), settings).Explain(request);
}

}  // namespace raygraph::session
