#include "passes/denoise_network.h"

#include <array>
#include <cmath>
#include <cstring>
#include <glm/gtc/packing.hpp>

#include "base/check.h"
#include "base/embed_file.h"
#include "base/text.h"
#include "passes/add_compute.h"
#include "passes/compare.h"

// Written by tests/denoise/network/train.py.
RAYGRAPH_EMBED_FILE(raygraph_network_weights, __FILE__ ".bin");

namespace raygraph::passes {

namespace {

constexpr uint32_t kFeatures = 16;                          // of a pixel, as in denoise/network/features.comp
constexpr uint32_t kKernels = 4 * 28;                       // channels of the kernels of 2 x 2 pixels
constexpr std::array<uint32_t, 4> kWidths{64, 80, 88, 80};  // channels of the levels

// A layer has `source` channels of one picture and `skip` of another as its input.
struct Layer {
    uint32_t source, skip, result;
    uint32_t taps;  // 3 x 3, or 1

    size_t WeightCount() const { return size_t{result} * (1 + (source + skip) * taps * taps); }
};

constexpr uint32_t kLevels = 4;
// In the order of their use: two layers of each level downwards, two of each upwards but the last, and
// kernels of each from the coarsest to the finest.
constexpr std::array<Layer, 18> kLayers = [] {
    std::array<Layer, 18> layers{};
    size_t next = 0;
    uint32_t before = 4 * kFeatures;
    for (uint32_t level = 0; level < kLevels; ++level) {
        layers[next++] = {before, 0, kWidths[level], 3};
        layers[next++] = {kWidths[level], 0, kWidths[level], 3};
        before = kWidths[level];
    }
    layers[next++] = {before, 0, kKernels, 1};
    for (uint32_t level = kLevels - 1; level-- > 0;) {
        layers[next++] = {before, kWidths[level], kWidths[level], 3};
        layers[next++] = {kWidths[level], 0, kWidths[level], 3};
        layers[next++] = {kWidths[level], 0, kKernels, 1};
        before = kWidths[level];
    }
    return layers;
}();

Extent2D Half(Extent2D extent) {
    return {(extent.width + 1) / 2, (extent.height + 1) / 2};
}

uint64_t BytesOf(Extent2D extent, uint32_t channels) {
    return uint64_t{2} * channels * extent.width * extent.height;
}

// Channels of a picture, as halves.
struct Planes {
    BufferId buffer;
    Extent2D extent;
    uint32_t channels = 0;
};

class NetworkFrame {
  public:
    NetworkFrame(Renderer& renderer, const NetworkInputs& inputs, NetworkWeights weights)
        : m_renderer(renderer), m_inputs(inputs) {
        m_extent = RequireComparable(renderer, "PredictDenoised", inputs.mean,
                                     {inputs.target, inputs.noise, inputs.albedo, inputs.normal},
                                     Format::Rgba32Float);
        if (weights.size() != NetworkWeightCount())
            throw MakeError(ErrorKind::Usage, "PredictDenoised: {} weights instead of {}", weights.size(),
                            NetworkWeightCount());
        if (!FitsNetwork(renderer.Device().Info(), m_extent))
            throw MakeError(ErrorKind::Usage, "PredictDenoised: {}x{} pixels are too many for the device",
                            m_extent.width, m_extent.height);
        m_weights = KeepWeights(weights);
        const rhi::DeviceInfo& device = renderer.Device().Info();
        m_usesLanes = device.type == rhi::DeviceType::Cpu && device.subgroupSize % 8 == 0;
    }

    TextureId Declare() {
        std::array<TextureId, kLevels> lights;
        lights[0] = Texture("network.light", m_extent);
        Planes planes = Features(lights[0]);
        for (uint32_t level = 1; level < kLevels; ++level) lights[level] = Halved(lights[level - 1]);
        std::array<Planes, kLevels> skips;
        for (uint32_t level = 0; level < kLevels; ++level) {
            planes = Convolve(planes, {}, level > 0 ? Half(planes.extent) : planes.extent);
            skips[level] = planes = Convolve(planes, {}, planes.extent);
        }
        TextureId result = Apply(planes, lights[kLevels - 1], {}, false);
        for (uint32_t level = kLevels - 1; level-- > 0;) {
            planes = Convolve(planes, skips[level], skips[level].extent);
            planes = Convolve(planes, {}, planes.extent);
            result = Apply(planes, lights[level], result, level == 0);
        }
        return result;
    }

  private:
    TextureId Texture(const char* name, Extent2D extent, Format format = Format::Rgba32Float) {
        return m_renderer.CreateTexture(name, {extent, format});
    }
    Planes CreatePlanes(const char* name, Extent2D extent, uint32_t channels) {
        return {m_renderer.CreateBuffer(name, {.size = BytesOf(extent, channels)}), extent, channels};
    }

    BufferId KeepWeights(NetworkWeights weights) {
        const uint64_t bytes = weights.size() * sizeof(float);
        BufferId kept = m_renderer.PersistBuffer("network.weights", {.size = bytes});
        if (!m_renderer.IsFresh(kept)) return kept;
        const BufferId staging =
            m_renderer.CreateBuffer("network.staging", {.size = bytes, .memory = rhi::MemoryKind::Upload});
        m_renderer.AddPass(
            "UploadNetwork", PassKind::Transfer,
            [&](PassBuilder& pass) {
                pass.CopiesFrom(staging);
                kept = pass.CopiesTo(kept);
            },
            [staging, kept, weights, bytes](CommandList& commands, const PassResources& resources) {
                std::byte* to = resources.Buffer(staging).Mapped().data();
                for (const uint16_t weight : weights) {
                    const float value = glm::unpackHalf1x16(weight);
                    std::memcpy(to, &value, sizeof(value));
                    to += sizeof(value);
                }
                commands.CopyBuffer(resources.Buffer(staging), 0, resources.Buffer(kept), 0, bytes);
            });
        return kept;
    }

    TextureId Exposure() {
        const Extent2D blocks{(m_extent.width + 15) / 16, (m_extent.height + 15) / 16};
        TextureId sums = Texture("network.sums", blocks, Format::Rg32Float);
        AddCompute(m_renderer, "NetworkSums", "denoise/network/sums.comp", blocks, [&](PassBuilder& pass) {
            pass.Reads("target", m_inputs.target);
            sums = pass.Writes("sums", sums);
        });
        TextureId exposure = Texture("network.exposure", {1, 1}, Format::R32Float);
        m_renderer.AddPass(
            "NetworkExposure", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("denoise/network/exposure.comp");
                pass.Reads("sums", sums);
                exposure = pass.Writes("exposure", exposure);
            },
            [](CommandList& commands) { commands.Dispatch(1); });
        return exposure;
    }

    Planes Features(TextureId& light) {
        const TextureId exposure = Exposure();
        Planes planes = CreatePlanes("network.features", Half(m_extent), 4 * kFeatures);
        m_renderer.AddPass(
            "NetworkFeatures", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute("denoise/network/features.comp");
                pass.Reads("target", m_inputs.target);
                pass.Reads("noise", m_inputs.noise);
                pass.Reads("albedo", m_inputs.albedo);
                pass.Reads("normal", m_inputs.normal);
                pass.Reads("exposure", exposure);
                pass.Constants(1.0f / std::sqrt(static_cast<float>(m_inputs.samples)));
                light = pass.Writes("light", light);
                planes.buffer = pass.Writes("planes", planes.buffer);
            },
            [extent = planes.extent](CommandList& commands) { commands.DispatchOver(extent); });
        return planes;
    }

    TextureId Halved(TextureId finer) {
        const Extent2D extent = Half(m_renderer.Desc(finer).extent);
        TextureId coarser = Texture("network.light", extent);
        AddCompute(m_renderer, "NetworkHalve", "denoise/network/halve.comp", extent, [&](PassBuilder& pass) {
            pass.Reads("finer", finer);
            coarser = pass.Writes("coarser", coarser);
        });
        return coarser;
    }

    // Declares the next layer. The source is doubled or halved if the result has another extent.
    Planes Convolve(const Planes& source, const Planes& skip, Extent2D extent) {
        const Layer& layer = kLayers[m_nextLayer++];
        RG_CHECK(layer.source == source.channels && layer.skip == skip.channels);
        Planes result = CreatePlanes("network.planes", extent, layer.result);
        const bool isPoint = layer.taps == 1;
        const bool isStrided = extent == Half(source.extent) && extent != source.extent;
        const bool isDoubled = source.extent == Half(extent) && extent != source.extent;
        const struct {
            glm::ivec2 size, sourceSize;
            uint32_t sourceBlocks, skipBlocks, firstWeight, doubling;
            float slope;
        } constants{glm::ivec2(extent.width, extent.height),
                    glm::ivec2(source.extent.width, source.extent.height),
                    layer.source / 4,
                    layer.skip / 4,
                    m_nextWeight / 8,
                    isDoubled ? 1u : 0u,
                    isPoint ? 1.0f : 0.1f};
        m_nextWeight += static_cast<uint32_t>(layer.WeightCount());
        m_renderer.AddPass(
            "NetworkConvolve", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute(std::string("denoise/network/convolve") +
                             (isPoint     ? "_point"
                              : isStrided ? "_strided"
                                          : "") +
                             (m_usesLanes ? "_lanes" : "") + ".comp");
                pass.Reads("source", source.buffer);
                if (!isPoint && !isStrided) pass.Reads("skip", layer.skip > 0 ? skip.buffer : source.buffer);
                pass.Reads("weights", m_weights);
                pass.Constants(constants);
                result.buffer = pass.Writes("result", result.buffer);
            },
            [extent, groups = layer.result / 8](CommandList& commands) {
                commands.Dispatch((extent.width + 31) / 32, (extent.height + 7) / 8, groups);
            });
        return result;
    }

    TextureId Apply(const Planes& planes, TextureId light, TextureId coarser, bool isFinest) {
        const Planes kernels = Convolve(planes, {}, planes.extent);
        TextureId result = Texture("network.result", m_renderer.Desc(light).extent);
        m_renderer.AddPass(
            "NetworkApply", PassKind::Compute,
            [&](PassBuilder& pass) {
                pass.Compute(!coarser.IsValid() ? "denoise/network/apply_coarsest.comp"
                             : isFinest         ? "denoise/network/apply_finest.comp"
                                                : "denoise/network/apply.comp");
                pass.Reads("kernels", kernels.buffer);
                pass.Reads("light", light);
                if (coarser.IsValid()) pass.Reads("coarser", coarser);
                if (isFinest) {
                    pass.Reads("albedo", m_inputs.albedo);
                    pass.Reads("mean", m_inputs.mean);
                    pass.Reads("target", m_inputs.target);
                }
                result = pass.Writes("result", result);
            },
            [extent = planes.extent](CommandList& commands) { commands.DispatchOver(extent); });
        return result;
    }

    Renderer& m_renderer;
    const NetworkInputs& m_inputs;
    Extent2D m_extent;
    BufferId m_weights;
    bool m_usesLanes = false;  // see denoise/network/convolve_main.glsl
    size_t m_nextLayer = 0;
    uint32_t m_nextWeight = 0;
};

}  // namespace

bool FitsNetwork(const rhi::DeviceInfo& device, Extent2D extent) {
    return BytesOf(Half(extent), kKernels) <= device.maxStorageBufferBytes;
}

size_t NetworkWeightCount() {
    size_t count = 0;
    for (const Layer& layer : kLayers) count += layer.WeightCount();
    return count;
}

NetworkWeights TrainedWeights() {
    return {reinterpret_cast<const uint16_t*>(raygraph_network_weights), NetworkWeightCount()};
}

TextureId PredictDenoised(Renderer& renderer, const NetworkInputs& inputs, NetworkWeights weights) {
    return NetworkFrame(renderer, inputs, weights).Declare();
}

}  // namespace raygraph::passes
