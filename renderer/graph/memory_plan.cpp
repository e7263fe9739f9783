#include "renderer/graph/memory_plan.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace raygraph {

namespace {

bool Overlap(const Lifetime& a, const Lifetime& b) {
    return a.first <= b.last && b.first <= a.last;
}

}  // namespace

void PlanMemory(const FrameGraph& graph, Plan& plan) {
    std::vector<uint32_t> order;
    for (uint32_t r = 0; r < graph.resources.size(); ++r) {
        const GraphResource& resource = graph.resources[r];
        if (resource.origin == Origin::Transient && resource.memory.size > 0 && plan.lifetimes[r].IsUsed())
            order.push_back(r);
    }
    std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
        return graph.resources[a].memory.size > graph.resources[b].memory.size;
    });

    for (size_t i = 0; i < order.size(); ++i) {
        const rhi::MemoryRequirements& memory = graph.resources[order[i]].memory;
        Lifetime& lifetime = plan.lifetimes[order[i]];
        const auto fits = [&](uint32_t block) {
            if ((plan.blocks[block].memoryTypeBits & memory.memoryTypeBits) == 0) return false;
            return std::none_of(
                order.begin(), order.begin() + static_cast<ptrdiff_t>(i), [&](uint32_t other) {
                    return plan.lifetimes[other].block == block && Overlap(plan.lifetimes[other], lifetime);
                });
        };
        uint32_t block = 0;
        while (block < plan.blocks.size() && !fits(block)) ++block;
        if (block == plan.blocks.size()) plan.blocks.push_back(memory);
        rhi::MemoryRequirements& shared = plan.blocks[block];
        shared.size = std::max(shared.size, memory.size);
        shared.alignment = std::max(shared.alignment, memory.alignment);
        shared.memoryTypeBits &= memory.memoryTypeBits;
        lifetime.block = block;
        plan.bytesWithoutAliasing += memory.size;
    }
}

}  // namespace raygraph
