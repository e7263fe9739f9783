#include "renderer/gpu_scene/materials/texture_plan.h"

#include <algorithm>
#include <map>
#include <queue>
#include <utility>

#include "base/text.h"

namespace raygraph {

namespace {

// Returns one choice for each first level: with all levels below it, or with that level alone.
std::vector<TextureChoice> Choices(std::span<const uint64_t> levelBytes, bool makesMipLevels, bool isBlocks) {
    std::vector<TextureChoice> choices;
    for (uint32_t level = 0; level < levelBytes.size(); ++level)
        choices.push_back({level, levelBytes[level], isBlocks});
    if (makesMipLevels)
        for (size_t level = choices.size() - 1; level > 0; --level)
            choices[level - 1].bytes += choices[level].bytes;
    return choices;
}

}  // namespace

TextureSizes PlainTextureSizes(rhi::Extent2D extent, bool makesMipLevels) {
    std::vector<uint64_t> levelBytes;
    for (uint32_t level = 0; level < rhi::FullMipCount(extent); ++level)
        levelBytes.push_back(rhi::ImageBytes(rhi::Format::Rgba8Unorm, rhi::MipExtent(extent, level)));
    return {extent, Choices(levelBytes, makesMipLevels, false)};
}

TextureSizes BlockTextureSizes(rhi::Extent2D extent, std::span<const uint64_t> levelBytes,
                               bool makesMipLevels) {
    TextureSizes sizes{extent, {}};
    const auto add = [&](const TextureChoice& choice) {
        if (sizes.choices.empty() || choice.bytes < sizes.choices.back().bytes)
            sizes.choices.push_back(choice);
    };
    for (const TextureChoice& choice : Choices(levelBytes, makesMipLevels, true)) add(choice);
    for (const TextureChoice& choice : PlainTextureSizes(extent, makesMipLevels).choices)
        if (choice.firstLevel >= levelBytes.size()) add(choice);
    return sizes;
}

TexturePlan PlanTextures(std::span<const TextureSizes> textures, uint64_t budget) {
    TexturePlan plan;
    std::vector<size_t> chosen(textures.size(), 0);
    // Bytes and index of the textures, the largest first; the lowest index is first among equal ones
    std::priority_queue<std::pair<uint64_t, int64_t>> largest;
    for (size_t i = 0; i < textures.size(); ++i) {
        const uint64_t bytes = textures[i].choices.front().bytes;
        plan.bytes += bytes;
        largest.emplace(bytes, -static_cast<int64_t>(i));
    }
    while (plan.bytes > budget && !largest.empty()) {
        const auto [bytes, negative] = largest.top();
        largest.pop();
        const auto texture = static_cast<size_t>(-negative);
        const std::vector<TextureChoice>& choices = textures[texture].choices;
        if (chosen[texture] + 1 == choices.size()) continue;  // it has no smaller choice
        const uint64_t smaller = choices[++chosen[texture]].bytes;
        plan.bytes -= bytes - smaller;
        largest.emplace(smaller, negative);
    }
    for (size_t i = 0; i < textures.size(); ++i) plan.choices.push_back(textures[i].choices[chosen[i]]);
    return plan;
}

std::string ReductionText(std::span<const TextureSizes> textures, const TexturePlan& plan, uint64_t budget) {
    constexpr size_t kMaxKinds = 4;
    using Size = std::pair<uint32_t, uint32_t>;
    std::map<std::pair<Size, Size>, uint32_t, std::greater<>> kinds;
    uint32_t count = 0;
    for (size_t i = 0; i < textures.size(); ++i) {
        if (plan.choices[i].firstLevel == 0) continue;
        const rhi::Extent2D from = textures[i].extent, to = rhi::MipExtent(from, plan.choices[i].firstLevel);
        ++kinds[{{from.width, from.height}, {to.width, to.height}}];
        ++count;
    }
    if (count == 0) return {};
    std::string text;
    size_t kind = 0;
    for (const auto& [sizes, ofKind] : kinds) {
        if (kind++ == kMaxKinds) {
            text += Text(", and {} more sizes", kinds.size() - kMaxKinds);
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
