#include "editor/session/verify/alternatives.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "base/text.h"
#include "editor/session/frames/device_scene.h"
#include "passes/accumulate.h"
#include "passes/trace.h"
#include "renderer/graph/readback_values.h"

namespace raygraph::session {

namespace {

constexpr uint32_t kSamples = 32;
constexpr uint64_t kMostPixels = 4096;
constexpr size_t kMostHidden = 12;

// Returns a size of about kMostPixels, if there are more, of the same proportions.
Extent2D SmallSizeOf(Extent2D size) {
    const double scale = std::min(std::sqrt(double(kMostPixels) / double(PixelCount(size))), 1.0);
    const auto scaled = [&](uint32_t side) {
        return std::max(static_cast<uint32_t>(std::lround(scale * side)), 1u);
    };
    return {scaled(size.width), scaled(size.height)};
}

class Small {
  public:
    Small(rhi::Device& device, const AlternativesRequest& request)
        : m_request(request), m_size(SmallSizeOf(request.picture.size)) {
        m_counts.assign(PixelCount(m_size), 0.0f);
        for (size_t pixel = 0; pixel < PixelCount(request.picture.size); ++pixel) ++m_counts[Of(pixel)];
        PictureSettings settings = request.settings;
        settings.size = m_size;
        settings.lightGroups.clear();
        // This roulette needs a frame for each sample
        if (settings.paths.roulette.kind == Roulette::Frame) settings.paths.roulette = {};
        SceneInput input = request.input;
        m_scene.emplace(device, input, settings);
        m_reference.size = m_picture.size = m_size;
        // Where one picture cannot tell values apart, neither can their means
        m_reference.radiance = Averaged(CutAt(request.reference.radiance, request.picture.white));
        m_picture.radiance = Averaged(CutAt(request.picture.radiance, request.picture.white));
        m_picture.white = request.picture.white;
        Texels noise = Averaged(request.noise);
        for (size_t i = 0; i < noise.size(); ++i) noise[i] /= m_counts[i / 4];
        std::vector<float> relative;
        if (!request.relative.empty()) {
            relative.assign(m_counts.size(), 0.0f);
            for (size_t pixel = 0; pixel < request.relative.size(); ++pixel) {
                float& of = relative[Of(pixel)];
                of = std::max(of, request.relative[pixel]);
            }
        }
        m_residual.emplace(m_reference, m_picture, noise, request.tolerance, relative);
        m_base = Render();
    }

    const Residual& Rest() const { return *m_residual; }
    GpuScene& Scene() { return m_scene->Scene(); }
    // Returns the pixel of a small picture that holds one of the picture.
    size_t Of(size_t pixel) const {
        const Extent2D size = m_request.picture.size;
        const size_t x = pixel % size.width, y = pixel / size.width;
        return y * m_size.height / size.height * m_size.width + x * m_size.width / size.width;
    }
    // Returns the reference with what has changed in the scene.
    Texels Changed() {
        Texels radiance = Render();
        for (size_t i = 0; i < radiance.size(); ++i) radiance[i] += m_reference.radiance[i] - m_base[i];
        return radiance;
    }
    bool IsStopped() const { return m_request.isStopRequested && m_request.isStopRequested(); }

  private:
    Texels Averaged(const Texels& texels) const {
        Texels means(4 * m_counts.size(), 0.0f);
        for (size_t i = 0; i < texels.size(); ++i) means[4 * Of(i / 4) + i % 4] += texels[i];
        for (size_t i = 0; i < means.size(); ++i) means[i] /= m_counts[i / 4];
        return means;
    }
    // Traces all samples in one frame.
    Texels Render() {
        Renderer& renderer = m_scene->GraphRenderer();
        renderer.BeginFrame();
        const SceneIds ids = m_scene->Declare(0);
        passes::TraceSettings settings = m_scene->SettingsFor(0);
        settings.sampleCount = kSamples;
        passes::Accumulation accumulation("alternative");
        const passes::AccumulatedIds mean =
            passes::Accumulate(renderer, passes::Trace(renderer, ids, settings).radiance,
                               {.count = kSamples, .height = m_size.height}, accumulation);
        const Readback readback = renderer.ReadBack(mean.mean);
        renderer.Execute();
        Texels radiance = WaitForValues<float>(readback);
        accumulation.Reset(passes::ResetCause::Start);
        passes::Release(renderer, accumulation);
        return radiance;
    }

    const AlternativesRequest& m_request;
    Extent2D m_size;
    std::vector<float> m_counts;  // of the pixels of the picture in each of a small one
    std::optional<DeviceScene> m_scene;
    Picture m_reference, m_picture;
    std::optional<Residual> m_residual;
    Texels m_base;
};

// Returns whether the light of the environment is a part of the picture, and depends on its rotation.
bool HasTurnableEnvironment(const Diagnosis& diagnosis, const AlternativesRequest& request) {
    if (request.settings.background) return false;
    const bool hasMap = !request.input.environmentFile.empty() ||
                        request.input.data.environment.IsPresent() ||
                        request.settings.light == DefaultLight::Studio;
    if (!hasMap) return false;
    for (const PartFit& part : diagnosis.parts)
        if (part.kind == "light group" && part.name == "environment") return part.share > 0.05;
    return true;
}

void WeighRotations(Diagnosis& diagnosis, Small& small) {
    const EnvironmentSettings asItIs = small.Scene().Environment();
    std::optional<Alternative> best;
    double bestLeft = small.Rest().Squares();
    const auto attempt = [&](double degrees) {
        if (small.IsStopped()) return;
        EnvironmentSettings settings = asItIs;
        settings.rotation += static_cast<float>(glm::radians(degrees));
        small.Scene().SetEnvironment(settings);
        Alternative turned{.kind = "environment rotation",
                           .name = "environment",
                           .text = Text("the environment is turned by {:.0f} degrees", degrees),
                           .radiance = small.Changed(),
                           .amount = degrees};
        const double left = small.Rest().LeftBy(turned.radiance);
        if (left >= bestLeft) return;
        bestLeft = left;
        best = std::move(turned);
    };
    for (int step = 1; step < 12; ++step) attempt(step <= 6 ? 30.0 * step : 30.0 * step - 360.0);
    for (double step = 15.0; best && step > 3.0; step *= 0.5) {
        const double middle = best->amount;
        attempt(middle - step);
        attempt(middle + step);
    }
    small.Scene().SetEnvironment(asItIs);
    if (best) Weigh(diagnosis, small.Rest(), {*best}, false);
}

void WeighObjects(Diagnosis& diagnosis, Small& small, const AlternativesRequest& request) {
    const scene::SceneData& scene = request.input.data;
    // Pixels of the objects of a node
    std::map<uint32_t, size_t> areas;
    const auto nodeOf = [&](uint32_t instance) {
        return instance < scene.instances.size() ? scene.instances[instance].node : scene::kNone;
    };
    for (const scene::Instance& instance : scene.instances)
        if (instance.node != scene::kNone) areas.try_emplace(instance.node, 0);
    for (const uint32_t instance : request.render.instance)
        if (const uint32_t node = nodeOf(instance); node != scene::kNone) ++areas[node];
    std::vector<std::pair<size_t, uint32_t>> nodes;
    for (const auto& [node, area] : areas)
        if (2 * area < request.render.instance.size()) nodes.emplace_back(area, node);
    std::ranges::sort(nodes, std::greater{});
    if (nodes.size() > kMostHidden) nodes.resize(kMostHidden);
    std::map<uint32_t, std::vector<uint32_t>> instances;  // by node
    for (uint32_t i = 0; i < scene.instances.size(); ++i)
        if (small.Scene().IsVisible(i)) instances[scene.instances[i].node].push_back(i);
    for (const auto& [area, node] : nodes) {
        if (small.IsStopped()) return;
        small.Scene().SetVisible(instances[node], false);
        Alternative hidden{
            .kind = "occlusion",
            .name = scene.nodes[node].name.empty() ? std::to_string(node) : scene.nodes[node].name,
            .text = {},
            .radiance = small.Changed(),
            .amount = 1.0};
        small.Scene().SetVisible(instances[node], true);
        hidden.text =
            Text("object `{}` blocks no light: its shadow or occlusion is missing", Printable(hidden.name));
        // It is still seen itself
        for (size_t pixel = 0; pixel < request.render.instance.size(); ++pixel)
            if (nodeOf(request.render.instance[pixel]) == node)
                std::copy_n(&small.Rest().Reference()[4 * small.Of(pixel)], 4,
                            &hidden.radiance[4 * small.Of(pixel)]);
        Weigh(diagnosis, small.Rest(), {hidden}, true);
    }
}

}  // namespace

void WeighAlternatives(Diagnosis& diagnosis, rhi::Device& device, const AlternativesRequest& request) {
    Small small(device, request);
    if (HasTurnableEnvironment(diagnosis, request)) WeighRotations(diagnosis, small);
    if (!request.render.instance.empty()) WeighObjects(diagnosis, small, request);
    Rank(diagnosis);
}

}  // namespace raygraph::session
