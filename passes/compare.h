// Comparison of two pictures of one scene: both in one picture for a viewport, and their difference as maps
// and as numbers. Threads: that of the Renderer.
#pragma once

#include <initializer_list>

#include "base/api.h"
#include "passes/accumulate.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

// --- Two pictures in one ---
// Both passes take rgba8 of one extent, display values as Tonemap gives them, and return the same.
// Error{Usage} for other formats, and for pictures of two extents.

// Shows `left` in the columns before position * width, `right` in those from there on, a line between them.
// `position` is clamped to [0, 1]; at either end only one picture is shown, without a line.
[[nodiscard]] RAYGRAPH_API TextureId Wipe(Renderer& renderer, TextureId left, TextureId right,
                                          float position);

// Shows all of both pictures at half the size, as means of 2 x 2 pixels, each in the middle of its half.
[[nodiscard]] RAYGRAPH_API TextureId SideBySide(Renderer& renderer, TextureId left, TextureId right);

// --- The difference, as maps and as numbers ---
//
//   TextureId error = RelativeError(renderer, pathTraced, raster);
//   Readback blocks = renderer.ReadBack(ReduceBlocks(renderer, error));
//   renderer.Present(Heat(renderer, error, 1.0f));
//   ... in a later frame, if blocks.IsReady() ...
//   MapStatistics statistics = StatisticsOf(blocks, extent);

struct DifferenceIds {
    TextureId difference;  // |a - b| of each color channel, rgba32f as both are; alpha 1
    TextureId luminance;   // r32f, Rec. 709 luminance of that
};
[[nodiscard]] RAYGRAPH_API DifferenceIds Difference(Renderer& renderer, TextureId a, TextureId b);

// Returns |Y(test) - Y(reference)| / max(|Y(reference)|, minimum), r32f, of two linear pictures, rgba32f; Y
// is the luminance of Rec. 709 and `minimum`, in its units, limits the weight of nearly black pixels.
[[nodiscard]] RAYGRAPH_API TextureId RelativeError(Renderer& renderer, TextureId reference, TextureId test,
                                                   float minimum = 0.01f);

// The relative squared error of each pixel, r32f: the mean over the color channels of (test - reference)^2 /
// (reference^2 + .01). Its mean over the pixels is the relMSE.
struct SquaredErrorIds {
    TextureId error;
    TextureId noise;  // what the reference's own noise is expected to add to it; 0 below two samples
};
// `test` is rgba32f. The reference is the mean of `samples`, which have squares, and at least one of every
// pixel. Throws Error{Usage} for others.
[[nodiscard]] RAYGRAPH_API SquaredErrorIds RelativeSquaredError(Renderer& renderer, TextureId test,
                                                                const AccumulatedIds& samples,
                                                                const Accumulation::Progress& progress);

// Adds `picture`, rgba32f, to `moments`, rg32f: mean and variance of the luminance over pictures, of which
// the newest has the share `weight`. A weight of 1 resets them. Returns variance / (mean^2 + .01),
// r32f.
[[nodiscard]] RAYGRAPH_API TextureId Flicker(Renderer& renderer, TextureId picture, TextureId moments,
                                             float weight);

// Maps r32f to colors, rgba8, by HeatColor (shaders/core/ramp.glsl): 0 is dark, `maximum` and above light.
// `maximum` is above 0.
[[nodiscard]] RAYGRAPH_API TextureId Heat(Renderer& renderer, TextureId values, float maximum);

// Computes the sum and the maximum of each block of 16 x 16 pixels of an r32f texture: two floats a block.
// Read them back, without waiting, and give them to StatisticsOf.
[[nodiscard]] RAYGRAPH_API BufferId ReduceBlocks(Renderer& renderer, TextureId values);

struct MapStatistics {
    double mean = 0.0;
    float maximum = 0.0f;
};
// Throws Error{Usage} while `blocks` is not ready, or if it is not that of a texture of this extent.
RAYGRAPH_API MapStatistics StatisticsOf(const Readback& blocks, Extent2D extent);

// Computes whole - part in each of the four channels. All three are rgba32f and of one extent; throws
// Error{Usage} for others.
[[nodiscard]] RAYGRAPH_API TextureId Subtract(Renderer& renderer, TextureId whole, TextureId part);

// Returns the extent of both. Throws Error{Usage} naming the pass unless both have that format and one
// extent.
RAYGRAPH_API Extent2D RequireComparable(const Renderer& renderer, const char* pass, TextureId a, TextureId b,
                                        Format format);
// Does so for all of several.
RAYGRAPH_API Extent2D RequireComparable(const Renderer& renderer, const char* pass, TextureId first,
                                        std::initializer_list<TextureId> others, Format format);

}  // namespace raygraph::passes
