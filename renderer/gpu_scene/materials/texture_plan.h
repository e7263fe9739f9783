// Which levels of textures go to the device, so that all fit a budget. For renderer/gpu_scene alone. Threads:
// pure functions, for any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rhi/format.h"

namespace raygraph {

// What a texture can be on the device.
struct TextureChoice {
    uint32_t firstLevel = 0;  // of the image: the texture's level 0
    uint64_t bytes = 0;
    bool isBlocks = false;  // those of its file

    bool operator==(const TextureChoice&) const = default;
};

// A texture before it is made.
struct TextureSizes {
    rhi::Extent2D extent;                // of level 0
    std::vector<TextureChoice> choices;  // at least one; each takes less than the one before
};

// Of texels of four bytes: with all levels from each one on, or with that one alone.
TextureSizes PlainTextureSizes(rhi::Extent2D extent, bool makesMipLevels);
// Of an image whose file has levels of so many bytes, in blocks: these, and plain ones below the last.
TextureSizes BlockTextureSizes(rhi::Extent2D extent, std::span<const uint64_t> levelBytes,
                               bool makesMipLevels);

struct TexturePlan {
    std::vector<TextureChoice> choices;  // of each texture
    uint64_t bytes = 0;                  // of all
};

// Drops a level of whichever texture is the largest, the first of them if several are, until all fit `budget`
// or every texture is down to its last size.
TexturePlan PlanTextures(std::span<const TextureSizes> textures, uint64_t budget);

// "3 of 10 textures are smaller on the device, to fit 60.1 MiB into a budget of 64 MiB: 2 of 4096x4096 texels
// are 1024x1024, ..."; empty if none is.
std::string ReductionText(std::span<const TextureSizes> textures, const TexturePlan& plan, uint64_t budget);

}  // namespace raygraph
