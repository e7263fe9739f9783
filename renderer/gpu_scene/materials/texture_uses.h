// Finds for what the materials of a scene use its textures, which determines how levels are made. For
// renderer/gpu_scene alone. Threads: pure functions.
#pragma once

#include <optional>
#include <vector>

#include "renderer/gpu_scene/materials/texture_levels.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph {

// The normal map at the same texture coordinates as a roughness texture.
struct PairedNormals {
    uint32_t texture = 0;  // into SceneData::textures
    float normalScale = 1.0f;
    float roughnessFactor = 1.0f;

    bool operator==(const PairedNormals&) const = default;
};

struct TextureUse {
    TexelContent content = TexelContent::Data;
    // The normal map by which its roughness is widened. Empty if materials that share the texture have
    // different ones.
    std::optional<PairedNormals> normals;

    bool operator==(const TextureUse&) const = default;
};

// Returns one per texture. A texture that some material reads as normals and another as anything else is
// data; color is weighted by alpha if no material shows it opaque.
std::vector<TextureUse> TextureUses(const scene::SceneData& scene);

}  // namespace raygraph
