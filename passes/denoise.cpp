#include "passes/denoise.h"

#include <algorithm>

#include "base/text.h"
#include "passes/compare.h"

namespace raygraph::passes {

namespace {

// Two halves of one low-discrepancy sequence lie further apart than two independent renders: this much in the
// square, in renders of 2 to 64 samples (docs/denoise.md).
constexpr float kHalvesExcess = 1.17f;

Extent2D RequireAll(const Renderer& renderer, TextureId mean, std::initializer_list<TextureId> others) {
    Extent2D extent;
    for (const TextureId other : others)
        extent = RequireComparable(renderer, "Denoise", mean, other, Format::Rgba32Float);
    return extent;
}

void RequireCounts(const DenoiseInputs& inputs, const DenoiseSettings& settings) {
    const bool hasHalf = settings.firstSamples > 0;
    if (settings.samples == 0 || settings.firstSamples >= settings.samples ||
        hasHalf != inputs.firstHalf.has_value())
        throw MakeError(ErrorKind::Usage, "Denoise: {} samples, {} of them in the first half, which is {}",
                        settings.samples, settings.firstSamples, inputs.firstHalf ? "given" : "not given");
}

TextureId HalfError(Renderer& renderer, const DenoiseInputs& inputs, const DenoiseSettings& settings) {
    const TextureId firstHalf =
        inputs.firstHalf.value_or(inputs.mean);  // Without halves, nothing uses the result
    const Extent2D extent = RequireAll(renderer, inputs.mean, {firstHalf});
    TextureId errors = renderer.CreateTexture("denoise.halfError", {extent, Format::Rg32Float});
    const float first = static_cast<float>(settings.firstSamples);
    const float second = static_cast<float>(settings.samples - settings.firstSamples);
    const struct {
        float perSample, byHalf;
    } constants{1.0f / static_cast<float>(settings.samples), first / (second * kHalvesExcess)};
    renderer.AddPass(
        "DenoiseHalfError", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("denoise/half_error.comp");
            pass.Reads("mean", inputs.mean);
            pass.Reads("variance", inputs.variance);
            pass.Reads("firstHalf", firstHalf);
            pass.Constants(constants);
            errors = pass.Writes("errors", errors);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return errors;
}

TextureId NoiseBound(Renderer& renderer, TextureId noise, const DenoiseFeatures& features, int32_t radius) {
    const Extent2D extent = renderer.Desc(noise).extent;
    TextureId bound = renderer.CreateTexture("denoise.bound", {extent, Format::Rgba32Float});
    renderer.AddPass(
        "DenoiseNoiseBound", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("denoise/noise_bound.comp");
            pass.Reads("noise", noise);
            pass.Reads("albedoFeature", features.albedo);
            pass.Reads("normalFeature", features.normal);
            pass.Constants(radius);
            bound = pass.Writes("bound", bound);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return bound;
}

TextureId Choose(Renderer& renderer, TextureId mean, TextureId noise, TextureId pilot, TextureId detailed,
                 TextureId smoothed) {
    const Extent2D extent = renderer.Desc(mean).extent;
    TextureId errors = renderer.CreateTexture("denoise.errors", {extent, Format::Rg32Float});
    renderer.AddPass(
        "DenoiseCandidateErrors", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("denoise/candidate_errors.comp");
            pass.Reads("mean", mean);
            pass.Reads("noise", noise);
            pass.Reads("pilot", pilot);
            pass.Reads("detailed", detailed);
            pass.Reads("smoothed", smoothed);
            errors = pass.Writes("errors", errors);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    TextureId choice = renderer.CreateTexture("denoise.choice", {extent, Format::R32Float});
    renderer.AddPass(
        "DenoiseChoose", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("denoise/choose.comp");
            pass.Reads("errors", errors);
            choice = pass.Writes("choice", choice);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return choice;
}

}  // namespace

DenoiseFeatures SurfaceFeatures(Renderer& renderer, TextureId albedo, TextureId normal) {
    const Extent2D extent = RequireAll(renderer, albedo, {normal});
    DenoiseFeatures features{
        renderer.CreateTexture("denoise.albedo", {extent, Format::Rgba32Float}),
        renderer.CreateTexture("denoise.normal", {extent, Format::Rgba32Float}),
    };
    renderer.AddPass(
        "DenoiseFeatures", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("denoise/features.comp");
            pass.Reads("albedo", albedo);
            pass.Reads("normal", normal);
            features.albedo = pass.Writes("albedoFeature", features.albedo);
            features.normal = pass.Writes("normalFeature", features.normal);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return features;
}

TextureId NoiseOfMean(Renderer& renderer, const DenoiseInputs& inputs, const DenoiseFeatures& features,
                      const DenoiseSettings& settings) {
    RequireCounts(inputs, settings);
    const Extent2D extent = RequireAll(renderer, inputs.mean, {inputs.variance, features.albedo});
    const TextureId errors = HalfError(renderer, inputs, settings);
    TextureId noise = renderer.CreateTexture("denoise.noise", {extent, Format::Rgba32Float});
    const struct {
        float perSample, samplesOfHalf;
    } constants{
        1.0f / static_cast<float>(settings.samples),
        static_cast<float>(std::min(settings.firstSamples, settings.samples - settings.firstSamples))};
    renderer.AddPass(
        "DenoiseNoise", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("denoise/noise.comp");
            pass.Reads("mean", inputs.mean);
            pass.Reads("variance", inputs.variance);
            pass.Reads("errors", errors);
            pass.Reads("albedoFeature", features.albedo);
            pass.Reads("normalFeature", features.normal);
            pass.Constants(constants);
            noise = pass.Writes("noise", noise);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return noise;
}

TextureId Regress(Renderer& renderer, TextureId mean, TextureId guide, TextureId bound,
                  const DenoiseFeatures& features, const RegressionSettings& settings) {
    const Extent2D extent = RequireAll(renderer, mean, {guide, bound, features.albedo, features.normal});
    if (settings.patchRadius > 2)
        throw MakeError(ErrorKind::Usage, "Denoise: a patch radius of {}; 2 is the largest",
                        settings.patchRadius);
    TextureId estimate = renderer.CreateTexture("denoise.estimate", {extent, Format::Rgba32Float});
    const struct {
        int32_t patchRadius;
        float noiseScale;
        uint32_t isEstimate;
    } constants{static_cast<int32_t>(settings.patchRadius), settings.bandwidth * settings.bandwidth,
                settings.isEstimate ? 1u : 0u};
    renderer.AddPass(
        "DenoiseRegress", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("denoise/regress.comp");
            pass.Reads("mean", mean);
            pass.Reads("guide", guide);
            pass.Reads("bound", bound);
            pass.Reads("albedoFeature", features.albedo);
            pass.Reads("normalFeature", features.normal);
            pass.Constants(constants);
            estimate = pass.Writes("estimate", estimate);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return estimate;
}

TextureId BlendByError(Renderer& renderer, TextureId mean, TextureId noise, TextureId pilot,
                       TextureId detailed, TextureId smoothed, bool isSingle) {
    const Extent2D extent = RequireAll(renderer, mean, {noise, pilot, detailed, smoothed});
    const TextureId choice = Choose(renderer, mean, noise, pilot, detailed, smoothed);
    TextureId estimate = renderer.CreateTexture("denoise.mixed", {extent, Format::Rgba32Float});
    TextureId removed = renderer.CreateTexture("denoise.removed", {extent, Format::Rg32Float});
    renderer.AddPass(
        "DenoiseMix", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("denoise/mix.comp");
            pass.Reads("mean", mean);
            pass.Reads("noise", noise);
            pass.Reads("detailed", detailed);
            pass.Reads("smoothed", smoothed);
            pass.Reads("choice", choice);
            estimate = pass.Writes("estimate", estimate);
            removed = pass.Writes("removed", removed);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    TextureId denoised = renderer.CreateTexture("denoised", {extent, Format::Rgba32Float});
    renderer.AddPass(
        "DenoiseBlend", PassKind::Compute,
        [&](PassBuilder& pass) {
            pass.Compute("denoise/blend.comp");
            pass.Reads("mean", mean);
            pass.Reads("estimate", estimate);
            pass.Reads("removed", removed);
            pass.Constants(isSingle ? 1u : 0u);
            denoised = pass.Writes("denoised", denoised);
        },
        [extent](CommandList& commands) { commands.DispatchOver(extent); });
    return denoised;
}

TextureId Denoise(Renderer& renderer, const DenoiseInputs& inputs, const DenoiseSettings& settings) {
    RequireAll(renderer, inputs.mean, {inputs.variance, inputs.albedo, inputs.normal});
    const DenoiseFeatures features = SurfaceFeatures(renderer, inputs.albedo, inputs.normal);
    const TextureId noise = NoiseOfMean(renderer, inputs, features, settings);
    const TextureId bound = NoiseBound(renderer, noise, features, settings.samples < 8 ? 2 : 1);
    const TextureId pilot = Regress(renderer, inputs.mean, inputs.mean, bound, features, {});
    const auto guided = [&](float bandwidth) {
        return Regress(renderer, inputs.mean, pilot, bound, features,
                       {.patchRadius = 1, .bandwidth = bandwidth, .isEstimate = true});
    };
    return BlendByError(renderer, inputs.mean, noise, pilot, guided(0.7f), guided(2.0f),
                        settings.samples == 1);
}

}  // namespace raygraph::passes
