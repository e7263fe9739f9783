#include "renderer/gpu_scene/alpha_bounds.h"

#include <algorithm>

namespace raygraph {

float LowestAlpha(std::span<const glm::vec4> colors) {
    float lowest = 1.0f;
    for (const glm::vec4& color : colors) lowest = std::min(lowest, color.a);
    return lowest;
}

std::vector<float> LowestTextureAlphas(const scene::SceneData& scene) {
    constexpr float kUnknown = -1.0f;
    std::vector<float> byImage(scene.images.size(), kUnknown), byMaterial;
    for (const scene::Material& material : scene.materials) {
        byMaterial.push_back(1.0f);
        if (!material.baseColorTexture.IsPresent()) continue;
        const auto texture = static_cast<size_t>(material.baseColorTexture.texture);
        const uint32_t image = scene.textures[texture].image;
        if (byImage[image] == kUnknown)
            byImage[image] = static_cast<float>(scene::LowestAlpha(scene.images[image])) / 255.0f;
        byMaterial.back() = byImage[image];
    }
    return byMaterial;
}

}  // namespace raygraph
