// Check: whether a scene is one that can be rendered. The one list of what may be in a SceneData, for the
// importer as for hosts that make their own; GpuScene relies on it.
//
// All throw an Error of one line that names the object, what it holds and what is possible:
//     "scene: instances[3]: its transform is scaled to nothing or flat, it has no inverse"
// Threads: pure functions, for any thread.
#pragma once

#include <glm/glm.hpp>
#include <string>

#include "base/api.h"
#include "base/error.h"
#include "renderer/scene/scene_data.h"

namespace raygraph::scene {

// Everything that the top of scene_data.h lists. Linear time. `subject` begins the line.
RAYGRAPH_API void Check(const SceneData& scene, const std::string& subject = "scene",
                        ErrorKind kind = ErrorKind::Usage);

// One of them alone. Of a material its numbers, not its textures; of a light its transform, too.
RAYGRAPH_API void Check(const Material& material, const std::string& subject,
                        ErrorKind kind = ErrorKind::Usage);
RAYGRAPH_API void Check(const Light& light, const std::string& subject, ErrorKind kind = ErrorKind::Usage);
// Of something that rays hit: finite, and with an inverse.
RAYGRAPH_API void CheckTransform(const PlacedTransform& transform, const std::string& subject,
                                 ErrorKind kind = ErrorKind::Usage);

RAYGRAPH_API bool IsFinite(const glm::vec3& vector);
RAYGRAPH_API bool IsFinite(const glm::mat4x3& transform);
// In float, because a device inverts in float. False for what is not finite.
RAYGRAPH_API bool CanInvert(const glm::mat4x3& transform);

}  // namespace raygraph::scene
