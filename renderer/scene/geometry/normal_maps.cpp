#include "renderer/scene/geometry/normal_maps.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "renderer/scene/model/material_fields.h"

namespace raygraph::scene {
namespace {

constexpr size_t kBlue = 2, kTexelBytes = 4;

// No normal map with three channels is: all of its normals would point down.
bool HasNoBlue(const ImageData& image) {
    for (size_t i = kBlue; i < image.rgba.size(); i += kTexelBytes)
        if (image.rgba[i] != 0) return false;
    return true;
}

void AddZ(ImageData& image) {
    for (size_t i = 0; i < image.rgba.size(); i += kTexelBytes) {
        const float x = 2.0f * image.rgba[i] / 255.0f - 1.0f, y = 2.0f * image.rgba[i + 1] / 255.0f - 1.0f;
        const float z = std::sqrt(std::max(1.0f - x * x - y * y, 0.0f));
        image.rgba[i + kBlue] = static_cast<uint8_t>(std::lround(255.0f * (0.5f + 0.5f * z)));
    }
    // Shaders give it to what they read from blocks of two channels
    if (image.blocks.coding != image::BlockCoding::Bc5) image.blocks = {};
}

}  // namespace

void CompleteNormalMaps(SceneData& scene) {
    struct Uses {
        bool isNormalMap = false, isOther = false;
    };
    std::vector<Uses> uses(scene.images.size());
    for (const Material& material : scene.materials)
        ForEachMaterialField([&](const auto& field) {
            if constexpr (std::is_same_v<decltype(field.member), TextureRef Material::*>) {
                const TextureRef& reference = material.*field.member;
                if (!reference.IsPresent()) return;
                const bool isNormalMap = field.member == &Material::normalTexture ||
                                         field.member == &Material::clearcoatNormalTexture;
                Uses& image = uses.at(scene.textures.at(static_cast<size_t>(reference.texture)).image);
                (isNormalMap ? image.isNormalMap : image.isOther) = true;
            }
        });
    for (size_t i = 0; i < uses.size(); ++i)
        if (uses[i].isNormalMap && !uses[i].isOther && HasNoBlue(scene.images[i])) AddZ(scene.images[i]);
}

}  // namespace raygraph::scene
