// The fields of a Material, each stated once: its name, where glTF has it, and which numbers it may hold. The
// saver, the scene's hash, Check and the editor go over this list, so that none of them can leave one out.
// For this project's own files; not installed. Threads: constants.
#pragma once

#include <limits>
#include <tuple>
#include <type_traits>

#include "renderer/scene/scene_data.h"

namespace raygraph::scene {

// Numbers of a field, of a vector each. Its default is Material's own.
struct FieldRange {
    float least = 0.0f, most = 0.0f;
    bool mayBeZero = false;  // though it is below the least
};
inline constexpr float kUnboundedField = std::numeric_limits<float>::max();
inline constexpr FieldRange kShare{0.0f, 1.0f};
inline constexpr FieldRange kNotNegative{0.0f, kUnboundedField};
inline constexpr FieldRange kAnyNumber{-kUnboundedField, kUnboundedField};

template <typename T>
struct MaterialField {
    T Material::*member;
    const char* name;
    // Where it is in a material of glTF: `key` of `object`, which is "" (the material), one of its objects,
    // an extension, or "extras". Of a flag without a key: whether the object is there.
    const char* object;
    const char* key;
    FieldRange range = {};       // of float, vec3 and vec4
    const char* unit = "";       // "": a pure number
    bool zeroIsLeftOut = false;  // glTF has no number for what 0 means here
};

namespace material_fields {

using M = Material;
inline constexpr const char* kPbr = "pbrMetallicRoughness";
inline constexpr const char* kSpecular = "KHR_materials_specular";
inline constexpr const char* kTransmission = "KHR_materials_transmission";
inline constexpr const char* kVolume = "KHR_materials_volume";
using Ref = MaterialField<TextureRef>;
using Number = MaterialField<float>;
using Color = MaterialField<glm::vec3>;

// All but the name, in the order of Material.
inline constexpr auto kAll = std::tuple{
    MaterialField<glm::vec4>{&M::baseColorFactor, "baseColorFactor", kPbr, "baseColorFactor", kShare},
    Ref{&M::baseColorTexture, "baseColorTexture", kPbr, "baseColorTexture"},
    Number{&M::metallicFactor, "metallicFactor", kPbr, "metallicFactor", kShare},
    Number{&M::roughnessFactor, "roughnessFactor", kPbr, "roughnessFactor", kShare},
    Ref{&M::metallicRoughnessTexture, "metallicRoughnessTexture", kPbr, "metallicRoughnessTexture"},
    Ref{&M::normalTexture, "normalTexture", "", "normalTexture"},
    Number{&M::normalScale, "normalScale", "normalTexture", "scale", kAnyNumber},
    Ref{&M::occlusionTexture, "occlusionTexture", "", "occlusionTexture"},
    Number{&M::occlusionStrength, "occlusionStrength", "occlusionTexture", "strength", kShare},
    Color{&M::emissiveFactor, "emissiveFactor", "", "emissiveFactor", kNotNegative, "W/(sr m^2)"},
    Number{&M::emissiveStrength, "emissiveStrength", "KHR_materials_emissive_strength", "emissiveStrength",
           kNotNegative},
    Ref{&M::emissiveTexture, "emissiveTexture", "", "emissiveTexture"},
    MaterialField<AlphaMode>{&M::alphaMode, "alphaMode", "", "alphaMode"},
    Number{&M::alphaCutoff, "alphaCutoff", "", "alphaCutoff", kNotNegative},
    MaterialField<bool>{&M::isDoubleSided, "isDoubleSided", "", "doubleSided"},
    Number{&M::ior, "ior", "KHR_materials_ior", "ior", {1.0f, M::kMostIor, true}},
    Number{&M::specularFactor, "specularFactor", kSpecular, "specularFactor", kShare},
    Ref{&M::specularTexture, "specularTexture", kSpecular, "specularTexture"},
    Color{&M::specularColorFactor, "specularColorFactor", kSpecular, "specularColorFactor", kNotNegative},
    Ref{&M::specularColorTexture, "specularColorTexture", kSpecular, "specularColorTexture"},
    Number{&M::transmissionFactor, "transmissionFactor", kTransmission, "transmissionFactor", kShare},
    Ref{&M::transmissionTexture, "transmissionTexture", kTransmission, "transmissionTexture"},
    Number{&M::thicknessFactor, "thicknessFactor", kVolume, "thicknessFactor", kNotNegative, "m"},
    Color{&M::attenuationColor, "attenuationColor", kVolume, "attenuationColor", kShare},
    Number{&M::attenuationDistance, "attenuationDistance", kVolume, "attenuationDistance", kNotNegative, "m",
           true},
    MaterialField<bool>{&M::isUnlit, "isUnlit", "KHR_materials_unlit", ""},
    MaterialField<uint32_t>{&M::priority, "priority", "extras", "priority"},
};

// A field more or less than these does not compile: list it above, then here.
inline size_t CountMembers(const Material& material) {
    const auto& [name, f1, f2, f3, f4, f5, f6, f7, f8, f9, f10, f11, f12, f13, f14, f15, f16, f17, f18, f19,
                 f20, f21, f22, f23, f24, f25, f26, f27] = material;
    std::ignore = name;
    static_assert(std::tuple_size_v<decltype(kAll)> == 27, "each field of Material is in the list, once");
    return 28;
}

}  // namespace material_fields

// Calls visit(field) for each, in the order of Material; `visit` has to take every type of field.
template <typename Visit>
constexpr void ForEachMaterialField(Visit&& visit) {
    std::apply([&](const auto&... field) { (visit(field), ...); }, material_fields::kAll);
}

// The one of a member.
template <typename T>
constexpr MaterialField<T> FieldOf(T Material::*member) {
    MaterialField<T> found{};
    ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), T Material::*>)
            if (field.member == member) found = field;
    });
    return found;
}

}  // namespace raygraph::scene
