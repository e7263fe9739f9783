#include "renderer/graph/barrier_planner.h"

#include <algorithm>

namespace raygraph {

namespace {

bool Contains(VkFlags64 set, VkFlags64 bits) {
    return (set & bits) == bits;
}

// Returns the flags together with the accesses that combined flags include.
VkAccessFlags2 Expanded(VkAccessFlags2 access) {
    if ((access & VK_ACCESS_2_SHADER_READ_BIT) == 0) return access;
    return access | VK_ACCESS_2_UNIFORM_READ_BIT | VK_ACCESS_2_SHADER_SAMPLED_READ_BIT |
           VK_ACCESS_2_SHADER_STORAGE_READ_BIT;
}

Dependency PlanRead(ResourceState& state, const AccessMasks& masks) {
    state.readStages |= masks.stages;
    const bool isNeverWritten = state.writeStages == VK_PIPELINE_STAGE_2_NONE;
    const bool isVisible =
        Contains(state.visibleStages, masks.stages) && Contains(Expanded(state.visibleAccess), masks.access);
    if (isNeverWritten || isVisible) return {.oldLayout = state.layout, .newLayout = state.layout};
    // Visibility is stored as a product of stages and accesses, so that the new barrier covers the whole
    // product. Stages to which the write was visible already wait for it once more, which costs nothing.
    state.visibleStages |= masks.stages;
    state.visibleAccess |= masks.access;
    return {.srcStages = state.writeStages,
            .srcAccess = state.writeAccess,
            .dstStages = state.visibleStages,
            .dstAccess = state.visibleAccess,
            .oldLayout = state.layout,
            .newLayout = state.layout,
            .isNeeded = true};
}

}  // namespace

Dependency PlanAccess(ResourceState& state, const AccessRequest& request) {
    const AccessMasks& masks = request.masks;
    const bool changesLayout = masks.layout != VK_IMAGE_LAYOUT_UNDEFINED && masks.layout != state.layout;
    if (!request.writes && !changesLayout) return PlanRead(state, masks);

    // Reads since the last write have waited for it and made it available, so that waiting for them is
    // enough.
    const bool isRead = state.readStages != VK_PIPELINE_STAGE_2_NONE;
    Dependency dependency{.srcStages = isRead ? state.readStages : state.writeStages,
                          .srcAccess = isRead ? VK_ACCESS_2_NONE : state.writeAccess,
                          .dstStages = masks.stages,
                          .dstAccess = masks.access,
                          .oldLayout = state.layout,
                          .newLayout = changesLayout ? masks.layout : state.layout};
    if (changesLayout && !request.needsContents) dependency.oldLayout = VK_IMAGE_LAYOUT_UNDEFINED;
    dependency.isNeeded = changesLayout || dependency.srcStages != VK_PIPELINE_STAGE_2_NONE;

    state.layout = dependency.newLayout;
    state.writeStages = masks.stages;
    if (request.writes) {
        state.writeAccess = masks.access & kWriteAccesses;
        state.readStages = VK_PIPELINE_STAGE_2_NONE;
        state.visibleStages = VK_PIPELINE_STAGE_2_NONE;
        state.visibleAccess = VK_ACCESS_2_NONE;
    } else {
        // A transition for a reader is available by itself and visible to that reader, and later accesses
        // chain to the stages that waited for it.
        state.writeAccess = VK_ACCESS_2_NONE;
        state.readStages = masks.stages;
        state.visibleStages = masks.stages;
        state.visibleAccess = masks.access;
    }
    return dependency;
}

ResourceState Merged(std::span<const ResourceState> states) {
    ResourceState all = states.front();
    const auto isUnread = [](const ResourceState& state) {
        return state.writeStages != VK_PIPELINE_STAGE_2_NONE && state.readStages == VK_PIPELINE_STAGE_2_NONE;
    };
    const bool hasUnread = std::any_of(states.begin(), states.end(), isUnread);
    const bool hasRead = std::any_of(states.begin(), states.end(), [](const ResourceState& state) {
        return state.readStages != VK_PIPELINE_STAGE_2_NONE;
    });
    for (const ResourceState& state : states.subspan(1)) {
        // Contents that were never written count as visible everywhere.
        const bool isVisible = state.writeStages == VK_PIPELINE_STAGE_2_NONE;
        const bool wasVisible = all.writeStages == VK_PIPELINE_STAGE_2_NONE;
        if (wasVisible) {
            all.visibleStages = state.visibleStages;
            all.visibleAccess = state.visibleAccess;
        } else if (!isVisible) {
            all.visibleStages &= state.visibleStages;
            all.visibleAccess &= state.visibleAccess;
        }
        all.writeStages |= state.writeStages;
        all.writeAccess |= state.writeAccess;
        all.readStages |= state.readStages;
    }
    // A write that nothing has read needs a wait of its own, beside the reads of others.
    if (hasUnread && hasRead) {
        all.writeStages |= all.readStages;
        all.readStages = VK_PIPELINE_STAGE_2_NONE;
        all.visibleStages = VK_PIPELINE_STAGE_2_NONE;
        all.visibleAccess = VK_ACCESS_2_NONE;
    }
    return all;
}

}  // namespace raygraph
