// Where the noise of a stored render is, from its .exr alone: no scene and no device is needed.
//
//   const session::RenderFile render = session::ReadRenderFile("picture.exr");
//   for (const session::NoisyPixel& pixel : session::NoisiestPixels(render, 8)) ...
//   image::WritePng("noise.png", session::NoiseMap(render));
//
// Threads: pure functions, for any thread.
#pragma once

#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/api.h"
#include "editor/session/file/render_file.h"
#include "renderer/image/image.h"

namespace raygraph::session {

struct NoisyPixel {
    glm::uvec2 pixel{0};         // of the whole picture, also if a part of it was rendered
    double varianceShare = 0.0;  // of the sum of all pixels' variances
    double relativeError = 0.0;  // standard error of the pixel's mean over that mean, both over R, G and B
};

// Holds a group's share of the luminance of the picture, and of a pixel.
struct LightGroupShare {
    std::string name;
    double share = 0.0;
};

// Returns so many pixels, or all, by their share of the picture's variance, the largest first; none for a
// picture without noise. Throws Error{BadInput} for a render without variance or of one sample, as NoiseMap
// does.
RAYGRAPH_API std::vector<NoisyPixel> NoisiestPixels(const RenderFile& render, size_t count);

// Shows the relative error of each pixel by HeatColor (shaders/core/ramp.glsl): .001 and less is dark blue, 1
// and more light yellow, with equal steps for equal factors. Black pixels without noise are black.
RAYGRAPH_API image::Image8 NoiseMap(const RenderFile& render);

// Returns the shares of the light groups of the render in the light of a pixel, which is of the whole
// picture, or without one of the picture; the largest first, those of black left out. Throws Error{BadInput}
// for a render without light groups, as LightGroupMap does, and Error{Usage} for a pixel that was not
// rendered.
RAYGRAPH_API std::vector<LightGroupShare> LightGroupShares(const RenderFile& render,
                                                           const std::optional<glm::uvec2>& pixel = {});

// Shows which group lights a pixel: the mean of the groups' colors (IdColor of shaders/core/ramp.glsl, by the
// order of LightGroupNames), weighted by their luminances there. Black pixels are black.
RAYGRAPH_API image::Image8 LightGroupMap(const RenderFile& render);

}  // namespace raygraph::session
