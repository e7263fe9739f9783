// Tests that two renders, each with a variance of its own, estimate one image; makes the scenes that are
// rendered in many ways.
#pragma once

#include <string>

#include "renderer/image/image.h"
#include "tests/support/scene_render.h"

namespace raygraph::testing {

// Tells whether the errors of a render's pixels are correlated.
enum class PixelErrors { Independent, Shared };

// A z-test on blocks of 8 x 8 pixels: all but 0.25 % of them differ by less than 4 standard errors, and so
// does the mean of the image; and the errors are small enough to tell something (2 % of the mean image).
// Shared: a block's error is taken to be as large as its pixels'.
void ExpectSameImage(const RenderedImage& image, const RenderedImage& reference, const std::string& name,
                     PixelErrors errors = PixelErrors::Independent);

// A glossy floor and a box in the open, under a small lamp whose emission has a texture and whose alpha stops
// part of the rays.
scene::SceneData RoomWithLamp();
image::ImageF EveningSky();  // bright on one side, black below
passes::TraceSettings ViewOfRoom(uint32_t size);

// A closed box that shines, of Lambert's, with another box in it.
scene::SceneData EmissiveRoom();
passes::TraceSettings ViewOfEmissiveRoom(uint32_t size);

}  // namespace raygraph::testing
