// Every struct that a scene is made of, as the list of its fields: Fields<T>::kAll has the name and the
// member of each. ForEachField does not compile for a struct with a field that its list lacks. The lists of a
// material and a light also say where glTF has a field, and which numbers it may hold. Not installed.
// Threads: constants.
#pragma once

#include <glm/gtc/constants.hpp>
#include <optional>
#include <string_view>
#include <tuple>

#include "renderer/image/image.h"
#include "renderer/scene/model/fields.h"

namespace raygraph::scene {

// --- The fields of a Camera that an animation may change ---

namespace camera_fields {

using C = Camera;
using Number = Field<C, float>;
inline constexpr const char* kPerspective = "perspective";
inline constexpr const char* kOrthographic = "orthographic";
// glTF has open intervals: these have the ends that a float can be at.
inline constexpr FieldRange kAngle{1e-6f, 3.1415925f};
inline constexpr FieldRange kExtent{1e-9f, kUnboundedField};

// Each is of cameras of one projection alone, whose object in the file it is in.
inline constexpr auto kAll = std::tuple{
    Number{{&C::yFov, "yFov", kPerspective, "yfov"}, kAngle, "rad"},
    Number{{&C::aspectRatio, "aspectRatio", kPerspective, "aspectRatio"}, kNotNegative},
    Number{{&C::zNear, "zNear", kPerspective, "znear"}, kNotNegative, "m"},
    Number{{&C::zFar, "zFar", kPerspective, "zfar"}, kNotNegative, "m", true},
    Number{{&C::xMag, "xMag", kOrthographic, "xmag"}, kExtent, "m"},
    Number{{&C::yMag, "yMag", kOrthographic, "ymag"}, kExtent, "m"},
    Number{{&C::zNear, "zNear", kOrthographic, "znear"}, kNotNegative, "m"},
    Number{{&C::zFar, "zFar", kOrthographic, "zfar"}, kNotNegative, "m"},
};

}  // namespace camera_fields

constexpr bool HasField(Projection projection, const Field<Camera, float>& field) {
    const bool isPerspective = std::string_view(field.object) == camera_fields::kPerspective;
    return isPerspective == (projection == Projection::Perspective);
}

// Calls visit(field) for each that a camera of this projection has.
template <typename Visit>
constexpr void ForEachCameraField(Projection projection, Visit&& visit) {
    const auto look = [&](const auto& field) {
        if (HasField(projection, field)) visit(field);
    };
    std::apply([&](const auto&... field) { (look(field), ...); }, camera_fields::kAll);
}

// --- The fields of a Light that a file has and an editor may change ---
// The importer, the saver, Check, comparisons and the editor's inspector go over this list.

namespace light_fields {

using L = Light;
using Number = Field<L, float>;
inline constexpr const char* kSpot = "spot";
// A rounded pi/2 may be a little above it.
inline constexpr FieldRange kConeAngle{0.0f, glm::half_pi<float>() + 1e-5f};

// In the order of Light. What is in an object of its own, `kSpot`, is of spot lights alone.
inline constexpr auto kAll = std::tuple{
    Field<L, glm::vec3>{{&L::color, "color", "", "color"}, kColorBesideStrength},
    Number{{&L::intensity, "intensity", "", "intensity"}, kNotNegative, "cd"},
    Number{{&L::range, "range", "", "range"}, kNotNegative, "m", true},
    Number{{&L::innerConeAngle, "innerConeAngle", kSpot, "innerConeAngle"}, kConeAngle, "rad"},
    Number{{&L::outerConeAngle, "outerConeAngle", kSpot, "outerConeAngle"}, kConeAngle, "rad"},
};

}  // namespace light_fields

// Returns whether a light of `type` has a field. A directional one is at no place that a range could be
// around.
template <typename T>
constexpr bool HasField(LightType type, const Field<Light, T>& field) {
    if constexpr (std::is_same_v<T, float>)
        if (field.member == &Light::range) return type != LightType::Directional;
    return *field.object == 0 || type == LightType::Spot;
}

// Calls visit(field) for each that a light of `type` has, in the order of Light.
template <typename Visit>
constexpr void ForEachLightField(LightType type, Visit&& visit) {
    const auto look = [&](const auto& field) {
        if (HasField(type, field)) visit(field);
    };
    std::apply([&](const auto&... field) { (look(field), ...); }, light_fields::kAll);
}

// Calls visit(field) for each field of a light. A light with a profile has a factor and a color only.
template <typename Visit>
constexpr void ForEachLightField(const Light& light, Visit&& visit) {
    const auto look = [&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), float Light::*>)
            if (light.profile != kNone && field.member == &Light::range) return;
        visit(field);
    };
    ForEachLightField(light.type, look);
}

// Returns the unit of a field of a light of `type`: the intensity of a directional one is what arrives.
template <typename T>
constexpr std::string_view UnitOf(const Field<Light, T>& field, LightType type) {
    const std::string_view unit = field.unit;
    return unit == "cd" && type == LightType::Directional ? "lx" : unit;
}

// The intensity of one with a profile is a factor.
template <typename T>
constexpr std::string_view UnitOf(const Field<Light, T>& field, const Light& light) {
    const std::string_view unit = UnitOf(field, light.type);
    return unit == "cd" && light.profile != kNone ? "" : unit;
}

// The one of a member.
template <typename T>
constexpr auto FieldOf(T Light::*member) {
    return FindField(member, light_fields::kAll);
}

// The rule that ranges cannot express: the outer cone of a spot light contains the inner one.
inline bool HasCone(const Light& light) {
    return light.type != LightType::Spot || light.innerConeAngle < light.outerConeAngle;
}
inline constexpr const char* kConeRule = "innerConeAngle must be below outerConeAngle";

// --- The fields of a Material, made of shaders/shared/material_list.h ---
// The importer and its tables, the saver, the scene's hash, Check and the editor's inspector go over this
// list, so that none of them can leave one out.

template <typename T>
using MaterialField = Field<Material, T>;

struct TextureField : FieldPlace<Material, TextureRef> {
    ColorSpace colorSpace;  // the space of rgb
};

namespace material_fields {

// Holds the kinds of numbers, by the names that shaders/shared/material_list.h uses.
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

// All fields of a Material that a file has, except its name, in the order of the struct.
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

// Returns a field of a material that isSpecularGlossiness: with its place in the extension and the range
// there, if it is one of those that the extension has. Nothing: such a material has no such field.
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

// --- The fields of all structs ---

template <typename T>
struct Fields;

template <typename T>
concept HasFields = requires {
    Fields<T>::kAll;
};

// Calls visit(field) for each, in the order of the list; `visit` has to take every type of field.
template <HasFields T, typename Visit>
constexpr void ForEachField(Visit&& visit) {
    static_assert(
        std::apply([](const auto&... field) { return IsEachFieldOf<T>(field.member...); }, Fields<T>::kAll),
        "each field of the struct is in its list, once");
    std::apply([&](const auto&... field) { (visit(field), ...); }, Fields<T>::kAll);
}

// A field cannot have the name of another. A new one is a FIELD: it leaves the hashes of scenes as they are.
#define FIELD(name)          Named<Hashed::IfChanged>(&Owner::name, #name, #name)
#define LABELED(name, label) Named<Hashed::IfChanged>(&Owner::name, #name, label)
#define ALWAYS(name)         Named<Hashed::Always>(&Owner::name, #name)
#define NEVER(name)          Named<Hashed::Never>(&Owner::name, #name)
#define FIELDS(Struct, ...)                                   \
    template <>                                               \
    struct Fields<Struct> {                                   \
        using Owner = Struct;                                 \
        static constexpr auto kAll = std::tuple{__VA_ARGS__}; \
    };

FIELDS(Bounds, ALWAYS(min), ALWAYS(max))
FIELDS(JointInfluences, ALWAYS(perVertex), ALWAYS(joints), ALWAYS(weights), NEVER(bounds))
FIELDS(MorphTarget, ALWAYS(positions), ALWAYS(normals), ALWAYS(tangents), NEVER(bounds))
// `material` is that of the variant that is shown; ContentHasher has flat normals where something deforms
// the primitive.
FIELDS(Primitive, ALWAYS(positions), ALWAYS(normals), ALWAYS(tangents), ALWAYS(uv0), ALWAYS(uv1),
       ALWAYS(colors), ALWAYS(indices), ALWAYS(material), ALWAYS(bounds), NEVER(variants), LABELED(radii, ""),
       LABELED(tangentTexCoord, "tangents"), LABELED(frameTurns, "turns"), LABELED(influences, "joints"),
       LABELED(targets, "targets"), NEVER(hasFlatNormals))
FIELDS(Mesh, NEVER(name), ALWAYS(primitives), LABELED(weights, ""))
FIELDS(TextureRef, ALWAYS(texture), ALWAYS(texCoord), LABELED(transform, ""))
FIELDS(Sampler, ALWAYS(wrapU), ALWAYS(wrapV), ALWAYS(magFilter), ALWAYS(minFilter), ALWAYS(mipFilter),
       ALWAYS(usesMips))
FIELDS(Texture, NEVER(name), ALWAYS(image), ALWAYS(sampler), ALWAYS(colorSpace))
FIELDS(ImageData, NEVER(name), ALWAYS(width), ALWAYS(height), ALWAYS(rgba), LABELED(blocks, ""),
       NEVER(lowestAlpha), NEVER(file))
FIELDS(image::BlockLevels, ALWAYS(coding), ALWAYS(levels))
FIELDS(image::ImageF, ALWAYS(width), ALWAYS(height), ALWAYS(rgba))
FIELDS(Node, ALWAYS(name), ALWAYS(parent), ALWAYS(translation), ALWAYS(translationResidual), ALWAYS(rotation),
       ALWAYS(scale), ALWAYS(matrix), ALWAYS(mesh), LABELED(isVisible, "hidden"), FIELD(skin), FIELD(weights))
// objectToWorld follows from objectToNode.
FIELDS(Instance, ALWAYS(mesh), ALWAYS(node), ALWAYS(objectToWorld), ALWAYS(translationResidual),
       NEVER(objectToNode), LABELED(isDeformed, "deformed"), LABELED(isCollapsed, "collapsed"))
FIELDS(Camera, ALWAYS(name), ALWAYS(node), ALWAYS(projection), ALWAYS(yFov), ALWAYS(aspectRatio),
       ALWAYS(xMag), ALWAYS(yMag), ALWAYS(zNear), ALWAYS(zFar), ALWAYS(cameraToWorld),
       ALWAYS(translationResidual))
FIELDS(LightProfile, ALWAYS(name), ALWAYS(type), ALWAYS(vertical), ALWAYS(horizontal), ALWAYS(candela))
FIELDS(EnvironmentLight, NEVER(name), NEVER(faceSize), ALWAYS(map))
FIELDS(SceneData, NEVER(name), ALWAYS(meshes), ALWAYS(materials), ALWAYS(textures), ALWAYS(images),
       ALWAYS(nodes), ALWAYS(nodeOrder), NEVER(otherScenes), ALWAYS(instances), ALWAYS(cameras),
       ALWAYS(lights), LABELED(profiles, ""), LABELED(environment, ""), ALWAYS(bounds), NEVER(warnings),
       NEVER(variants), NEVER(variant), LABELED(skins, ""), LABELED(animations, ""))
FIELDS(Skin, NEVER(name), ALWAYS(joints), ALWAYS(inverseBinds))
FIELDS(AnimationSampler, ALWAYS(interpolation), ALWAYS(width), ALWAYS(times), ALWAYS(values))
FIELDS(AnimationTarget, ALWAYS(property), ALWAYS(field), ALWAYS(object), ALWAYS(element))
FIELDS(AnimationChannel, ALWAYS(sampler), ALWAYS(target))
// An option may choose an animation by its name.
FIELDS(Animation, ALWAYS(name), ALWAYS(samplers), ALWAYS(channels), NEVER(duration), NEVER(defect))

template <>
struct Fields<TextureTransform> {
    static constexpr auto kAll = kTransformFields;
};
template <>
struct Fields<Material> {
    using Owner = Material;
    static constexpr auto kAll =
        std::tuple_cat(std::tuple{ALWAYS(name), FIELD(isShadowCatcher)}, material_fields::kAll);
};
template <>
struct Fields<Light> {
    using Owner = Light;
    static constexpr auto kAll =
        std::tuple_cat(std::tuple{ALWAYS(name), ALWAYS(node), ALWAYS(type), FIELD(profile),
                                  ALWAYS(lightToWorld), ALWAYS(translationResidual)},
                       light_fields::kAll);
};

#undef NEVER
#undef ALWAYS
#undef LABELED
#undef FIELD
#undef FIELDS

}  // namespace raygraph::scene
