// Which levels of textures go to the device, so that all fit a budget. For renderer/gpu_scene alone. Threads:
// pure functions, for any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "rhi/format.h"

namespace raygraph {

// A texture before it is made: what it would take on the device if it began with level 0, 1, ... of its
// image; descending, at least one.
struct TextureSizes {
    rhi::Extent2D extent;  // of level 0
    std::vector<uint64_t> bytes;
};

// Of texels of four bytes: with all levels from each one on, or with that one alone.
TextureSizes PlainTextureSizes(rhi::Extent2D extent, bool hasLevels);

struct TexturePlan {
    std::vector<uint32_t> firstLevels;  // of each texture
    uint64_t bytes = 0;                 // of all
};

// Drops a level of whichever texture is the largest, the first of them if several are, until all fit `budget`
// or every texture is down to its last size.
TexturePlan PlanTextures(std::span<const TextureSizes> textures, uint64_t budget);

// "3 of 10 textures are smaller on the device, to fit 60.1 MiB into a budget of 64 MiB: 2 of 4096x4096 texels
// are 1024x1024, ..."; empty if none is.
std::string ReductionText(std::span<const TextureSizes> textures, const TexturePlan& plan, uint64_t budget);

}  // namespace raygraph
