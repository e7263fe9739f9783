#include "renderer/gpu_scene/materials/texture_plan.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <queue>
#include <type_traits>
#include <utility>

#include "base/text.h"
#include "renderer/scene/model/scene_fields.h"

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

// --- For what materials use textures ---

namespace {

using scene::Material;
using scene::TextureRef;

// Holds the roles of one texture over all materials.
struct Roles {
    bool isNormals = false, isRoughness = false, isOther = false;
    bool isOpaque = false;  // some material shows it opaque, or its alpha is not opacity
    std::optional<PairedNormals> normals;
    bool isPairAmbiguous = false;
};

void AddPair(Roles& roles, const TextureRef& roughness, float factor, const TextureRef& normal, float scale) {
    std::optional<PairedNormals> pair;
    const bool isSamePlace = normal.texCoord == roughness.texCoord && normal.transform == roughness.transform;
    if (normal.IsPresent() && isSamePlace && factor > 0.0f && scale != 0.0f)
        pair = {static_cast<uint32_t>(normal.texture), scale, factor};
    roles.isPairAmbiguous |= roles.isRoughness && roles.normals != pair;
    roles.normals = pair;
    roles.isRoughness = true;
}

void AddRole(Roles& roles, TextureRef Material::*member, const Material& material) {
    roles.isOpaque |= member != &Material::baseColorTexture || material.alphaMode == scene::AlphaMode::Opaque;
    if (member == &Material::normalTexture || member == &Material::clearcoatNormalTexture) {
        roles.isNormals = true;
    } else if (member == &Material::metallicRoughnessTexture) {
        AddPair(roles, material.metallicRoughnessTexture, material.roughnessFactor, material.normalTexture,
                material.normalScale);
    } else if (member == &Material::clearcoatRoughnessTexture) {
        AddPair(roles, material.clearcoatRoughnessTexture, material.clearcoatRoughnessFactor,
                material.clearcoatNormalTexture, material.clearcoatNormalScale);
        // Occlusion is in the red channel, often of a roughness texture.
    } else if (member != &Material::occlusionTexture) {
        roles.isOther = true;
    }
}

}  // namespace

std::vector<TextureUse> TextureUses(const scene::SceneData& scene) {
    std::vector<Roles> roles(scene.textures.size());
    for (const Material& material : scene.materials)
        scene::ForEachMaterialField([&](const auto& field) {
            if constexpr (std::is_same_v<decltype(field.member), TextureRef Material::*>) {
                const TextureRef& reference = material.*field.member;
                if (reference.IsPresent())
                    AddRole(roles[static_cast<size_t>(reference.texture)], field.member, material);
            }
        });
    std::vector<TextureUse> uses(roles.size());
    const auto isOnlyNormals = [&](size_t texture) {
        return roles[texture].isNormals && !roles[texture].isRoughness && !roles[texture].isOther &&
               scene.textures[texture].colorSpace == scene::ColorSpace::Linear;
    };
    for (size_t i = 0; i < roles.size(); ++i) {
        const Roles& role = roles[i];
        if (scene.textures[i].colorSpace == scene::ColorSpace::Srgb) {
            uses[i].content = role.isOpaque ? TexelContent::Color : TexelContent::TransparentColor;
        } else if (isOnlyNormals(i)) {
            uses[i].content = TexelContent::Normals;
        } else if (role.isRoughness && !role.isNormals && !role.isOther && !role.isPairAmbiguous &&
                   role.normals && isOnlyNormals(role.normals->texture)) {
            uses[i].normals = role.normals;
        }
    }
    return uses;
}

// --- Textures read on the host ---

namespace {

float DecodeSrgb(uint8_t value) {
    static const std::array<float, 256> kTable = [] {
        std::array<float, 256> table{};
        for (size_t i = 0; i < table.size(); ++i) {
            const double v = static_cast<double>(i) / 255.0;
            table[i] = static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
        }
        return table;
    }();
    return kTable[value];
}

glm::vec4 Texel(const scene::ImageData& image, uint32_t x, uint32_t y, bool isSrgb) {
    const uint8_t* rgba = &image.rgba[4 * (size_t{y} * image.width + x)];
    glm::vec4 color;
    for (int c = 0; c < 4; ++c)
        color[c] = isSrgb && c < 3 ? DecodeSrgb(rgba[c]) : static_cast<float>(rgba[c]) / 255.0f;
    return color;
}

}  // namespace

uint32_t WrapTexel(int64_t x, uint32_t size, scene::WrapMode mode) {
    const auto n = static_cast<int64_t>(size);
    if (mode == scene::WrapMode::ClampToEdge) return static_cast<uint32_t>(std::clamp<int64_t>(x, 0, n - 1));
    const int64_t period = mode == scene::WrapMode::Repeat ? n : 2 * n;
    const int64_t within = (x % period + period) % period;
    return static_cast<uint32_t>(within < n ? within : period - 1 - within);
}

glm::vec4 LookUp(const scene::Texture& texture, const scene::ImageData& image, const glm::vec2& uv) {
    const double x = double{uv.x} * image.width - 0.5, y = double{uv.y} * image.height - 0.5;
    if (!(std::abs(x) < 1e15 && std::abs(y) < 1e15)) return glm::vec4(0.0f);
    const auto column = static_cast<int64_t>(std::floor(x)), row = static_cast<int64_t>(std::floor(y));
    const auto at = [&](int64_t dx, int64_t dy) {
        return Texel(image, WrapTexel(column + dx, image.width, texture.sampler.wrapU),
                     WrapTexel(row + dy, image.height, texture.sampler.wrapV),
                     texture.colorSpace == scene::ColorSpace::Srgb);
    };
    const auto shareX = static_cast<float>(x - std::floor(x)), shareY = static_cast<float>(y - std::floor(y));
    return glm::mix(glm::mix(at(0, 0), at(1, 0), shareX), glm::mix(at(0, 1), at(1, 1), shareX), shareY);
}

}  // namespace raygraph
