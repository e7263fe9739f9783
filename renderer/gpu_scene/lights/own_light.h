// Tells whether a scene lights itself, or needs the built-in light. Threads: a pure function, which starts
// threads of its own.
#pragma once

#include <cstdint>

#include "base/api.h"
#include "renderer/scene/model/scene_data.h"
#include "shaders/shared/choice.h"

namespace raygraph {

// When the built-in light, a studio (renderer/scene/model/studio.h), is a scene's environment.
//   Auto:   if the scene has no environment, and HasOwnLight is false
//   Studio: instead of the scene's environment
//   None:   never
#define RAYGRAPH_DEFAULT_LIGHTS(X, Of)                                \
    X(Of, Auto, 0, "auto", "the studio where the scene has no light") \
    X(Of, Studio, 1, "studio", "in place of its environment")         \
    X(Of, None, 2, "none", "no built-in light")
RAYGRAPH_CHOICE(DefaultLight, RAYGRAPH_DEFAULT_LIGHTS)

// True for a scene with
//   - a punctual light that shines, or that an animation makes shine;
//   - emission or unlit surfaces that light it: a quarter or more of the surface points that cameras see
//     have a luminance of .18 / 64 at least, six stops below middle gray, because they emit it, are unlit and
//     have that color, or are reached by light of such surfaces.
// The environment of the scene is ignored.
//
// The cameras are those of the scene, eight at most, or if they see no surface the one that frames it
// (ViewOfBounds). They see a thousand points; each point takes 16 paths of two bounces. Surfaces are taken
// as gray ones that reflect half of the light, and unlit ones as not reflecting any. Emission, unlit colors
// and alpha are those of the textures and vertex colors at each point: a ray passes where a mask has a hole,
// and through the share of a blended surface that is transparent. Transmissive surfaces are taken as if they
// were not there, unless they emit; round primitives as square bars; deformed meshes in their base shape.
// Animated emission, unlit colors and visibility of glowing surfaces are taken at their brightest
// (brightest_pose.h). Hence the answer is a property of the scene in its current pose: it does not depend on
// the camera, size, crop, samples or seed of a picture, nor on a device.
//
// The call takes no time for a scene without emission and unlit surfaces. For others it builds a tree over
// the triangles of the placed meshes, and traces some 50,000 rays.
RAYGRAPH_API bool HasOwnLight(const scene::SceneData& scene, uint32_t maxThreads = 0);

// Returns whether the scene has any light at all, however little, where textures are taken as white. It takes
// no time. HasOwnLight measures a scene only if this is true.
RAYGRAPH_API bool MayHaveOwnLight(const scene::SceneData& scene);

}  // namespace raygraph
