// What materials use the textures of a scene for: how the levels of each are made. For renderer/gpu_scene
// alone. Threads: pure functions, for any thread.
#pragma once

#include <optional>
#include <vector>

#include "renderer/gpu_scene/materials/texture_levels.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph {

// A normal map at the same texture coordinates as a texture of roughness.
struct PairedNormals {
    uint32_t texture = 0;  // into SceneData::textures
    float normalScale = 1.0f;
    float roughnessFactor = 1.0f;

    bool operator==(const PairedNormals&) const = default;
};

struct TextureUse {
    TexelContent content = TexelContent::Data;
    // By which its roughness is widened. None where the materials that share the texture have different ones.
    std::optional<PairedNormals> normals;

    bool operator==(const TextureUse&) const = default;
};

// One per texture. A texture that some material reads as normals and another as anything else is data; color
// is weighted by alpha if no material shows it opaque.
std::vector<TextureUse> TextureUses(const scene::SceneData& scene);

}  // namespace raygraph
