#include "renderer/gpu_scene/geometry/alpha_bounds.h"

#include <algorithm>

namespace raygraph {

float LowestAlpha(std::span<const glm::vec4> colors) {
    float lowest = 1.0f;
    for (const glm::vec4& color : colors) lowest = std::min(lowest, color.a);
    return lowest;
}

std::vector<float> LowestTextureAlphas(scene::SceneData& scene) {
    std::vector<float> byMaterial;
    for (const scene::Material& material : scene.materials) {
        byMaterial.push_back(1.0f);
        if (!material.baseColorTexture.IsPresent()) continue;
        const auto texture = static_cast<size_t>(material.baseColorTexture.texture);
        scene::ImageData& image = scene.images[scene.textures[texture].image];
        image.lowestAlpha = scene::LowestAlpha(image);
        byMaterial.back() = static_cast<float>(*image.lowestAlpha) / 255.0f;
    }
    return byMaterial;
}

}  // namespace raygraph
