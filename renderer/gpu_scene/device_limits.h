// The limits of what a device can bind, checked before a scene is uploaded: a frame that exceeds them could
// not be drawn, nor the next one.
#pragma once

#include <cstdint>
#include <string>

#include "rhi/device.h"

namespace raygraph {

struct PreparedContent;

// Throws Error{Usage} for more textures than a shader can read and for images that are too large;
// Error{OutOfMemory} for tables that are too large. Each says what was asked for and what the limit is.
void CheckLimits(const rhi::Device& device, const PreparedContent& content);

// Throws Error{OutOfMemory} if a shader cannot bind a buffer of so many records.
void RequireBindable(const rhi::Device& device, const std::string& what, uint64_t count,
                     uint64_t recordBytes);

// Throws Error{Usage} if the scene has not so many: "GpuScene: light 3 does not exist; the scene has 2".
void RequireIndex(const char* what, uint32_t index, size_t count);

// Groups of instances that a TLAS can hold; RequirePlacements throws Error{Usage} if it cannot hold so many.
uint64_t MaxPlacements(const rhi::Device& device);
void RequirePlacements(const rhi::Device& device, uint64_t count);

}  // namespace raygraph
