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

// Holds the path of a scene file, and its name in messages.
struct ScenePath {
    std::filesystem::path file;  // canonical
    // The one named, so that a link to a scene finds what stands beside the link.
    std::filesystem::path folder;
    std::string label;
};
// Finds the scene file; throws Error{Io} if there is none.
ScenePath Locate(const std::filesystem::path& path);

struct GltfOutline {
    AccessorTables tables;
    std::vector<BufferSource> bufferSources;  // indexed by buffer
    std::vector<ImageSource> imageSources;    // by the file's image
    // Materials, textures, nodes, cameras, lights and skins, without transforms and matrices.
    SceneData scene;
    std::vector<ImageChoice> images;           // from ReadMaterials
    std::vector<bool> isShown;                 // By `images`: by a material of a mesh that is placed.
    std::optional<ImageLight> imageLight;      // the loaded scene's
    std::vector<ProfileSource> profiles;       // by SceneData::profiles
    std::vector<MeshLayout> layouts;           // indexed by mesh
    std::vector<InstancingLayout> instancing;  // indexed by node
    GraphIndices graph;                        // the file's indices of what the scene has
    std::vector<SkinSource> skins;             // indexed by skin
    std::vector<AnimationLayout> animations;   // indexed by animation
    uint32_t defaultMaterial = kNone;          // added to scene.materials, if a primitive names none
};

// Parses the text, checks all of the file's structure, and opens nothing.
GltfOutline ReadOutline(GltfContext& context, std::string_view json);

}  // namespace raygraph::scene
