// Chooses which levels of textures go to the device, so that all fit a budget. For renderer/gpu_scene alone.
// Threads: pure functions.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rhi/format.h"

namespace raygraph {

// One of the sizes that a texture can have on the device.
struct TextureChoice {
    uint32_t firstLevel = 0;  // level of the image that is the texture's level 0
    uint64_t bytes = 0;
    bool isBlocks = false;  // the blocks are those of the file

    bool operator==(const TextureChoice&) const = default;
};

// The possible sizes of a texture.
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
    std::vector<TextureChoice> choices;  // by texture
    uint64_t bytes = 0;                  // sum over all textures
};

// Drops a level of the largest texture, the first of them if several are equal, until all fit `budget` or
// every texture has its smallest size.
TexturePlan PlanTextures(std::span<const TextureSizes> textures, uint64_t budget);

// Returns a message such as "3 of 10 textures are smaller on the device, to fit 60.1 MiB into a budget of 64
// MiB: 2 of 4096x4096 texels are 1024x1024, ..."; empty if no texture is smaller.
std::string ReductionText(std::span<const TextureSizes> textures, const TexturePlan& plan, uint64_t budget);

}  // namespace raygraph
