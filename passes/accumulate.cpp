#include "passes/accumulate.h"

#include <cstring>
#include <functional>
#include <numeric>
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
    // A step of the open frame.
    AccumulationStep(Renderer& renderer, Accumulation& accumulation, Extent2D extent, bool hasVariance)
        : m_accumulation(accumulation),
          m_frame(renderer.OpenFrame()),
          m_before(accumulation.Current()),
          m_resetCount(accumulation.m_resetCount) {
        m_after = {.progress = m_before.progress, .hasVariance = hasVariance, .extent = extent};
    }

    // Samples in the mean before the pass.
    uint32_t SampleCount() const { return m_sampleCount; }

    // `isLost`: the persistent textures are without contents.
    void StartAnewIfNeeded(bool isLost) {
        if (m_after.progress.IsAtStart()) return;
        if (m_after.hasVariance && !m_before.hasVariance)
            m_cause = ResetCause::Settings;
        else if (isLost || !(m_before.extent == m_after.extent))
            m_cause = ResetCause::Resize;
        if (m_cause != ResetCause::Count) m_after.progress = {};
    }
    void TakeTile(const Region& region) {
        Accumulation::Progress& progress = m_after.progress;
        m_sampleCount = progress.sampleCount;
        if (!progress.cursor.IsNext(m_after.extent, region))
            throw Error(ErrorKind::Usage, "accumulation \"" + m_accumulation.Name() + "\": a tile at " +
                                              std::to_string(region.x) + ", " + std::to_string(region.y) +
                                              " is not what follows; the sample at hand is complete up to " +
                                              std::to_string(progress.cursor.X()) + ", " +
                                              std::to_string(progress.cursor.Y()));
        if (progress.cursor.Advance(m_after.extent, region)) progress.sampleCount++;
    }
    void TakeSamples(uint32_t sampleCount) { m_after.progress = {.sampleCount = sampleCount, .cursor = {}}; }

    // The passes that come after this one in the frame go on from here.
    void Declare() const {
        m_accumulation.m_declared = m_after;
        m_accumulation.m_declaredIn = m_frame;
    }
    void Commit(CommandList& commands) const {
        commands.OnSubmitted([step = *this] { step.Apply(); });
    }

  private:
    void Apply() const {
        if (m_cause != ResetCause::Count) m_accumulation.m_resets[static_cast<size_t>(m_cause)]++;
        m_accumulation.m_state = m_after;
        if (m_accumulation.m_resetCount != m_resetCount) m_accumulation.m_state.progress = {};
    }

    Accumulation& m_accumulation;
    std::weak_ptr<const void> m_frame;
    Accumulation::State m_before, m_after;
    uint32_t m_sampleCount = 0;
    uint64_t m_resetCount;
    ResetCause m_cause = ResetCause::Count;  // Count: it goes on
};

uint32_t Accumulation::ResetCount() const {
    return std::accumulate(m_resets.begin(), m_resets.end(), 0u);
}

void Accumulation::Reset(ResetCause cause) {
    m_state.progress = {};
    m_declaredIn.reset();
    m_resetCount++;
    m_resets[static_cast<size_t>(cause)]++;
}

AccumulatedIds AccumulateTile(Renderer& renderer, TextureId tile, Extent2D picture, const Region& region,
                              Accumulation& accumulation, bool withVariance) {
    const GraphTextureDesc desc{picture, Format::Rgba32Float};
    if (!(renderer.Desc(tile).extent == region.Extent()))
        throw Error(ErrorKind::Usage, "accumulation \"" + accumulation.Name() + "\": a tile of " +
                                          std::to_string(renderer.Desc(tile).extent.width) + "x" +
                                          std::to_string(renderer.Desc(tile).extent.height) +
                                          " texels for a region of " + std::to_string(region.width) + "x" +
                                          std::to_string(region.height));
    AccumulatedIds result;
    result.mean = renderer.Persist(accumulation.Name() + ".mean", desc);
    if (withVariance) result.variance = renderer.Persist(accumulation.Name() + ".variance", desc);

    AccumulationStep step(renderer, accumulation, picture, withVariance);
    step.StartAnewIfNeeded(renderer.IsFresh(result.mean) ||
                           (withVariance && renderer.IsFresh(result.variance)));
    step.TakeTile(region);
    struct Constants {
        uint32_t offset[2];
        uint32_t sampleCount;
    };
    renderer.AddPass(
        "Accumulate", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute(withVariance ? "post/accumulate_variance.comp" : "post/accumulate.comp");
            pass.Reads("newSample", tile);
            pass.Constants(Constants{{region.x, region.y}, step.SampleCount()});
            result.mean = pass.Updates("mean", result.mean);
            if (withVariance) result.variance = pass.Updates("variance", result.variance);
        },
        [step, extent = region.Extent()](CommandList& commands) {
            commands.DispatchOver(extent);
            step.Commit(commands);
        });
    step.Declare();
    return result;
}

AccumulatedIds Accumulate(Renderer& renderer, TextureId sample, Accumulation& accumulation,
                          bool withVariance) {
    const Extent2D extent = renderer.Desc(sample).extent;
    return AccumulateTile(renderer, sample, extent, WholeOf(extent), accumulation, withVariance);
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
    AccumulationStep step(renderer, accumulation, extent, !variance.empty());
    step.TakeSamples(sampleCount);
    if (!variance.empty())
        Upload(renderer, accumulation.Name() + ".variance", extent, variance, [](CommandList&) {});
    Upload(renderer, accumulation.Name() + ".mean", extent, mean,
           [step](CommandList& commands) { step.Commit(commands); });
}

}  // namespace raygraph::passes
