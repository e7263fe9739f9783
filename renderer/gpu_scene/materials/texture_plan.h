// Plans textures on the host: which levels go to the device, so that all fit a budget; for what materials
// use a texture, which determines how its levels are made; and the color that a sampler would read. For
// renderer/gpu_scene alone. Threads: pure functions.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/gpu_scene/materials/texture_set.h"
#include "renderer/scene/model/scene_data.h"
#include "rhi/format.h"

namespace raygraph {

// Describes one of the sizes that a texture can have on the device.
struct TextureChoice {
    uint32_t firstLevel = 0;  // level of the image that is the texture's level 0
    uint64_t bytes = 0;
    bool isBlocks = false;  // the blocks are those of the file

    bool operator==(const TextureChoice&) const = default;
};

// Holds the possible sizes of a texture.
struct TextureSizes {
    rhi::Extent2D extent;                // of level 0
    std::vector<TextureChoice> choices;  // at least one; each takes less memory than the one before
};

// Returns the choices for texels of four bytes: from each level on, or that level alone.
TextureSizes PlainTextureSizes(rhi::Extent2D extent, bool makesMipLevels);
// Returns the choices for an image whose file has levels of these sizes in blocks, followed by plain texels
// for levels below the last.
TextureSizes BlockTextureSizes(rhi::Extent2D extent, std::span<const uint64_t> levelBytes,
                               bool makesMipLevels);

struct TexturePlan {
    std::vector<TextureChoice> choices;  // indexed by texture
    uint64_t bytes = 0;                  // sum over all textures
};

// Drops a level of the largest texture, the first of them if several are equal, until all fit `budget` or
// every texture has its smallest size.
TexturePlan PlanTextures(std::span<const TextureSizes> textures, uint64_t budget);

// Returns a message such as "3 of 10 textures are smaller on the device, to fit 60.1 MiB into a budget of 64
// MiB: 2 of 4096x4096 texels are 1024x1024, ..."; empty if no texture is smaller.
std::string ReductionText(std::span<const TextureSizes> textures, const TexturePlan& plan, uint64_t budget);

// --- For what the materials of a scene use its textures ---

// Holds the normal map at the same texture coordinates as a roughness texture.
struct PairedNormals {
    uint32_t texture = 0;  // index into SceneData::textures
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

// --- Textures read on the host as samplers do ---

// Returns which of the `size` texels in a row is at coordinate `x` of the endless texture.
uint32_t WrapTexel(int64_t x, uint32_t size, scene::WrapMode mode);

// Returns the color at `uv`, decoded to linear values, and alpha. Both are interpolated between the four
// nearest texels of the largest level, also where the filter of the sampler is Nearest. They are 0 where
// `uv` is not finite or beyond 1e15 texels. `image` belongs to the texture, and has its texels.
glm::vec4 LookUp(const scene::Texture& texture, const scene::ImageData& image, const glm::vec2& uv);

}  // namespace raygraph
