// Every struct that a scene is made of, as the list of its fields: Fields<T>::kAll has the name and the
// member of each. ForEachField does not compile for a struct with a field that its list lacks. The lists of a
// material and a light also say where glTF has a field, and which numbers it may hold. Not installed.
// Threads: constants.
#pragma once

#include <tuple>

#include "renderer/image/image.h"
#include "renderer/scene/model/light_fields.h"
#include "renderer/scene/model/material_fields.h"

namespace raygraph::scene {

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
       NEVER(lowestAlpha))
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
       ALWAYS(nodes), ALWAYS(nodeOrder), ALWAYS(instances), ALWAYS(cameras), ALWAYS(lights),
       LABELED(profiles, ""), LABELED(environment, ""), ALWAYS(bounds), NEVER(warnings), NEVER(variants),
       NEVER(variant), LABELED(skins, ""), LABELED(animations, ""))
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
    static constexpr auto kAll = std::tuple_cat(std::tuple{ALWAYS(name)}, material_fields::kAll);
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
