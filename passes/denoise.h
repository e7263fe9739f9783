// Denoise: a picture with less noise, for finished renders. Threads: that of the Renderer.
#pragma once

#include <array>
#include <optional>

#include "base/api.h"
#include "renderer/graph/renderer.h"
#include "shaders/shared/choice.h"

namespace raygraph::passes {

// All are rgba32f and of one extent. Values that are infinite or NaN count as 0.
struct DenoiseInputs {
    TextureId mean;            // radiance, the mean of the samples; alpha is kept
    TextureId variance;        // unbiased, of one sample, as Resolve returns it; not used for a single sample
    TextureId albedo, normal;  // means at the first hit, as TraceGuides returns them
    // The mean of the first samples alone. Without it samples count as independent: where the sampler is
    // better than that, too much is taken for noise, and with many samples details suffer.
    std::optional<TextureId> firstHalf;
    // Radiance that the camera sees directly, from the same samples and from further ones, as TraceGuides
    // returns it. With it, edges of lights and of what is before the environment are smooth.
    struct Seen {
        TextureId bySamples, byAll;
    };
    std::optional<Seen> seen;
};

// How the mean is estimated from what is around a pixel.
#define RAYGRAPH_DENOISERS(X, Of)                               \
    X(Of, Network, 0, "network", "trained on generated scenes") \
    X(Of, Regression, 1, "regression", "on albedo and normals, without training")
RAYGRAPH_CHOICE(Denoiser, RAYGRAPH_DENOISERS)

struct DenoiseSettings {
    uint32_t samples = 1;                   // of each pixel
    uint32_t firstSamples = 0;              // those of `firstHalf`: about half, less than `samples`
    Denoiser denoiser = Denoiser::Network;  // of pictures that fit (FitsNetwork); else the regression
};

// Returns the picture, rgba32f. The radiance is regressed on albedo, normal and position (Bitterli et al.
// 2016, "Nonlinearly Weighted First-order Regression for Denoising Monte Carlo Renderings") with weights of
// non-local means, twice: the second time these are taken from the first result, with three bandwidths, of
// which the one with the smallest estimated error (Stein 1981) is used in each place. The result is blended
// with the mean by how much of their difference noise explains, so that it is the mean where there is no
// noise. docs/denoise.md has measured errors. Throws Error{Usage} for textures of other formats or extents,
// and for counts that contradict each other.
[[nodiscard]] RAYGRAPH_API TextureId Denoise(Renderer& renderer, const DenoiseInputs& inputs,
                                             const DenoiseSettings& settings);

// The steps of Denoise, each for itself.

// `target` is fitted: the mean without the light that is seen directly. `albedo` and `normal` are the means
// of surfaces, with four times the squared gradient in w.
struct DenoiseFeatures {
    TextureId target, albedo, normal;
};
[[nodiscard]] RAYGRAPH_API DenoiseFeatures FeaturesOf(Renderer& renderer, const DenoiseInputs& inputs);

// The variance of the mean in each channel, rgba32f.
[[nodiscard]] RAYGRAPH_API TextureId NoiseOfMean(Renderer& renderer, const DenoiseInputs& inputs,
                                                 const DenoiseFeatures& features,
                                                 const DenoiseSettings& settings);

// Returns the first fit of `guide`, the target, at each pixel, rgba32f; w of both is their variance as
// weights use it.
[[nodiscard]] RAYGRAPH_API TextureId Pilot(Renderer& renderer, TextureId guide,
                                           const DenoiseFeatures& features);

// Estimates of the mean with larger and larger bandwidths, by weights from the first fit, and less of pixels
// that are much noisier than the fitted one. w is the share that the pixel's own value has in it.
using DenoiseCandidates = std::array<TextureId, 3>;
[[nodiscard]] RAYGRAPH_API DenoiseCandidates Candidates(Renderer& renderer, TextureId mean, TextureId guide,
                                                        TextureId pilot, const DenoiseFeatures& features,
                                                        uint32_t samples);

// Mixes candidates by their estimated errors around each pixel.
[[nodiscard]] RAYGRAPH_API TextureId MixByError(Renderer& renderer, TextureId mean, TextureId noise,
                                                const DenoiseCandidates& candidates);

// Blends an estimate of the mean, as a candidate or PredictDenoised is one, with the mean. `noise` is the
// variance of the mean, more the more samples there are: estimates of the noise then tell less than those
// of the estimate's error. Of a single sample, noise is a guess, and the mean is not used.
[[nodiscard]] RAYGRAPH_API TextureId BlendByError(Renderer& renderer, const DenoiseInputs& inputs,
                                                  TextureId noise, TextureId estimate, uint32_t samples);

}  // namespace raygraph::passes
