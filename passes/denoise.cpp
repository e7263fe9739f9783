#include "passes/denoise.h"

#include <algorithm>

#include "base/text.h"
#include "passes/add_compute.h"
#include "passes/compare.h"
#include "passes/denoise_network.h"

namespace raygraph::passes {

namespace {

// The squared distance between the means of both halves, over that between two independent renders with as
// many samples. Halves of one Sobol sequence lie further apart. Measured in renders of 2 to 64 samples.
constexpr float kHalvesExcess = 1.17f;

void RequireCounts(const DenoiseInputs& inputs, const DenoiseSettings& settings) {
    const bool hasHalf = settings.firstSamples > 0;
    if (settings.samples == 0 || settings.firstSamples >= settings.samples ||
        hasHalf != inputs.firstHalf.has_value())
        throw MakeError(ErrorKind::Usage, "Denoise: {} samples, {} of them in the first half, which is {}",
                        settings.samples, settings.firstSamples, inputs.firstHalf ? "given" : "not given");
}

// Returns the variance of a sample of the target, and in w whether that is most of the sample's variance.
TextureId VarianceOfTarget(Renderer& renderer, const DenoiseInputs& inputs, uint32_t samples) {
    // Without what is seen, the mean stands for it
    const DenoiseInputs::Seen seen =
        inputs.seen.value_or(DenoiseInputs::Seen{inputs.mean, inputs.mean, inputs.mean});
    const Extent2D extent =
        RequireComparable(renderer, "Denoise", inputs.mean, {inputs.variance, seen.bySamples, seen.squares},
                          Format::Rgba32Float);
    TextureId ofTarget = renderer.CreateTexture("denoise.variance", {extent, Format::Rgba32Float});
    const struct {
        uint32_t hasSeen;
        float unbiased;
    } constants{inputs.seen && samples > 1 ? 1u : 0u,
                samples > 1 ? static_cast<float>(samples) / static_cast<float>(samples - 1) : 1.0f};
    AddCompute(renderer, "DenoiseVariance", "denoise/variance.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("mean", inputs.mean);
        pass.Reads("variance", inputs.variance);
        pass.Reads("seen", seen.bySamples);
        pass.Reads("squares", seen.squares);
        pass.Constants(constants);
        ofTarget = pass.Writes("ofTarget", ofTarget);
    });
    return ofTarget;
}

TextureId HalfError(Renderer& renderer, const DenoiseInputs& inputs, TextureId variance,
                    const DenoiseSettings& settings) {
    const TextureId firstHalf =
        inputs.firstHalf.value_or(inputs.mean);  // Without halves, nothing uses the result
    const Extent2D extent =
        RequireComparable(renderer, "Denoise", inputs.mean, {firstHalf}, Format::Rgba32Float);
    TextureId errors = renderer.CreateTexture("denoise.halfError", {extent, Format::Rg32Float});
    const float first = static_cast<float>(settings.firstSamples);
    const float second = static_cast<float>(settings.samples - settings.firstSamples);
    const struct {
        float perSample, byHalf;
    } constants{1.0f / static_cast<float>(settings.samples), first / (second * kHalvesExcess)};
    AddCompute(renderer, "DenoiseHalfError", "denoise/half_error.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("mean", inputs.mean);
        pass.Reads("variance", variance);
        pass.Reads("firstHalf", firstHalf);
        pass.Constants(constants);
        errors = pass.Writes("errors", errors);
    });
    return errors;
}

TextureId FirstGuide(Renderer& renderer, TextureId noise, const DenoiseFeatures& features, int32_t radius) {
    const Extent2D extent = renderer.Desc(noise).extent;
    TextureId guide = renderer.CreateTexture("denoise.guide", {extent, Format::Rgba32Float});
    AddCompute(renderer, "DenoiseNoiseBound", "denoise/noise_bound.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("noise", noise);
        pass.Reads("albedoFeature", features.albedo);
        pass.Reads("normalFeature", features.normal);
        pass.Reads("target", features.target);
        pass.Constants(radius);
        guide = pass.Writes("guide", guide);
    });
    return guide;
}

void ReadCandidates(PassBuilder& pass, const DenoiseCandidates& candidates) {
    pass.Reads("detailed", candidates[0]);
    pass.Reads("medium", candidates[1]);
    pass.Reads("smoothed", candidates[2]);
}

TextureId Choose(Renderer& renderer, TextureId mean, TextureId noise, const DenoiseCandidates& candidates) {
    const Extent2D extent = renderer.Desc(mean).extent;
    TextureId errors = renderer.CreateTexture("denoise.errors", {extent, Format::Rgba32Float});
    AddCompute(renderer, "DenoiseCandidateErrors", "denoise/candidate_errors.comp", extent,
               [&](PassBuilder& pass) {
                   pass.Reads("mean", mean);
                   pass.Reads("noise", noise);
                   ReadCandidates(pass, candidates);
                   errors = pass.Writes("errors", errors);
               });
    TextureId choice = renderer.CreateTexture("denoise.choice", {extent, Format::Rgba32Float});
    AddCompute(renderer, "DenoiseChoose", "denoise/choose.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("errors", errors);
        choice = pass.Writes("choice", choice);
    });
    return choice;
}

}  // namespace

DenoiseFeatures FeaturesOf(Renderer& renderer, const DenoiseInputs& inputs) {
    const TextureId seen = inputs.seen ? inputs.seen->bySamples : inputs.mean;  // the mean is not used so
    const Extent2D extent = RequireComparable(renderer, "Denoise", inputs.mean,
                                              {inputs.albedo, inputs.normal, seen}, Format::Rgba32Float);
    const auto texture = [&](const char* name) {
        return renderer.CreateTexture(name, {extent, Format::Rgba32Float});
    };
    DenoiseFeatures features{texture("denoise.target"), texture("denoise.albedo"), texture("denoise.normal")};
    AddCompute(renderer, "DenoiseFeatures", "denoise/features.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("albedo", inputs.albedo);
        pass.Reads("normal", inputs.normal);
        pass.Reads("mean", inputs.mean);
        pass.Reads("seen", seen);
        pass.Constants(inputs.seen ? 1u : 0u);
        features.albedo = pass.Writes("albedoFeature", features.albedo);
        features.normal = pass.Writes("normalFeature", features.normal);
        features.target = pass.Writes("target", features.target);
    });
    return features;
}

TextureId NoiseOfMean(Renderer& renderer, const DenoiseInputs& inputs, const DenoiseFeatures& features,
                      const DenoiseSettings& settings) {
    RequireCounts(inputs, settings);
    const Extent2D extent = RequireComparable(renderer, "Denoise", inputs.mean,
                                              {features.target, features.albedo}, Format::Rgba32Float);
    const TextureId variance = VarianceOfTarget(renderer, inputs, settings.samples);
    const TextureId errors = HalfError(renderer, inputs, variance, settings);
    TextureId noise = renderer.CreateTexture("denoise.noise", {extent, Format::Rgba32Float});
    const struct {
        float perSample, samplesOfHalf;
    } constants{
        1.0f / static_cast<float>(settings.samples),
        static_cast<float>(std::min(settings.firstSamples, settings.samples - settings.firstSamples))};
    AddCompute(renderer, "DenoiseNoise", "denoise/noise.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("target", features.target);
        pass.Reads("variance", variance);
        pass.Reads("errors", errors);
        pass.Reads("albedoFeature", features.albedo);
        pass.Reads("normalFeature", features.normal);
        pass.Constants(constants);
        noise = pass.Writes("noise", noise);
    });
    return noise;
}

TextureId Pilot(Renderer& renderer, TextureId guide, const DenoiseFeatures& features) {
    const Extent2D extent = RequireComparable(renderer, "Denoise", guide, {features.albedo, features.normal},
                                              Format::Rgba32Float);
    TextureId pilot = renderer.CreateTexture("denoise.pilot", {extent, Format::Rgba32Float});
    AddCompute(renderer, "DenoisePilot", "denoise/pilot.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("guide", guide);
        pass.Reads("albedoFeature", features.albedo);
        pass.Reads("normalFeature", features.normal);
        pilot = pass.Writes("pilot", pilot);
    });
    return pilot;
}

DenoiseCandidates Candidates(Renderer& renderer, TextureId mean, TextureId guide, TextureId pilot,
                             const DenoiseFeatures& features, uint32_t samples) {
    // The fewer samples there are, the more often a variance is too low. Then a firefly is light that the
    // neighbors miss, and all but the greatest keep their weight
    const float trusted = std::clamp(1024.0f / static_cast<float>(samples), 4.0f, 256.0f);
    const Extent2D extent = RequireComparable(
        renderer, "Denoise", mean, {guide, pilot, features.albedo, features.normal}, Format::Rgba32Float);
    DenoiseCandidates candidates;
    for (TextureId& candidate : candidates)
        candidate = renderer.CreateTexture("denoise.candidate", {extent, Format::Rgba32Float});
    AddCompute(renderer, "DenoiseCandidates", "denoise/guided.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("mean", mean);
        pass.Reads("guide", guide);
        pass.Reads("pilot", pilot);
        pass.Reads("albedoFeature", features.albedo);
        pass.Reads("normalFeature", features.normal);
        pass.Constants(trusted);
        candidates[0] = pass.Writes("detailed", candidates[0]);
        candidates[1] = pass.Writes("medium", candidates[1]);
        candidates[2] = pass.Writes("smoothed", candidates[2]);
    });
    return candidates;
}

TextureId MixByError(Renderer& renderer, TextureId mean, TextureId noise,
                     const DenoiseCandidates& candidates) {
    const Extent2D extent = RequireComparable(
        renderer, "Denoise", mean, {noise, candidates[0], candidates[1], candidates[2]}, Format::Rgba32Float);
    const TextureId choice = Choose(renderer, mean, noise, candidates);
    TextureId estimate = renderer.CreateTexture("denoise.mixed", {extent, Format::Rgba32Float});
    AddCompute(renderer, "DenoiseMix", "denoise/mix.comp", extent, [&](PassBuilder& pass) {
        ReadCandidates(pass, candidates);
        pass.Reads("choice", choice);
        estimate = pass.Writes("estimate", estimate);
    });
    return estimate;
}

TextureId BlendByError(Renderer& renderer, const DenoiseInputs& inputs, TextureId noise, TextureId estimate,
                       uint32_t samples) {
    // Without what is seen, the mean stands for it: the difference of both is 0
    const DenoiseInputs::Seen seen =
        inputs.seen.value_or(DenoiseInputs::Seen{inputs.mean, inputs.mean, inputs.mean});
    const Extent2D extent = RequireComparable(
        renderer, "Denoise", inputs.mean, {noise, estimate, seen.bySamples, seen.byAll}, Format::Rgba32Float);
    TextureId removed = renderer.CreateTexture("denoise.removed", {extent, Format::Rg32Float});
    AddCompute(renderer, "DenoiseRemoved", "denoise/removed.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("mean", inputs.mean);
        pass.Reads("noise", noise);
        pass.Reads("estimate", estimate);
        removed = pass.Writes("removed", removed);
    });
    TextureId denoised = renderer.CreateTexture("denoised", {extent, Format::Rgba32Float});
    constexpr float kMargin = 0.6f, kSamplesOfFullMargin = 256.0f;
    const struct {
        float margin;
        uint32_t isSingle;
    } constants{1.0f + kMargin * std::min(kSamplesOfFullMargin / static_cast<float>(samples), 1.0f),
                samples == 1 ? 1u : 0u};
    AddCompute(renderer, "DenoiseBlend", "denoise/blend.comp", extent, [&](PassBuilder& pass) {
        pass.Reads("mean", inputs.mean);
        pass.Reads("estimate", estimate);
        pass.Reads("removed", removed);
        pass.Reads("seen", seen.bySamples);
        pass.Reads("seenByAll", seen.byAll);
        pass.Constants(constants);
        denoised = pass.Writes("denoised", denoised);
    });
    return denoised;
}

TextureId Denoise(Renderer& renderer, const DenoiseInputs& inputs, const DenoiseSettings& settings) {
    RequireComparable(renderer, "Denoise", inputs.mean, {inputs.variance}, Format::Rgba32Float);
    const DenoiseFeatures features = FeaturesOf(renderer, inputs);
    const TextureId noise = NoiseOfMean(renderer, inputs, features, settings);
    TextureId estimate;
    if (settings.denoiser == Denoiser::Network &&
        FitsNetwork(renderer.Device().Info(), renderer.Desc(inputs.mean).extent)) {
        estimate = PredictDenoised(renderer, {.mean = inputs.mean,
                                              .target = features.target,
                                              .noise = noise,
                                              .albedo = features.albedo,
                                              .normal = features.normal,
                                              .samples = settings.samples});
    } else {
        const TextureId guide = FirstGuide(renderer, noise, features, settings.samples < 8 ? 2 : 1);
        const TextureId pilot = Pilot(renderer, guide, features);
        estimate = MixByError(renderer, inputs.mean, noise,
                              Candidates(renderer, inputs.mean, guide, pilot, features, settings.samples));
    }
    return BlendByError(renderer, inputs, noise, estimate, settings.samples);
}

}  // namespace raygraph::passes
