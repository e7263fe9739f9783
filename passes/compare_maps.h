// The difference of two pictures, as maps and as numbers.
//
//   TextureId error = RelativeError(renderer, pathTraced, raster);
//   Readback groups = renderer.ReadBack(SumGroups(renderer, error));
//   renderer.Present(Heat(renderer, error, 1.0f));
//   ... in a later frame, if groups.IsReady() ...
//   MapNumbers numbers = NumbersOf(groups, extent);
//
// Threads: that of the Renderer.
#pragma once

#include "base/api.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

struct DifferenceIds {
    TextureId difference;  // |a - b| of each color channel, rgba32f as both are; alpha 1
    TextureId luminance;   // r32f, Rec. 709 luminance of that
};
[[nodiscard]] RAYGRAPH_API DifferenceIds Difference(Renderer& renderer, TextureId a, TextureId b);

// Returns |Y(test) - Y(reference)| / max(|Y(reference)|, minimum), r32f, of two linear pictures, rgba32f; Y
// is the luminance of Rec. 709 and `minimum`, in its units, limits the weight of nearly black pixels.
[[nodiscard]] RAYGRAPH_API TextureId RelativeError(Renderer& renderer, TextureId reference, TextureId test,
                                                   float minimum = 0.01f);

// Maps r32f to colors, rgba8, by HeatColor (shaders/core/ramp.glsl): 0 is dark, `maximum` and above light.
// `maximum` is above 0.
[[nodiscard]] RAYGRAPH_API TextureId Heat(Renderer& renderer, TextureId values, float maximum);

// Computes the sum and the maximum of each block of 16 x 16 pixels of an r32f texture: two floats a block.
// Read them back, without waiting, and give them to NumbersOf.
[[nodiscard]] RAYGRAPH_API BufferId SumGroups(Renderer& renderer, TextureId values);

struct MapNumbers {
    double mean = 0.0;
    float maximum = 0.0f;
};
// Throws Error{Usage} while `groups` is not ready, or if it is not that of a texture of this extent.
RAYGRAPH_API MapNumbers NumbersOf(const Readback& groups, Extent2D extent);

}  // namespace raygraph::passes
