// The views that show no light, as 8-bit pictures for looking at. An .exr has the numbers themselves.
#pragma once

#include "editor/cli/render_file.h"
#include "renderer/image/image.h"

namespace raygraph::cli {

// albedo: sRGB-encoded. normals: x, y, z from [-1, 1] to [0, 255], world space. depth: white at the nearest
// surface down to dark grey at the farthest, in equal steps of distance. instance, material: one colour for
// each, the same in every picture. Black where nothing is hit. Opaque. `render` must have the view's channel.
image::Image8 ShowView(View view, const RenderFile& render);

// The same as linear RGBA for R G B A of an .exr: albedo; x y z; depth three times; the id three times. Alpha
// is the part of the pixel that is covered: w of the albedo for albedo and normals (which need both
// channels), for the others 1 where the ray through the centre hits.
Texels ViewTexels(View view, const RenderFile& render);

}  // namespace raygraph::cli
