// The fields of a Material. The saver, the scene's hash, Check and the editor's inspector go over this list,
// so that none of them can leave one out; the importer and its tables take from it what they need of a field
// (fields.h), and a test that goes over the list sees to it that each is read. Threads: constants.
#pragma once

#include <optional>

#include "renderer/scene/fields.h"

namespace raygraph::scene {

template <typename T>
using MaterialField = Field<Material, T>;

struct TextureField : FieldPlace<Material, TextureRef> {
    ColorSpace colorSpace;  // of rgb
};

namespace material_fields {

using M = Material;
inline constexpr const char* kPbr = "pbrMetallicRoughness";
inline constexpr const char* kSpecular = "KHR_materials_specular";
inline constexpr const char* kTransmission = "KHR_materials_transmission";
inline constexpr const char* kVolume = "KHR_materials_volume";
inline constexpr const char* kClearcoat = "KHR_materials_clearcoat";
inline constexpr const char* kSheen = "KHR_materials_sheen";
inline constexpr const char* kAnisotropy = "KHR_materials_anisotropy";
inline constexpr const char* kIridescence = "KHR_materials_iridescence";
inline constexpr const char* kDiffuseTransmission = "KHR_materials_diffuse_transmission";
inline constexpr const char* kRetroreflection = "KHR_materials_retroreflection";
inline constexpr const char* kVolumeScatter = "KHR_materials_volume_scatter";
inline constexpr const char* kSpecularGlossiness = "KHR_materials_pbrSpecularGlossiness";
using Texture = TextureField;
using Number = MaterialField<float>;
using Color = MaterialField<glm::vec3>;

// All but the name, in the order of Material.
inline constexpr auto kAll = std::tuple{
    MaterialField<glm::vec4>{{&M::baseColorFactor, "baseColorFactor", kPbr, "baseColorFactor"}, kShare},
    Texture{{&M::baseColorTexture, "baseColorTexture", kPbr, "baseColorTexture"}, ColorSpace::Srgb},
    Number{{&M::metallicFactor, "metallicFactor", kPbr, "metallicFactor"}, kShare},
    Number{{&M::roughnessFactor, "roughnessFactor", kPbr, "roughnessFactor"}, kShare},
    Texture{{&M::metallicRoughnessTexture, "metallicRoughnessTexture", kPbr, "metallicRoughnessTexture"},
            ColorSpace::Linear},
    Texture{{&M::normalTexture, "normalTexture", "", "normalTexture"}, ColorSpace::Linear},
    Number{{&M::normalScale, "normalScale", "normalTexture", "scale"}, kAnyNumber},
    Texture{{&M::occlusionTexture, "occlusionTexture", "", "occlusionTexture"}, ColorSpace::Linear},
    Number{{&M::occlusionStrength, "occlusionStrength", "occlusionTexture", "strength"}, kShare},
    Color{{&M::emissiveFactor, "emissiveFactor", "", "emissiveFactor"}, kColorBesideStrength},
    Number{{&M::emissiveStrength, "emissiveStrength", "KHR_materials_emissive_strength", "emissiveStrength"},
           kNotNegative,
           "W/(sr m^2)"},
    Texture{{&M::emissiveTexture, "emissiveTexture", "", "emissiveTexture"}, ColorSpace::Srgb},
    MaterialField<AlphaMode>{{&M::alphaMode, "alphaMode", "", "alphaMode"}},
    Number{{&M::alphaCutoff, "alphaCutoff", "", "alphaCutoff"}, kNotNegative},
    MaterialField<bool>{{&M::isDoubleSided, "isDoubleSided", "", "doubleSided"}},
    Number{{&M::ior, "ior", "KHR_materials_ior", "ior"}, {1.0f, M::kMaxIor, true}},
    Number{{&M::specularFactor, "specularFactor", kSpecular, "specularFactor"}, kShare},
    Texture{{&M::specularTexture, "specularTexture", kSpecular, "specularTexture"}, ColorSpace::Linear},
    Color{{&M::specularColorFactor, "specularColorFactor", kSpecular, "specularColorFactor"}, kNotNegative},
    Texture{{&M::specularColorTexture, "specularColorTexture", kSpecular, "specularColorTexture"},
            ColorSpace::Srgb},
    Number{{&M::transmissionFactor, "transmissionFactor", kTransmission, "transmissionFactor"}, kShare},
    Texture{{&M::transmissionTexture, "transmissionTexture", kTransmission, "transmissionTexture"},
            ColorSpace::Linear},
    Number{{&M::thicknessFactor, "thicknessFactor", kVolume, "thicknessFactor"}, kNotNegative, "m"},
    Color{{&M::attenuationColor, "attenuationColor", kVolume, "attenuationColor"}, kShare},
    Number{{&M::attenuationDistance, "attenuationDistance", kVolume, "attenuationDistance"},
           kNotNegative,
           "m",
           true},
    MaterialField<bool>{{&M::isUnlit, "isUnlit", "KHR_materials_unlit", ""}},
    Number{{&M::clearcoatFactor, "clearcoatFactor", kClearcoat, "clearcoatFactor"}, kShare},
    Texture{{&M::clearcoatTexture, "clearcoatTexture", kClearcoat, "clearcoatTexture"}, ColorSpace::Linear},
    Number{{&M::clearcoatRoughnessFactor, "clearcoatRoughnessFactor", kClearcoat, "clearcoatRoughnessFactor"},
           kShare},
    Texture{
        {&M::clearcoatRoughnessTexture, "clearcoatRoughnessTexture", kClearcoat, "clearcoatRoughnessTexture"},
        ColorSpace::Linear},
    Texture{{&M::clearcoatNormalTexture, "clearcoatNormalTexture", kClearcoat, "clearcoatNormalTexture"},
            ColorSpace::Linear},
    Number{{&M::clearcoatNormalScale, "clearcoatNormalScale", kClearcoat, "clearcoatNormalTexture.scale"},
           kAnyNumber},
    Color{{&M::sheenColorFactor, "sheenColorFactor", kSheen, "sheenColorFactor"}, kShare},
    Texture{{&M::sheenColorTexture, "sheenColorTexture", kSheen, "sheenColorTexture"}, ColorSpace::Srgb},
    Number{{&M::sheenRoughnessFactor, "sheenRoughnessFactor", kSheen, "sheenRoughnessFactor"}, kShare},
    Texture{{&M::sheenRoughnessTexture, "sheenRoughnessTexture", kSheen, "sheenRoughnessTexture"},
            ColorSpace::Linear},
    Number{{&M::anisotropyStrength, "anisotropyStrength", kAnisotropy, "anisotropyStrength"}, kShare},
    Number{{&M::anisotropyRotation, "anisotropyRotation", kAnisotropy, "anisotropyRotation"},
           {-1e9f, 1e9f},
           "rad"},
    Texture{{&M::anisotropyTexture, "anisotropyTexture", kAnisotropy, "anisotropyTexture"},
            ColorSpace::Linear},
    Number{{&M::iridescenceFactor, "iridescenceFactor", kIridescence, "iridescenceFactor"}, kShare},
    Texture{{&M::iridescenceTexture, "iridescenceTexture", kIridescence, "iridescenceTexture"},
            ColorSpace::Linear},
    Number{{&M::iridescenceIor, "iridescenceIor", kIridescence, "iridescenceIor"}, {1.0f, M::kMaxIor}},
    Number{{&M::iridescenceThicknessMinimum, "iridescenceThicknessMinimum", kIridescence,
            "iridescenceThicknessMinimum"},
           {0.0f, M::kMaxFilm},
           "nm"},
    Number{{&M::iridescenceThicknessMaximum, "iridescenceThicknessMaximum", kIridescence,
            "iridescenceThicknessMaximum"},
           {0.0f, M::kMaxFilm},
           "nm"},
    Texture{{&M::iridescenceThicknessTexture, "iridescenceThicknessTexture", kIridescence,
             "iridescenceThicknessTexture"},
            ColorSpace::Linear},
    Number{{&M::dispersion, "dispersion", "KHR_materials_dispersion", "dispersion"}, kNotNegative},
    Number{{&M::diffuseTransmissionFactor, "diffuseTransmissionFactor", kDiffuseTransmission,
            "diffuseTransmissionFactor"},
           kShare},
    Texture{{&M::diffuseTransmissionTexture, "diffuseTransmissionTexture", kDiffuseTransmission,
             "diffuseTransmissionTexture"},
            ColorSpace::Linear},
    Color{{&M::diffuseTransmissionColorFactor, "diffuseTransmissionColorFactor", kDiffuseTransmission,
           "diffuseTransmissionColorFactor"},
          kShare},
    Texture{{&M::diffuseTransmissionColorTexture, "diffuseTransmissionColorTexture", kDiffuseTransmission,
             "diffuseTransmissionColorTexture"},
            ColorSpace::Srgb},
    Number{{&M::retroreflectionFactor, "retroreflectionFactor", kRetroreflection, "retroreflectionFactor"},
           kShare},
    Texture{
        {&M::retroreflectionTexture, "retroreflectionTexture", kRetroreflection, "retroreflectionTexture"},
        ColorSpace::Linear},
    Color{{&M::multiscatterColorFactor, "multiscatterColorFactor", kVolumeScatter, "multiscatterColorFactor"},
          kShare},
    Number{{&M::scatterAnisotropy, "scatterAnisotropy", kVolumeScatter, "scatterAnisotropy"},
           {-M::kMaxScatterAnisotropy, M::kMaxScatterAnisotropy}},
    MaterialField<bool>{{&M::isSpecularGlossiness, "isSpecularGlossiness", kSpecularGlossiness, ""}},
    MaterialField<uint32_t>{{&M::priority, "priority", "extras", "priority"}},
};

}  // namespace material_fields

// A field of a material that isSpecularGlossiness: with its place in the extension and the range there, if it
// is one of those that the extension has. Nothing: such a material has no such field.
template <typename Field>
constexpr std::optional<Field> SpecularGlossinessField(Field field) {
    struct Key {
        std::string_view name;
        const char* key;  // null: there is none
    };
    constexpr Key kKeys[] = {
        {"baseColorFactor", "diffuseFactor"},
        {"baseColorTexture", "diffuseTexture"},
        {"roughnessFactor", "glossinessFactor"},
        {"specularColorFactor", "specularFactor"},
        {"specularColorTexture", "specularGlossinessTexture"},
        {"metallicFactor", nullptr},
        {"metallicRoughnessTexture", nullptr},
        {"ior", nullptr},
        {"specularFactor", nullptr},
        {"specularTexture", nullptr},
    };
    for (const Key& place : kKeys) {
        if (place.name != field.name) continue;
        if (!place.key) return std::nullopt;
        field.object = material_fields::kSpecularGlossiness;
        field.key = place.key;
        if constexpr (requires { field.range; }) field.range = kShare;
    }
    return field;
}

// Whether the file has 1 minus the value in the place of the field.
template <typename Field>
constexpr bool IsGlossiness(const Field& field) {
    return field.key == std::string_view("glossinessFactor");
}

// Calls visit(field) for each field that a material of the kind of this one has, with its place there, in the
// order of Material. Whether it is of that kind is no field, but known by then.
template <typename Visit>
constexpr void ForEachFieldOf(const Material& material, Visit&& visit) {
    const auto visitPlaced = [&](const auto& field) {
        if (!material.isSpecularGlossiness)
            visit(field);
        else if (const auto placed = SpecularGlossinessField(field))
            visit(*placed);
    };
    std::apply([&](const auto&... field) { (visitPlaced(field), ...); }, material_fields::kAll);
}

// The fields of a TextureTransform, in the extension of that name of a texture's place in the file.
template <typename T>
using TransformField = Field<TextureTransform, T>;

inline constexpr const char* kTextureTransform = "KHR_texture_transform";
// Far above any use, and no product with a texture coordinate of the same size is infinite.
inline constexpr FieldRange kTextureSteps{-1e9f, 1e9f};
inline constexpr auto kTransformFields = std::tuple{
    TransformField<glm::vec2>{{&TextureTransform::offset, "offset", "", "offset"}, kTextureSteps},
    TransformField<float>{{&TextureTransform::rotation, "rotation", "", "rotation"}, kTextureSteps, "rad"},
    TransformField<glm::vec2>{{&TextureTransform::scale, "scale", "", "scale"}, kTextureSteps},
};

// Calls visit(field) for each.
template <typename Visit>
constexpr void ForEachTransformField(Visit&& visit) {
    std::apply([&](const auto&... field) { (visit(field), ...); }, kTransformFields);
}

// The one of a member.
template <typename T>
constexpr auto FieldOf(T TextureTransform::*member) {
    return FindField(member, kTransformFields);
}

// Calls visit(field) for each, in the order of Material; `visit` has to take every type of field.
template <typename Visit>
constexpr void ForEachMaterialField(Visit&& visit) {
    std::apply([&](const auto&... field) { (visit(field), ...); }, material_fields::kAll);
}

// Whether pictures depend on the texture. None depends on occlusion.
constexpr bool IsShown(TextureRef Material::*member) {
    return member != &Material::occlusionTexture;
}

// Calls visit(reference) for each texture of the material that pictures depend on.
template <typename Visit>
void ForEachShownTexture(const Material& material, Visit&& visit) {
    ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), TextureRef Material::*>)
            if ((material.*field.member).IsPresent() && IsShown(field.member)) visit(material.*field.member);
    });
}

// The one of a member.
template <typename T>
constexpr auto FieldOf(T Material::*member) {
    return FindField(member, material_fields::kAll);
}

}  // namespace raygraph::scene
