#include "renderer/graph/memory_plan.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace raygraph {

namespace {

// Calls visit(index, bits) for the words that hold positions [first, last], as long as it returns true;
// returns whether it always has.
template <typename Visit>
bool ForEachWord(uint32_t first, uint32_t last, Visit&& visit) {
    const uint32_t firstWord = first / 64, lastWord = last / 64;
    for (uint32_t word = firstWord; word <= lastWord; ++word) {
        uint64_t bits = ~uint64_t{0};
        if (word == firstWord) bits <<= first % 64;
        if (word == lastWord) bits &= ~uint64_t{0} >> (63 - last % 64);
        if (!visit(word, bits)) return false;
    }
    return true;
}

}  // namespace

void PlanMemory(const FrameGraph& graph, Plan& plan, BlockMemory& memory) {
    std::vector<uint32_t>& order = memory.order;
    order.clear();
    for (uint32_t r = 0; r < graph.resources.size(); ++r) {
        const GraphResource& resource = graph.resources[r];
        if (resource.origin == Origin::Transient && resource.memory.size > 0 && plan.lifetimes[r].IsUsed())
            order.push_back(r);
    }
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
        const uint64_t sizeA = graph.resources[a].memory.size, sizeB = graph.resources[b].memory.size;
        return sizeA != sizeB ? sizeA > sizeB : a < b;
    });

    // A lifetime may end one position after the last pass.
    const auto lastPosition = static_cast<uint32_t>(plan.passes.size());
    const size_t wordsOfBlock = lastPosition / 64 + 1;
    memory.isOccupied.clear();
    for (const uint32_t r : order) {
        const rhi::MemoryRequirements& needed = graph.resources[r].memory;
        Lifetime& lifetime = plan.lifetimes[r];
        const uint32_t first = lifetime.isConcurrent ? 0 : lifetime.first;
        const uint32_t last = lifetime.isConcurrent ? lastPosition : lifetime.last;
        const auto fits = [&](uint32_t block) {
            if ((plan.blocks[block].memoryTypeBits & needed.memoryTypeBits) == 0) return false;
            return ForEachWord(first, last, [&](uint32_t word, uint64_t bits) {
                return (memory.isOccupied[block * wordsOfBlock + word] & bits) == 0;
            });
        };
        uint32_t block = 0;
        while (block < plan.blocks.size() && !fits(block)) ++block;
        if (block == plan.blocks.size()) {
            plan.blocks.push_back(needed);
            memory.isOccupied.resize(plan.blocks.size() * wordsOfBlock);
        }
        rhi::MemoryRequirements& shared = plan.blocks[block];
        shared.size = std::max(shared.size, needed.size);
        shared.alignment = std::max(shared.alignment, needed.alignment);
        shared.memoryTypeBits &= needed.memoryTypeBits;
        ForEachWord(first, last, [&](uint32_t word, uint64_t bits) {
            memory.isOccupied[block * wordsOfBlock + word] |= bits;
            return true;
        });
        lifetime.block = block;
        plan.bytesWithoutAliasing += needed.size;
    }
}

}  // namespace raygraph
