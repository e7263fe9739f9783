// Denoise: makes a picture with less noise from a finished render. Threads: that of the Renderer.
#pragma once

#include <array>
#include <optional>

#include "base/api.h"
#include "renderer/graph/renderer.h"
#include "shaders/shared/choice.h"

namespace raygraph::passes {

// All are rgba32f and of one extent. Values that are infinite or NaN count as 0. TraceGuides (passes/trace.h)
// returns albedo, normal and `seen`, for the settings and samples of `mean`.
struct DenoiseInputs {
    TextureId mean;            // radiance, the mean of the samples; alpha is kept
    TextureId variance;        // unbiased, of one sample, as Resolve returns it; of a single one, pass `mean`
    TextureId albedo, normal;  // means at the first hit
    // The mean of the first samples alone. Without it samples count as independent: where the sampler is
    // better than that, too much is taken for noise, and with many samples details suffer.
    std::optional<TextureId> firstHalf;
    // Radiance that the camera sees directly: the mean over the samples of `mean`, that over further ones,
    // too, and the mean square of the former. With it, edges of lights and of what is before the environment
    // are smooth, and their noise does not count as that of the rest.
    struct Seen {
        TextureId bySamples, byAll, squares;
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

// Returns the denoised picture, rgba32f. The estimate comes from PredictDenoised (Denoiser::Network), or from
// a local regression on albedo, normal and position with weights of non-local means (Denoiser::Regression:
// Pilot, Candidates, MixByError). BlendByError mixes the estimate with the mean, so that the result is the
// mean where there is no noise. A picture that is too large for the network (FitsNetwork) gets the
// regression. docs/denoise.md describes both, with sources and measured errors. Throws Error{Usage} for
// textures of other formats or extents, for `samples` == 0, and where `firstSamples` and `firstHalf`
// contradict each other.
[[nodiscard]] RAYGRAPH_API TextureId Denoise(Renderer& renderer, const DenoiseInputs& inputs,
                                             const DenoiseSettings& settings);

// --- The steps of Denoise, each for itself. They throw as Denoise does. ---

// All are rgba32f. `target` is the mean without directly seen radiance. `albedo` and `normal` are rgb and
// xyz, and in w four times the squared gradient per pixel, which widens the tolerance of weights where these
// vary from pixel to pixel.
struct DenoiseFeatures {
    TextureId target, albedo, normal;
};
[[nodiscard]] RAYGRAPH_API DenoiseFeatures FeaturesOf(Renderer& renderer, const DenoiseInputs& inputs);

// Returns the variance of the target in each channel, rgba32f.
[[nodiscard]] RAYGRAPH_API TextureId NoiseOfMean(Renderer& renderer, const DenoiseInputs& inputs,
                                                 const DenoiseFeatures& features,
                                                 const DenoiseSettings& settings);

// Returns the first estimate of the regression, rgba32f: a local fit to `guide`, the target, with weights
// from patches of 3 x 3 pixels. w of both is their variance, the mean over the channels.
[[nodiscard]] RAYGRAPH_API TextureId Pilot(Renderer& renderer, TextureId guide,
                                           const DenoiseFeatures& features);

// Returns three estimates of the mean, rgba32f, with bandwidths of 0.7, 1.4 and 2.8 standard deviations of
// `pilot`. Pixels that are much noisier than the fitted one count for less. w is the pixel's own weight in
// the estimate, from 0 to 1.
using DenoiseCandidates = std::array<TextureId, 3>;
[[nodiscard]] RAYGRAPH_API DenoiseCandidates Candidates(Renderer& renderer, TextureId mean, TextureId guide,
                                                        TextureId pilot, const DenoiseFeatures& features,
                                                        uint32_t samples);

// Returns a mixture of the candidates, rgba32f, by their estimated errors around each pixel. w is the pixel's
// own weight.
[[nodiscard]] RAYGRAPH_API TextureId MixByError(Renderer& renderer, TextureId mean, TextureId noise,
                                                const DenoiseCandidates& candidates);

// Returns an estimate of the mean (a candidate, or the result of MixByError or PredictDenoised) blended with
// the mean. The mean's weight is 1 - margin * (removed noise) / (squared difference of estimate and mean), at
// least 0, both summed over 9 x 9 pixels. `noise` is that of NoiseOfMean. The margin is 1.6 up to 256 samples
// and falls to 1 with more, so that the result tends to the mean. The noise of a single sample is a guess:
// then the result is the estimate.
[[nodiscard]] RAYGRAPH_API TextureId BlendByError(Renderer& renderer, const DenoiseInputs& inputs,
                                                  TextureId noise, TextureId estimate, uint32_t samples);

}  // namespace raygraph::passes
