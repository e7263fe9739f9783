// Check: whether a scene can be rendered. The only list of the rules for a SceneData, for the importer and
// for hosts that build their own; GpuScene relies on it.
//
// All throw an Error of one line that names the object, its value and the valid range:
//     "scene: instances[3]: its transform is scaled to nothing or to a line"
// Threads: pure functions, for any thread.
#pragma once

#include <glm/glm.hpp>
#include <string>

#include "base/api.h"
#include "base/error.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// Checks everything that the top of scene_data.h lists, in linear time. `subject` begins the line.
RAYGRAPH_API void Check(const SceneData& scene, const std::string& subject = "scene",
                        ErrorKind kind = ErrorKind::Usage);

// A single object. Of a material its numbers, not its textures; of a light its transform, too.
RAYGRAPH_API void Check(const Material& material, const std::string& subject,
                        ErrorKind kind = ErrorKind::Usage);
RAYGRAPH_API void Check(const Light& light, const std::string& subject, ErrorKind kind = ErrorKind::Usage);
// Checks the transform of a light that a host sets: it has to be finite and have an inverse.
RAYGRAPH_API void CheckTransform(const PlacedTransform& transform, const std::string& subject,
                                 ErrorKind kind = ErrorKind::Usage);
// Returns the transform with which an instance of a mesh with these bounds is shown (WithThickness). Throws
// if `transform` is not finite, or scales to nothing or to a line.
RAYGRAPH_API PlacedTransform CheckedPlacement(const PlacedTransform& transform, const Bounds& mesh,
                                              const std::string& subject, ErrorKind kind = ErrorKind::Usage);

RAYGRAPH_API bool IsFinite(const glm::vec3& vector);
RAYGRAPH_API bool IsFinite(const glm::mat4x3& transform);
// Returns whether the transform can be inverted in float, as devices invert. False for a matrix that is not
// finite.
RAYGRAPH_API bool CanInvert(const glm::mat4x3& transform);

}  // namespace raygraph::scene
