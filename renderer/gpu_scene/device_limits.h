// The limits of what a device can bind, which are checked before a scene is uploaded: no frame of a scene
// that exceeds them could be drawn.
#pragma once

#include <cstdint>
#include <string>

#include "rhi/device.h"

namespace raygraph {

struct PreparedContent;

// Throws Error{Usage} for more textures than a shader can read and for images that are too large;
// Error{OutOfMemory} for tables that are too large. Each says what was asked for and what the limit is.
void CheckLimits(const rhi::Device& device, const PreparedContent& content);

// Throws Error{OutOfMemory} if a shader cannot bind a buffer of `count` records.
void RequireBindable(const rhi::Device& device, const std::string& what, uint64_t count,
                     uint64_t recordBytes);

// Throws Error{Usage} if `index` is not below `count`: "GpuScene: light 3 does not exist; the scene has 2".
void RequireIndex(const char* what, uint32_t index, size_t count);

// Returns how many groups of instances a TLAS can hold. RequirePlacements throws Error{Usage} for more.
uint64_t MaxPlacements(const rhi::Device& device);
void RequirePlacements(const rhi::Device& device, uint64_t count);

}  // namespace raygraph
