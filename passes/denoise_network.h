// PredictDenoised: the estimate of a network that was trained for Denoise, as passes of the graph. Threads:
// that of the Renderer.
#pragma once

#include <cstdint>
#include <span>

#include "base/api.h"
#include "renderer/graph/renderer.h"
#include "rhi/device.h"

namespace raygraph::passes {

// All are rgba32f, of one extent and finite.
struct NetworkInputs {
    TextureId mean;
    TextureId target;  // the mean without the light that is seen directly
    TextureId noise;   // variance of the mean in each channel
    TextureId albedo, normal;
    uint32_t samples = 1;  // of each pixel
};

// Holds weights as halves. Layers follow each other in the order of their use. A layer has, for each eight
// channels of its result, their biases, and then the eight weights of each source value: four channels after
// the other, in these the kernel pixel by pixel in rows, in a pixel the four channels.
using NetworkWeights = std::span<const uint16_t>;
// Returns the number of halves that the network has.
[[nodiscard]] RAYGRAPH_API size_t NetworkWeightCount();
// Returns the weights that tests/denoise/network/train.py has trained.
[[nodiscard]] RAYGRAPH_API NetworkWeights TrainedWeights();

// Returns whether the planes of a picture fit into buffers that the device's shaders can bind: 1.2 million
// pixels need 64 MB.
[[nodiscard]] RAYGRAPH_API bool FitsNetwork(const rhi::DeviceInfo& device, Extent2D extent);

// Returns an estimate of the mean, rgba32f; w is the share that the pixel's own value has in it. The
// network is a U-Net (Ronneberger et al. 2015) whose first level has half the size of the picture. From its
// levels, kernels of 5 x 5 pixels are predicted for the light at four scales, and how these are mixed
// (Vogels et al. 2018, "Denoising with Kernel Prediction and Asymmetric Loss Functions"). Throws
// Error{Usage} for textures of other formats or extents, for another number of weights, and for a picture
// that does not fit. The first call of a Renderer keeps the weights on the device, and its later calls must
// give the same.
[[nodiscard]] RAYGRAPH_API TextureId PredictDenoised(Renderer& renderer, const NetworkInputs& inputs,
                                                     NetworkWeights weights = TrainedWeights());

}  // namespace raygraph::passes
