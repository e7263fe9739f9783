// Denoise: a picture with less noise, for finished renders. Threads: that of the Renderer.
#pragma once

#include <optional>

#include "base/api.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// All are rgba32f and of one extent. Values that are infinite or NaN count as 0.
struct DenoiseInputs {
    TextureId mean;            // radiance, the mean of the samples; alpha is kept
    TextureId variance;        // unbiased, of one sample, as Resolve returns it; not used for a single sample
    TextureId albedo, normal;  // means over the samples at the first hit, as PrimaryHits returns them
    // The mean of the first samples alone. Without it samples count as independent: where the sampler is
    // better than that, too much is taken for noise, and with many samples details suffer.
    std::optional<TextureId> firstHalf;
};

struct DenoiseSettings {
    uint32_t samples = 1;       // of each pixel
    uint32_t firstSamples = 0;  // those of `firstHalf`: about half, less than `samples`
};

// Returns the picture, rgba32f. The radiance is regressed on albedo, normal and position (Bitterli et al.
// 2016, "Nonlinearly Weighted First-order Regression for Denoising Monte Carlo Renderings") with weights of
// non-local means, twice: the second time these are taken from the first result, with two bandwidths, of
// which the one with the smaller estimated error (Stein 1981) is used in each place. The result is blended
// with the mean by how much of their difference noise explains, so that it is the mean where there is no
// noise. docs/denoise.md has measured errors. Throws Error{Usage} for textures of other formats or extents,
// and for counts that contradict each other.
[[nodiscard]] RAYGRAPH_API TextureId Denoise(Renderer& renderer, const DenoiseInputs& inputs,
                                             const DenoiseSettings& settings);

// The steps of Denoise, each for itself.

// Features of surfaces: mean albedo and normal, w being four times the squared gradient.
struct DenoiseFeatures {
    TextureId albedo, normal;
};
[[nodiscard]] RAYGRAPH_API DenoiseFeatures SurfaceFeatures(Renderer& renderer, TextureId albedo,
                                                           TextureId normal);

// The variance of the mean in each channel, rgba32f.
[[nodiscard]] RAYGRAPH_API TextureId NoiseOfMean(Renderer& renderer, const DenoiseInputs& inputs,
                                                 const DenoiseFeatures& features,
                                                 const DenoiseSettings& settings);

struct RegressionSettings {
    uint32_t patchRadius = 2;  // at most 2
    float bandwidth = 1.0f;    // of the weights, in standard deviations of the guide; more smooths more
    bool isEstimate = false;   // the guide is what Regress returned, so that its w is how noisy it still is
};
// Returns the fit of `mean` at each pixel, rgba32f; w is the share that the pixel's own value has in it.
// `bound` is the variance of the mean.
[[nodiscard]] RAYGRAPH_API TextureId Regress(Renderer& renderer, TextureId mean, TextureId guide,
                                             TextureId bound, const DenoiseFeatures& features,
                                             const RegressionSettings& settings);

// Mixes two results of Regress by their estimated errors, and blends the result with the mean. `pilot` weighs
// errors; `noise` is the variance of the mean. `isSingle`: it is a guess, and the mean is not used.
[[nodiscard]] RAYGRAPH_API TextureId BlendByError(Renderer& renderer, TextureId mean, TextureId noise,
                                                  TextureId pilot, TextureId detailed, TextureId smoothed,
                                                  bool isSingle);

}  // namespace raygraph::passes
