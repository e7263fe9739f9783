// Flip computes the difference that a viewer perceives when flipping between two pictures. Threads: that of
// the Renderer.
#pragma once

#include "base/api.h"
#include "renderer/graph/renderer.h"

namespace raygraph::passes {

struct FlipSettings {
    // Is the number of pixels per degree of the screen at the viewing distance: pi / 180 * distance * pixels
    // / width, both lengths in one unit. The default is the authors': a screen 0.7 m wide, of 3840 pixels,
    // 0.7 m away. In [1, 400].
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

}  // namespace raygraph::passes
