#include "renderer/gpu_scene/texture_plan.h"

#include <algorithm>
#include <map>
#include <queue>
#include <utility>

#include "base/text.h"

namespace raygraph {

TextureSizes PlainTextureSizes(rhi::Extent2D extent, bool hasLevels) {
    constexpr uint64_t kTexelBytes = 4;
    TextureSizes sizes{.extent = extent, .bytes = {}};
    for (uint32_t level = 0; level < rhi::FullMipCount(extent); ++level) {
        const rhi::Extent2D size = rhi::MipExtent(extent, level);
        sizes.bytes.push_back(kTexelBytes * size.width * size.height);
    }
    if (hasLevels)
        for (size_t level = sizes.bytes.size() - 1; level > 0; --level)
            sizes.bytes[level - 1] += sizes.bytes[level];
    return sizes;
}

TexturePlan PlanTextures(std::span<const TextureSizes> textures, uint64_t budget) {
    TexturePlan plan;
    plan.firstLevels.assign(textures.size(), 0);
    // Bytes, and the texture: the largest first, of equal ones that with the lowest index
    std::priority_queue<std::pair<uint64_t, int64_t>> largest;
    for (size_t i = 0; i < textures.size(); ++i) {
        plan.bytes += textures[i].bytes.front();
        largest.emplace(textures[i].bytes.front(), -static_cast<int64_t>(i));
    }
    while (plan.bytes > budget && !largest.empty()) {
        const auto texture = static_cast<size_t>(-largest.top().second);
        largest.pop();
        const std::vector<uint64_t>& bytes = textures[texture].bytes;
        uint32_t& level = plan.firstLevels[texture];
        if (level + 1 == bytes.size()) continue;  // stays as it is
        plan.bytes -= bytes[level] - bytes[level + 1];
        ++level;
        largest.emplace(bytes[level], -static_cast<int64_t>(texture));
    }
    return plan;
}

std::string ReductionText(std::span<const TextureSizes> textures, const TexturePlan& plan, uint64_t budget) {
    constexpr size_t kMostKinds = 4;
    using Size = std::pair<uint32_t, uint32_t>;
    std::map<std::pair<Size, Size>, uint32_t, std::greater<>> kinds;
    uint32_t count = 0;
    for (size_t i = 0; i < textures.size(); ++i) {
        if (plan.firstLevels[i] == 0) continue;
        const rhi::Extent2D from = textures[i].extent, to = rhi::MipExtent(from, plan.firstLevels[i]);
        ++kinds[{{from.width, from.height}, {to.width, to.height}}];
        ++count;
    }
    if (count == 0) return {};
    std::string text;
    size_t kind = 0;
    for (const auto& [sizes, ofKind] : kinds) {
        if (kind++ == kMostKinds) {
            text += Text(", and {} more sizes", kinds.size() - kMostKinds);
            break;
        }
        const auto& [from, to] = sizes;
        text += Text("{}{} of {}x{} texels {} {}x{}", kind == 1 ? "" : ", ", ofKind, from.first, from.second,
                     ofKind == 1 ? "is" : "are", to.first, to.second);
    }
    return Text("{} of {} textures {} smaller on the device, to fit {} into a budget of {}: {}", count,
                textures.size(), count == 1 ? "is" : "are", BytesText(plan.bytes), BytesText(budget), text);
}

}  // namespace raygraph
