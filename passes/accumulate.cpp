#include "passes/accumulate.h"

#include <cstring>
#include <functional>
#include <utility>

#include "base/error.h"

namespace raygraph::passes {

const char* Name(ResetCause cause) {
    switch (cause) {
        case ResetCause::Start:
            return "start";
        case ResetCause::Camera:
            return "camera";
        case ResetCause::Transform:
            return "transform";
        case ResetCause::Material:
            return "material";
        case ResetCause::Light:
            return "light";
        case ResetCause::Geometry:
            return "geometry";
        case ResetCause::Environment:
            return "environment";
        case ResetCause::Resize:
            return "resize";
        case ResetCause::Settings:
            return "settings";
        case ResetCause::Count:
            break;
    }
    return "unknown";
}

// What a declared pass will have made of an Accumulation; takes effect when the frame is submitted.
class AccumulationStep {
  public:
    AccumulationStep(Accumulation& accumulation, Extent2D extent, bool hasVariance)
        : m_accumulation(accumulation),
          m_extent(extent),
          m_hasVariance(hasVariance),
          m_sampleCount(accumulation.m_sampleCount),
          m_resetCount(accumulation.m_resetCount) {}

    Extent2D Extent() const { return m_extent; }
    // Samples in the mean before the pass.
    uint32_t SampleCount() const { return m_sampleCount; }

    // `isLost`: the persistent textures are without contents.
    void StartAnewIfNeeded(bool isLost) {
        if (m_sampleCount == 0) return;
        if (m_hasVariance && !m_accumulation.m_hasVariance)
            m_cause = ResetCause::Settings;
        else if (isLost || !(m_accumulation.m_extent == m_extent))
            m_cause = ResetCause::Resize;
        if (m_cause != ResetCause::Count) m_sampleCount = 0;
    }
    void Take(CommandList& commands, uint32_t sampleCount) {
        commands.OnSubmitted([step = *this, sampleCount] { step.Apply(sampleCount); });
    }

  private:
    void Apply(uint32_t sampleCount) const {
        if (m_cause != ResetCause::Count) m_accumulation.m_resets[static_cast<size_t>(m_cause)]++;
        m_accumulation.m_extent = m_extent;
        m_accumulation.m_hasVariance = m_hasVariance;
        const bool isResetSince = m_accumulation.m_resetCount != m_resetCount;
        m_accumulation.m_sampleCount = isResetSince ? 0 : sampleCount;
    }

    Accumulation& m_accumulation;
    Extent2D m_extent;
    bool m_hasVariance;
    uint32_t m_sampleCount;
    uint64_t m_resetCount;
    ResetCause m_cause = ResetCause::Count;  // Count: it goes on
};

void Accumulation::Reset(ResetCause cause) {
    m_sampleCount = 0;
    m_resetCount++;
    m_resets[static_cast<size_t>(cause)]++;
}

AccumulatedIds Accumulate(Renderer& renderer, TextureId sample, Accumulation& accumulation,
                          bool withVariance) {
    const GraphTextureDesc desc{renderer.Desc(sample).extent, Format::Rgba32Float};
    AccumulatedIds result;
    result.mean = renderer.Persist(accumulation.Name() + ".mean", desc);
    if (withVariance) result.variance = renderer.Persist(accumulation.Name() + ".variance", desc);

    AccumulationStep step(accumulation, desc.extent, withVariance);
    step.StartAnewIfNeeded(renderer.IsFresh(result.mean) ||
                           (withVariance && renderer.IsFresh(result.variance)));
    renderer.AddPass(
        "Accumulate", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute(withVariance ? "post/accumulate_variance.comp" : "post/accumulate.comp");
            pass.Reads("newSample", sample);
            pass.Constants(step.SampleCount());
            result.mean = pass.Updates("mean", result.mean);
            if (withVariance) result.variance = pass.Updates("variance", result.variance);
        },
        [step](CommandList& commands) mutable {
            commands.DispatchOver(step.Extent());
            step.Take(commands, step.SampleCount() + 1);
        });
    return result;
}

namespace {

void Upload(Renderer& renderer, const std::string& name, Extent2D extent, std::span<const float> texels,
            std::function<void(CommandList&)> andThen) {
    const size_t expected = size_t{4} * extent.width * extent.height;
    if (texels.size() != expected)
        throw Error(ErrorKind::Usage, "accumulation \"" + name + "\": " + std::to_string(texels.size()) +
                                          " floats to restore, " + std::to_string(extent.width) + "x" +
                                          std::to_string(extent.height) + " rgba needs " +
                                          std::to_string(expected));
    TextureId target = renderer.Persist(name, {extent, Format::Rgba32Float});
    BufferId staging = renderer.CreateBuffer(
        name + ".restored", {.size = texels.size_bytes(), .memory = rhi::MemoryKind::Upload});
    renderer.AddPass(
        "Restore", PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.CopiesFrom(staging);
            target = pass.CopiesTo(target);
            pass.KeepAlive();
        },
        [staging, target, texels = std::vector<float>(texels.begin(), texels.end()),
         andThen = std::move(andThen)](CommandList& commands, const PassResources& resources) {
            const rhi::Buffer& buffer = resources.Buffer(staging);
            std::memcpy(buffer.Mapped().data(), texels.data(), texels.size() * sizeof(float));
            commands.CopyToTexture(buffer, 0, resources.Texture(target));
            andThen(commands);
        });
}

}  // namespace

void Restore(Renderer& renderer, Accumulation& accumulation, Extent2D extent, uint32_t sampleCount,
             std::span<const float> mean, std::span<const float> variance) {
    AccumulationStep step(accumulation, extent, !variance.empty());
    if (!variance.empty())
        Upload(renderer, accumulation.Name() + ".variance", extent, variance, [](CommandList&) {});
    Upload(renderer, accumulation.Name() + ".mean", extent, mean,
           [step, sampleCount](CommandList& commands) mutable { step.Take(commands, sampleCount); });
}

}  // namespace raygraph::passes
