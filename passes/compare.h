// Comparison of two pictures of one scene: both in one picture for a viewport, their difference as maps and
// as numbers, and the difference that a viewer perceives. Threads: that of the Renderer.
#pragma once

#include "base/api.h"
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
//   Readback groups = renderer.ReadBack(SumGroups(renderer, error));
//   renderer.Present(Heat(renderer, error, 1.0f));
//   ... in a later frame, if groups.IsReady() ...
//   MapNumbers numbers = NumbersOf(groups, extent);

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

// --- The difference that a viewer perceives when flipping between two pictures ---

struct FlipSettings {
    // The pixels per degree of the screen at the viewing distance: pi / 180 * distance * pixels / width, both
    // lengths in one unit. The default is the authors': a screen 0.7 m wide, of 3840 pixels, 0.7 m away. In
    // [1, 400].
    float pixelsPerDegree = 67.0206433f;
};

// Andersson, Nilsson, Akenine-Moeller, Oskarsson, Aastroem and Fairchild 2020, "FLIP: A Difference Evaluator
// for Alternating Images", for low dynamic range (LDR-FLIP, version 1): what two pictures differ in color
// after the eye's contrast sensitivity, and in edges and points. Takes display values, sRGB-encoded, as
// every operator of Tonemap but Linear gives them; returns r32f in [0, 1], 0 where no one sees a difference.
// The number for a picture is the mean. Symmetric in its arguments. Error{Usage} unless both are rgba8 of
// one extent.
[[nodiscard]] RAYGRAPH_API TextureId Flip(Renderer& renderer, TextureId reference, TextureId test,
                                          const FlipSettings& settings = {});

// --- The difference of linear pictures, and the check of all passes over two ---

// Computes whole - part in each of the four channels. All three are rgba32f and of one extent; throws
// Error{Usage} for others.
[[nodiscard]] RAYGRAPH_API TextureId Subtract(Renderer& renderer, TextureId whole, TextureId part);

// Returns the extent of both. Throws Error{Usage} naming the pass unless both have that format and one
// extent.
RAYGRAPH_API Extent2D RequireComparable(const Renderer& renderer, const char* pass, TextureId a, TextureId b,
                                        Format format);

}  // namespace raygraph::passes
