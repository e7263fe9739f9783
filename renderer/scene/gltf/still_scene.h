// A scene at one time of its animations, as a picture that stands still shows it.
//
//   scene::FreezePose(data, scene::FindClips(data, "walk", 0.4));    // before GpuScene::SetScene
//
// Threads: pure functions of their arguments, for any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "renderer/scene/animation/pose.h"
#include "renderer/scene/gltf/load_gltf.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Returns the animations that a list names, at a time: "walk", "0", "walk,nod", "walk:0.3,run:0.7". Each is a
// name (the first animation of that name) or an index as decimal digits, with its weight behind a colon (1).
// "": the first animation, if there is one; "all": all of them. Error{BadInput} for what is none of this,
// naming what there is.
RAYGRAPH_API std::vector<ClipState> FindClips(const SceneData& scene, std::string_view list, double seconds);
// Returns the list that FindClips makes these of: names where they are unambiguous, else indices. Clips
// without weight are left out.
RAYGRAPH_API std::string ClipsText(const SceneData& scene, std::span<const ClipState> clips);

// Gives the scene the pose of these clips; without any, its rest pose, in which skins and the default weights
// of morph targets count, too. Deformed instances get meshes whose vertices are deformed already (those of
// one shape share one), and the scene has no skins, no targets and no animations any more. What a skin has
// moved follows its own node from then on, not its joints. Instances that are collapsed at that time are left
// out, and hidden ones that cannot follow their node because it is flat.
//
// Where a mesh has several shapes, all but one are copies: Error{BadInput}, naming the mesh, if they take
// more than `maxCopiedBytes`. Error{Usage} if there is no such animation. Error{OutOfMemory}. After an error
// the scene is in some pose.
RAYGRAPH_API void FreezePose(SceneData& scene, std::span<const ClipState> clips,
                             uint64_t maxCopiedBytes = LoadLimits().maxGeometryBytes);

}  // namespace raygraph::scene
