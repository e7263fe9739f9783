// Barrier planner: computes the dependency between the state of a resource and its next access. Pure.
//
// Rules, for a resource whose last write is W and that has been read by R since:
//   read after W      waits for W and makes it visible; nothing if other reads have made W visible there
//   read after read   nothing, in the same layout
//   write after R     waits for R without memory access: an execution dependency only
//   write after W     waits for W and makes it available
//   other layout      a transition; it counts as a write that every later access waits for
// The validation layers do not see image writes of TraceRays, so tests check these rules.
// Threads: plain values and pure functions, for any thread.
#pragma once

#include <span>

#include "base/api.h"
#include "renderer/graph/access.h"

namespace raygraph {

// All accesses that change memory.
inline constexpr VkAccessFlags2 kWriteAccesses =
    VK_ACCESS_2_SHADER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT |
    VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT |
    VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_HOST_WRITE_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT |
    VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;

struct AccessRequest {
    AccessMasks masks{};  // a layout of UNDEFINED: it is no texture, or any layout will do
    bool writes = false;
    bool needsContents = true;  // false: a transition may discard the old contents
};

struct Dependency {
    VkPipelineStageFlags2 srcStages = VK_PIPELINE_STAGE_2_NONE;
    VkAccessFlags2 srcAccess = VK_ACCESS_2_NONE;
    VkPipelineStageFlags2 dstStages = VK_PIPELINE_STAGE_2_NONE;
    VkAccessFlags2 dstAccess = VK_ACCESS_2_NONE;
    VkImageLayout oldLayout = VK_IMAGE_LAYOUT_UNDEFINED;
    VkImageLayout newLayout = VK_IMAGE_LAYOUT_UNDEFINED;
    bool isNeeded = false;

    bool operator==(const Dependency&) const = default;
};

// Returns the dependency that must precede the access, and advances `state` to the state after it.
RAYGRAPH_API Dependency PlanAccess(ResourceState& state, const AccessRequest& request);

// Returns one state for planning an access to several resources with these states: it waits at least for
// everything that each of them waits for. Layout and queue family are those of the first.
RAYGRAPH_API ResourceState Merged(std::span<const ResourceState> states);

}  // namespace raygraph
