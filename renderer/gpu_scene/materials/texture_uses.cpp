#include "renderer/gpu_scene/materials/texture_uses.h"

#include <type_traits>

#include "renderer/scene/model/material_fields.h"

namespace raygraph {

namespace {

using scene::Material;
using scene::TextureRef;

// The roles of one texture over all materials.
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

}  // namespace raygraph
