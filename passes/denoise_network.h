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

// Holds weights as half floats, layer by layer in the order of use. A layer of I input and O output channels
// has O / 8 groups, each of 8 biases and then the weights as [I / 4][rows][columns][4 inputs][8 outputs].
using NetworkWeights = std::span<const uint16_t>;
// Returns the number of halves that the network has.
[[nodiscard]] RAYGRAPH_API size_t NetworkWeightCount();
// Returns the weights that tests/denoise/network/train.py has trained.
[[nodiscard]] RAYGRAPH_API NetworkWeights TrainedWeights();

// Returns whether the planes of a picture fit into buffers that the device's shaders can bind
// (maxStorageBufferRange): the largest has 56 bytes a pixel.
[[nodiscard]] RAYGRAPH_API bool FitsNetwork(const rhi::DeviceInfo& device, Extent2D extent);

// Returns an estimate of the mean, rgba32f; w is the pixel's own weight in it. The network is a U-Net
// (Ronneberger et al. 2015) whose first level has half the size of the picture. It predicts kernels of 5 x 5
// pixels for the light at four scales, and how the scales are mixed (Vogels et al. 2018; docs/denoise.md).
// Throws Error{Usage} for textures of other formats or extents, for another number of weights, and for a
// picture that does not fit. The weights are uploaded once for each Renderer: a later call with others of
// that count still uses the first ones.
[[nodiscard]] RAYGRAPH_API TextureId PredictDenoised(Renderer& renderer, const NetworkInputs& inputs,
                                                     NetworkWeights weights = TrainedWeights());

}  // namespace raygraph::passes
