#include "passes/accumulate.h"

#include <cstring>

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

// The passes' way to an Accumulation's count and extent.
struct AccumulationAccess {
    static uint32_t& SampleCount(Accumulation& a) { return a.m_sampleCount; }
    static Extent2D& Extent(Accumulation& a) { return a.m_extent; }
    static bool& HasVariance(Accumulation& a) { return a.m_hasVariance; }
};

void Accumulation::Reset(ResetCause cause) {
    m_sampleCount = 0;
    m_resets[static_cast<size_t>(cause)]++;
}

AccumulatedIds Accumulate(Renderer& renderer, TextureId sample, Accumulation& accumulation,
                          bool withVariance) {
    const GraphTextureDesc desc{renderer.Desc(sample).extent, Format::Rgba32Float};
    AccumulatedIds result;
    result.mean = renderer.Persist(accumulation.Name() + ".mean", desc);
    if (withVariance) result.variance = renderer.Persist(accumulation.Name() + ".variance", desc);

    if (accumulation.SampleCount() > 0 && withVariance && !AccumulationAccess::HasVariance(accumulation))
        accumulation.Reset(ResetCause::Settings);
    // The persistent textures hold `count` samples, unless they were made for this frame or cover another
    // extent
    const bool isResized = !(AccumulationAccess::Extent(accumulation) == desc.extent);
    const bool isLost = renderer.IsFresh(result.mean) || (withVariance && renderer.IsFresh(result.variance));
    if (accumulation.SampleCount() > 0 && (isResized || isLost)) accumulation.Reset(ResetCause::Resize);
    AccumulationAccess::Extent(accumulation) = desc.extent;

    renderer.AddPass(
        "Accumulate", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute(withVariance ? "post/accumulate_variance.comp" : "post/accumulate.comp");
            pass.Reads("newSample", sample);
            pass.Constants(accumulation.SampleCount());
            result.mean = pass.Updates("mean", result.mean);
            if (withVariance) result.variance = pass.Updates("variance", result.variance);
        },
        [extent = desc.extent, withVariance, &accumulation](CommandList& commands) {
            commands.DispatchOver(extent);
            AccumulationAccess::SampleCount(accumulation)++;
            AccumulationAccess::HasVariance(accumulation) = withVariance;
        });
    return result;
}

namespace {

TextureId Upload(Renderer& renderer, const std::string& name, Extent2D extent,
                 std::span<const float> texels) {
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
        [staging, target, texels = std::vector<float>(texels.begin(), texels.end())](
            CommandList& commands, const PassResources& resources) {
            const rhi::Buffer& buffer = resources.Buffer(staging);
            std::memcpy(buffer.Mapped().data(), texels.data(), texels.size() * sizeof(float));
            commands.CopyToTexture(buffer, 0, resources.Texture(target));
        });
    return target;
}

}  // namespace

void Restore(Renderer& renderer, Accumulation& accumulation, Extent2D extent, uint32_t sampleCount,
             std::span<const float> mean, std::span<const float> variance) {
    std::ignore = Upload(renderer, accumulation.Name() + ".mean", extent, mean);
    if (!variance.empty())
        std::ignore = Upload(renderer, accumulation.Name() + ".variance", extent, variance);
    AccumulationAccess::SampleCount(accumulation) = sampleCount;
    AccumulationAccess::HasVariance(accumulation) = !variance.empty();
    AccumulationAccess::Extent(accumulation) = extent;
}

}  // namespace raygraph::passes
