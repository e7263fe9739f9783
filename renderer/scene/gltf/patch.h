// Edited values put into a glTF file's JSON tree. Internal to renderer/scene.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "renderer/scene/gltf/outline.h"

namespace raygraph::scene {

// Writes what `edited` has other than `loaded`, which was read from `root`, and nothing else. Throws
// Error{BadInput} "label: ..." if the two are not of one file, Error{Usage} for an edit that a file cannot
// hold.
void PatchNodes(nlohmann::ordered_json& root, const SceneData& loaded, const SceneData& edited);
void PatchMaterials(nlohmann::ordered_json& root, const GltfOutline& loaded, const SceneData& edited);
void PatchLights(nlohmann::ordered_json& root, const SceneData& loaded, const SceneData& edited);

// Returns the shortest decimal number that is this float.
nlohmann::ordered_json JsonNumber(float value);

}  // namespace raygraph::scene
