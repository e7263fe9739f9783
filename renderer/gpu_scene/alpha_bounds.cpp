#include "renderer/gpu_scene/alpha_bounds.h"

#include <algorithm>

namespace raygraph {

namespace {

float LowestAlpha(const scene::ImageData& image) {
    uint8_t lowest = 255;
    for (size_t i = 3; i < image.rgba.size() && lowest > 0; i += 4) lowest = std::min(lowest, image.rgba[i]);
    return static_cast<float>(lowest) / 255.0f;
}

}  // namespace

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
        if (byImage[image] == kUnknown) byImage[image] = LowestAlpha(scene.images[image]);
        byMaterial.back() = byImage[image];
    }
    return byMaterial;
}

}  // namespace raygraph
