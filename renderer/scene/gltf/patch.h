// Edited values put into a glTF file's JSON tree. Internal to renderer/scene.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "renderer/scene/gltf/outline.h"
#include "renderer/scene/gltf/save_gltf.h"

namespace raygraph::scene {

// Writes what `edited` has other than `loaded`, which was read from `root`, and nothing else. Throws
// Error{BadInput} "label: ..." if the two are not of one file, Error{Usage} for an edit that a file cannot
// hold.
void PatchNodes(nlohmann::ordered_json& root, const SceneData& loaded, const SceneData& edited);
void PatchMaterials(nlohmann::ordered_json& root, const GltfOutline& loaded, const SceneData& edited);
void PatchLights(nlohmann::ordered_json& root, const SceneData& loaded, const SceneData& edited);

// --- Nodes that came, went or were moved in the hierarchy (save_gltf.h) ---

// Tells which nodes of `edited` the file does not get: they are in no scene any more.
struct NodeChanges {
    size_t fileCount = 0;      // the nodes that the file has; later ones were added
    std::vector<bool> isGone;  // indexed by node of `edited`
};
// Gives the tree and what was loaded from it the nodes that were added, with their lights and cameras, as
// copies of nodes of the file or empty ones, and takes everything from those that are gone. The functions
// above then write the values.
NodeChanges PatchNodeList(nlohmann::ordered_json& root, GltfOutline& loaded, const SceneData& edited,
                          std::span<const uint32_t> copiedFrom);
// Writes names, children and the roots of scenes, then removes the nodes that are gone, with the channels of
// animations and the skins that name them. It comes last, since indices of nodes change. If the file uses an
// extension that is not read and may name nodes, nodes of the file that are gone stay there, empty and
// unused. Throws Error{Usage} if a skin that is used would lose a joint.
void PatchHierarchy(nlohmann::ordered_json& root, const GltfOutline& loaded, const SceneData& edited,
                    const NodeChanges& changes);

// --- Images that were replaced (save_gltf.h) ---

// Holds files that are to be written below the target's folder, by their paths from there.
using NewFiles = std::vector<std::pair<std::filesystem::path, std::span<const std::byte>>>;
// `folder` is the target's; `binary` is its BIN chunk, in which images are put, null if it has none.
NewFiles PatchImages(nlohmann::ordered_json& root, const GltfOutline& loaded,
                     std::span<const ReplacedImage> images, const std::filesystem::path& folder,
                     std::vector<std::byte>* binary);

// --- What the patches share ---

// Escapes the characters of a relative path that a URI may not hold.
std::string PercentEncode(const std::string& path);

// Returns whether all extensions that the file uses are read, so that it is known what they name.
bool AreExtensionsRead(const nlohmann::ordered_json& root);

inline constexpr const char* kPunctualLights = "KHR_lights_punctual";
// Adds the extension to extensionsUsed. That may move the members of `root`: references into it end.
void Use(nlohmann::ordered_json& root, const char* extension);
// Returns the index of a node's punctual light; nullptr if it has none.
nlohmann::ordered_json* LightOf(nlohmann::ordered_json& node);
[[noreturn]] void FailOther(const char* what, size_t inFile, size_t inScene);
// Returns the shortest decimal number that is this float.
nlohmann::ordered_json JsonNumber(float value);

}  // namespace raygraph::scene
