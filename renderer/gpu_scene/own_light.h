// Whether a scene has light of its own, or needs the built-in one. Threads: a pure function, for any thread;
// it uses threads of its own.
#pragma once

#include <cstdint>

#include "base/api.h"
#include "renderer/scene/scene_data.h"
#include "shaders/shared/choice.h"

namespace raygraph {

// When the built-in light, a studio (renderer/scene/studio.h), is a scene's environment.
//   Auto:   where it brings along none, and HasOwnLight is false
//   Studio: instead of what it brings along
//   None:   never
#define RAYGRAPH_DEFAULT_LIGHTS(X, Of)                                \
    X(Of, Auto, 0, "auto", "the studio where the scene has no light") \
    X(Of, Studio, 1, "studio", "in place of its environment")         \
    X(Of, None, 2, "none", "no built-in light")
RAYGRAPH_CHOICE(DefaultLight, RAYGRAPH_DEFAULT_LIGHTS)

// What of a scene's surfaces must be visible in its own light at least, for that to count.
inline constexpr double kOwnLightShare = 0.25;
// Visible is what has this luminance: six stops below middle gray, which is all but black in a picture at
// exposure 0.
inline constexpr double kOwnLightLuminance = 0.18 / 64.0;

// True for a scene with
//   - a punctual light that shines or that an animation may make shine;
//   - emission that lights it: of what cameras see of its surfaces, kOwnLightShare or more is as bright as
//     kOwnLightLuminance, because it emits, is unlit, or is reached by emitted light.
// The environment that the scene brings along does not count.
//
// The cameras are those of the scene, eight at most, or if they see no surface the one that frames it
// (ViewOfBounds). They see a thousand points; each point takes 16 paths of two bounces. Surfaces are taken as
// gray ones that reflect half of the light; transmissive and blended ones as if they were not there, unless
// they emit; round primitives as square bars; deformed meshes in their base shape; emission that an animation
// changes as at least 1. So the answer is a property of the scene, in the pose that it has: it does not
// depend on a picture's camera, size, crop, samples or seed, nor on a device.
//
// A scene without emission and unlit surfaces takes no time. Others cost a tree over the triangles of the
// meshes that are placed, and some 50,000 rays.
RAYGRAPH_API bool HasOwnLight(const scene::SceneData& scene, uint32_t maxThreads = 0);

}  // namespace raygraph
