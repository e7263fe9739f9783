// Index references of the parts of a file that are not decoded. Internal to renderer/scene.
#pragma once

#include "renderer/scene/gltf_accessors.h"
#include "renderer/scene/json_value.h"

namespace raygraph::scene {

// Checks that skins, animations and morph targets refer to nodes and accessors that exist, so that a damaged
// file is refused whether or not its damage shows.
void CheckUnreadReferences(const JsonValue& root, const AccessorTables& tables);

}  // namespace raygraph::scene
