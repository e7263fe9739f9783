// The built-in studio: the light of scenes that have none of their own. Threads: pure functions.
#pragma once

#include "base/api.h"
#include "renderer/image/image.h"

namespace raygraph::scene {

// Linear radiance as GpuScene::SetEnvironmentMap takes it, 256 x 128 texels, gray: a backdrop that is a quiet
// gradient, a key light that is a large soft box, a wide fill light on the other side, and two rim lights
// above and behind. The lights are placed for a scene that faces +z and is seen as ViewOfBounds frames it:
// the key comes from the upper left. The key and the rim lights are more than 20 degrees above the horizon,
// where level cameras do not see them; the fill has a seventh of the key's radiance.
//
// Seen from there, and so far away that all rays are parallel, a Lambert ball has a mean radiance over its
// disc that equals its reflectance: the gray of 18 % that photographers expose for is .18.
RAYGRAPH_API image::ImageF StudioMap();

}  // namespace raygraph::scene
