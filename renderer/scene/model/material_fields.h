// The fields of a Material, made of shaders/shared/material_list.h. The importer and its tables, the saver,
// the scene's hash, Check and the editor's inspector go over this list, so that none of them can leave one
// out. Threads: constants.
#pragma once

#include <optional>

#include "renderer/scene/model/fields.h"

namespace raygraph::scene {

template <typename T>
using MaterialField = Field<Material, T>;

struct TextureField : FieldPlace<Material, TextureRef> {
    ColorSpace colorSpace;  // the space of rgb
};

namespace material_fields {

// The kinds of numbers, by the names that shaders/shared/material_list.h uses.
struct Quantity {
    FieldRange range;
    const char* unit = "";
    bool omitsZero = false;
};
inline constexpr Quantity kNoNumber{};
inline constexpr Quantity kShare{scene::kShare};
inline constexpr Quantity kNotNegative{scene::kNotNegative};
inline constexpr Quantity kAnyNumber{scene::kAnyNumber};
inline constexpr Quantity kColorBesideStrength{scene::kColorBesideStrength};
inline constexpr Quantity kRadiance{scene::kNotNegative, "W/(sr m^2)"};
inline constexpr Quantity kLength{scene::kNotNegative, "m"};
inline constexpr Quantity kDistance{scene::kNotNegative, "m", true};
inline constexpr Quantity kAngle{{-1e9f, 1e9f}, "rad"};
inline constexpr Quantity kIndex{{1.0f, Material::kMaxIor, true}};
inline constexpr Quantity kFilmIndex{{1.0f, Material::kMaxIor}};
inline constexpr Quantity kFilmThickness{{0.0f, Material::kMaxFilm}, "nm"};
inline constexpr Quantity kMeanCosine{{-Material::kMaxScatterAnisotropy, Material::kMaxScatterAnisotropy}};

// `object` is the name in the list.
template <typename T>
constexpr FieldPlace<Material, T> PlaceOf(T Material::*member, const char* name, const char* object,
                                          const char* key) {
    return {member, name, std::string_view(object) == "material" ? "" : object, key};
}
template <typename T>
constexpr MaterialField<T> Make(const FieldPlace<Material, T>& place, const Quantity& quantity) {
    return {place, quantity.range, quantity.unit, quantity.omitsZero};
}

// All fields of a Material except its name, in the order of the struct.
inline constexpr auto kAll = std::tuple{
#define RAYGRAPH_MATERIAL_FIELD(field, object, key, quantity) \
    Make(PlaceOf(&Material::field, #field, #object, #key), quantity),
#define RAYGRAPH_MATERIAL_VALUE(type, name, field, object, key, quantity) \
    Make(PlaceOf(&Material::field, #field, #object, #key), quantity),
#define RAYGRAPH_MATERIAL_FLAG(field, object) Make(PlaceOf(&Material::field, #field, #object, ""), kNoNumber),
#define RAYGRAPH_MATERIAL_TEXTURE(name, object, key, space) \
    TextureField{PlaceOf(&Material::name##Texture, #name "Texture", #object, #key), ColorSpace::space},
#define RAYGRAPH_MATERIAL_UNSHOWN(name, object, key, space) \
    TextureField{PlaceOf(&Material::name##Texture, #name "Texture", #object, #key), ColorSpace::space},
#include "shaders/shared/material_list.h"
};

}  // namespace material_fields

// Returns the list's field for that member.
template <typename T>
constexpr auto FieldOf(T Material::*member) {
    return FindField(member, material_fields::kAll);
}

inline constexpr const char* kSpecularGlossiness = FieldOf(&Material::isSpecularGlossiness).object;

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
        field.object = kSpecularGlossiness;
        field.key = place.key;
        if constexpr (requires { field.range; }) field.range = kShare;
    }
    return field;
}

// Returns whether the file has 1 minus the value in the place of the field.
template <typename Field>
constexpr bool IsGlossiness(const Field& field) {
    return field.key == std::string_view("glossinessFactor");
}

// Calls visit(field) for each field that a material has, in the order of Material. Of one that
// isSpecularGlossiness, fields have their place in that extension, and those without one are left out.
template <typename Visit>
constexpr void ForEachFieldOf(bool isSpecularGlossiness, Visit&& visit) {
    const auto visitPlaced = [&](const auto& field) {
        if (!isSpecularGlossiness)
            visit(field);
        else if (const auto placed = SpecularGlossinessField(field))
            visit(*placed);
    };
    std::apply([&](const auto&... field) { (visitPlaced(field), ...); }, material_fields::kAll);
}
template <typename Visit>
constexpr void ForEachFieldOf(const Material& material, Visit&& visit) {
    ForEachFieldOf(material.isSpecularGlossiness, visit);
}

// The fields of a TextureTransform, in the extension of that name of a texture's place in the file.
template <typename T>
using TransformField = Field<TextureTransform, T>;

inline constexpr const char* kTextureTransform = "KHR_texture_transform";
// The limit is far above any use, and no product with a texture coordinate of the same size is infinite.
inline constexpr FieldRange kTextureSteps{-1e9f, 1e9f};
inline constexpr auto kTransformFields = std::tuple{
    TransformField<glm::vec2>{{&TextureTransform::offset, "offset", "", "offset"}, kTextureSteps},
    TransformField<float>{{&TextureTransform::rotation, "rotation", "", "rotation"}, kTextureSteps, "rad"},
    TransformField<glm::vec2>{{&TextureTransform::scale, "scale", "", "scale"}, kTextureSteps},
};

// Calls visit(field) for each field of a TextureTransform.
template <typename Visit>
constexpr void ForEachTransformField(Visit&& visit) {
    std::apply([&](const auto&... field) { (visit(field), ...); }, kTransformFields);
}

// Returns the list's field for that member.
template <typename T>
constexpr auto FieldOf(T TextureTransform::*member) {
    return FindField(member, kTransformFields);
}

// Calls visit(field) for each, in the order of Material; `visit` has to take every type of field.
template <typename Visit>
constexpr void ForEachMaterialField(Visit&& visit) {
    std::apply([&](const auto&... field) { (visit(field), ...); }, material_fields::kAll);
}

// Returns whether pictures depend on the texture: not on one that the list has as UNSHOWN.
constexpr bool IsShown(TextureRef Material::*member) {
#define RAYGRAPH_MATERIAL_UNSHOWN(name, object, key, space) \
    if (member == &Material::name##Texture) return false;
#include "shaders/shared/material_list.h"
    return true;
}

// Calls visit(reference) for each texture of the material that pictures depend on.
template <typename Visit>
void ForEachShownTexture(const Material& material, Visit&& visit) {
    ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), TextureRef Material::*>)
            if ((material.*field.member).IsPresent() && IsShown(field.member)) visit(material.*field.member);
    });
}

}  // namespace raygraph::scene
