// The content of a glTF file without its buffers and images. Internal to renderer/scene.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/scene/gltf/accessors.h"
#include "renderer/scene/gltf/animations.h"
#include "renderer/scene/gltf/context.h"
#include "renderer/scene/gltf/document.h"
#include "renderer/scene/gltf/images.h"
#include "renderer/scene/gltf/lights.h"
#include "renderer/scene/gltf/meshes.h"
#include "renderer/scene/gltf/nodes.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// The path of a scene file, and its name in messages.
struct ScenePath {
    std::filesystem::path file;  // Canonical.
    // The one named, so that a link to a scene finds what stands beside the link.
    std::filesystem::path folder;
    std::string label;
};
// Finds the scene file; throws Error{Io} if there is none.
ScenePath Locate(const std::filesystem::path& path);

struct GltfOutline {
    AccessorTables tables;
    std::vector<BufferSource> bufferSources;  // By buffer.
    std::vector<ImageSource> imageSources;    // By the file's image.
    // Materials, textures, nodes, cameras, lights and skins, without transforms and matrices.
    SceneData scene;
    std::vector<ImageChoice> images;           // from ReadMaterials
    std::vector<bool> isShown;                 // By `images`: by a material of a mesh that is placed.
    std::optional<ImageLight> imageLight;      // The loaded scene's.
    std::vector<ProfileSource> profiles;       // By SceneData::profiles.
    std::vector<MeshLayout> layouts;           // By mesh.
    std::vector<InstancingLayout> instancing;  // By node.
    std::vector<SkinSource> skins;             // By skin.
    std::vector<AnimationLayout> animations;   // By animation.
    uint32_t defaultMaterial = kNone;          // Added to scene.materials, if a primitive names none.
};

// Parses the text, checks all of the file's structure, and opens nothing.
GltfOutline ReadOutline(GltfContext& context, std::string_view json);

}  // namespace raygraph::scene
