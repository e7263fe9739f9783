#include "renderer/scene/animation/animated_values.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "renderer/scene/geometry/transforms.h"
#include "renderer/scene/model/scene_fields.h"

namespace raygraph::scene {
namespace {

// Calls visit(field) for the one of this index.
template <typename List, typename Visit>
void VisitField(const List& fields, size_t index, Visit&& visit) {
    size_t i = 0;
    const auto look = [&](const auto& field) {
        if (i++ == index) visit(field);
    };
    std::apply([&](const auto&... field) { (look(field), ...); }, fields);
}

// Returns how many numbers a value of a field has, of a type that can be animated.
size_t Width(float) {
    return 1;
}
size_t Width(bool) {
    return 1;
}
template <int Length>
size_t Width(const glm::vec<Length, float>&) {
    return Length;
}
template <typename T>
size_t Width(const T&) {
    return 0;
}

void Get(float from, double* to) {
    *to = double{from};
}
void Get(bool from, double* to) {
    *to = from ? 1.0 : 0.0;
}
template <int Length>
void Get(const glm::vec<Length, float>& from, double* to) {
    for (int i = 0; i < Length; ++i) to[i] = double{from[i]};
}
template <typename T>
void Get(const T&, double*) {}

// With which a rotated axis is still finite.
constexpr FieldRange kScales{-1e37f, 1e37f};

float InRange(double number, const FieldRange& range) {
    const float rounded = ToFloat(number);
    return range.mayBeZero && rounded == 0.0f ? rounded : std::clamp(rounded, range.min, range.max);
}

template <typename T>
bool Assign(T& to, const T& value) {
    if (to == value) return false;
    to = value;
    return true;
}

bool Set(float& to, const FieldRange& range, const double* from) {
    return Assign(to, InRange(*from, range));
}
bool Set(bool& to, const double* from) {
    return Assign(to, *from >= 0.5);
}
template <int Length>
bool Set(glm::vec<Length, float>& to, const FieldRange& range, const double* from) {
    glm::vec<Length, float> value;
    for (int i = 0; i < Length; ++i) value[i] = InRange(from[i], range);
    return Assign(to, value);
}
template <typename T>
bool Set(T&, const FieldRange&, const double*) {
    return false;
}

// Sets a field of any list. Only numbers have a range, flags have none.
template <typename Owner, typename FieldType>
bool SetField(Owner& owner, const FieldType& field, const double* value) {
    if constexpr (std::is_same_v<typename FieldType::Value, bool>)
        return Set(owner.*field.member, value);
    else if constexpr (requires { field.range; })
        return Set(owner.*field.member, field.range, value);
    else
        return false;
}

// Returns the limit that ranges of fields cannot express: the largest factor of a color whose product is
// finite.
float MaxFactor(const glm::vec3& color) {
    return std::numeric_limits<float>::max() / std::max({1.0f, color.x, color.y, color.z});
}

bool SetMaterial(Material& material, size_t index, const double* value) {
    bool isChanged = false;
    VisitField(material_fields::kAll, index, [&](const auto& field) {
        const auto placed = SpecularGlossinessField(field);  // whose ranges may be closer
        auto ranged = material.isSpecularGlossiness && placed ? *placed : field;
        if constexpr (std::is_same_v<decltype(field.member), float Material::*>)
            if (field.member == &Material::emissiveStrength)
                ranged.range.max = MaxFactor(material.emissiveFactor);
        isChanged = SetField(material, ranged, value);
    });
    return isChanged;
}

bool SetLight(Light& light, size_t index, const double* value) {
    bool isChanged = false;
    VisitField(light_fields::kAll, index, [&](auto field) {
        if constexpr (std::is_same_v<decltype(field.member), float Light::*>) {
            const bool isSpot = light.type == LightType::Spot;
            if (field.member == &Light::intensity) field.range.max = MaxFactor(light.color);
            if (field.member == &Light::outerConeAngle && isSpot) field.range.min = 1e-6f;
            if (field.member == &Light::innerConeAngle && isSpot)
                field.range.max = std::nextafter(light.outerConeAngle, 0.0f);
        }
        isChanged = SetField(light, field, value);
    });
    return isChanged;
}

bool SetCamera(Camera& camera, size_t index, const double* value) {
    bool isChanged = false;
    VisitField(camera_fields::kAll, index, [&](auto field) {
        if (field.member == &Camera::zNear && camera.zFar > 0.0f)
            field.range.max = std::nextafter(camera.zFar, 0.0f);
        isChanged = SetField(camera, field, value);
    });
    return isChanged;
}

struct Pair {
    AnimatedProperty property;
    size_t leader, follower;  // indices of fields
};

template <typename List, typename Member>
size_t IndexOf(const List& fields, Member member, std::string_view object) {
    size_t index = 0, found = 0;
    const auto look = [&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), Member>)
            if (field.member == member && (object.empty() || object == field.object)) found = index;
        ++index;
    };
    std::apply([&](const auto&... field) { (look(field), ...); }, fields);
    return found;
}

template <typename List, typename Leader, typename Follower>
Pair PairOf(AnimatedProperty property, const List& fields, Leader leader, Follower follower,
            std::string_view object = "") {
    return {property, IndexOf(fields, leader, object), IndexOf(fields, follower, object)};
}

const std::array<Pair, 5>& Pairs() {
    static const std::array<Pair, 5> kPairs{
        PairOf(AnimatedProperty::MaterialField, material_fields::kAll, &Material::emissiveFactor,
               &Material::emissiveStrength),
        PairOf(AnimatedProperty::LightField, light_fields::kAll, &Light::color, &Light::intensity),
        PairOf(AnimatedProperty::LightField, light_fields::kAll, &Light::outerConeAngle,
               &Light::innerConeAngle),
        PairOf(AnimatedProperty::CameraField, camera_fields::kAll, &Camera::zFar, &Camera::zNear,
               camera_fields::kPerspective),
        PairOf(AnimatedProperty::CameraField, camera_fields::kAll, &Camera::zFar, &Camera::zNear,
               camera_fields::kOrthographic)};
    return kPairs;
}

// Calls visit(field, transform) for a field of the transform of a texture; `scene` may be const.
template <typename Materials, typename Visit>
void VisitTransform(Materials& materials, const AnimationTarget& target, Visit&& visit) {
    VisitField(material_fields::kAll, target.field, [&](const auto& texture) {
        if constexpr (std::is_same_v<decltype(texture.member), TextureRef Material::*>)
            VisitField(kTransformFields, target.element, [&](const auto& field) {
                visit(field, (materials[target.object].*texture.member).transform);
            });
    });
}

// Splits the numbers into floats and the rest that rounding to float leaves. Numbers that are too large leave
// no rest.
bool SetTranslation(Node& node, const double* value) {
    glm::dvec3 translation;
    for (int i = 0; i < 3; ++i) {
        const double rounded = double{ToFloat(value[i])};
        translation[i] = std::abs(rounded) < 1e37 ? value[i] : rounded;
    }
    const FloatPair place = ToFloatPair(translation);
    const bool isMoved = Assign(node.translation, place.rounded);
    return Assign(node.translationResidual, place.rest) || isMoved;
}

}  // namespace

std::optional<AnimationTarget> DependentOf(const AnimationTarget& target) {
    for (const Pair& pair : Pairs())
        if (pair.property == target.property && pair.leader == target.field) {
            AnimationTarget follower = target;
            follower.field = static_cast<uint8_t>(pair.follower);
            return follower;
        }
    return std::nullopt;
}

bool IsDependent(const AnimationTarget& target) {
    return std::ranges::any_of(Pairs(), [&](const Pair& pair) {
        return pair.property == target.property && pair.follower == target.field;
    });
}

size_t WidthOf(const SceneData& scene, const AnimationTarget& target) {
    const auto widthIn = [&](const auto& fields, const auto& owners, size_t index) -> size_t {
        size_t width = 0;
        if (target.object < owners.size())
            VisitField(fields, index, [&](const auto& field) {
                // A flag without a key is the presence of an extension
                if (*field.key != 0) width = Width(owners[target.object].*field.member);
            });
        return width;
    };
    const bool isNode = target.object < scene.nodes.size();
    const auto weightsOf = [&](uint32_t mesh) -> size_t {
        const size_t count = mesh < scene.meshes.size() ? scene.meshes[mesh].weights.size() : 0;
        return target.element == kNone ? count : target.element < count ? 1 : 0;
    };
    switch (target.property) {
        case AnimatedProperty::Translation:
        case AnimatedProperty::Scale:
            return isNode ? 3 : 0;
        case AnimatedProperty::Rotation:
            return isNode ? 4 : 0;
        case AnimatedProperty::Visibility:
            return isNode ? 1 : 0;
        case AnimatedProperty::Weights:
            return isNode ? weightsOf(scene.nodes[target.object].mesh) : 0;
        case AnimatedProperty::MeshWeights:
            return weightsOf(target.object);
        case AnimatedProperty::MaterialField:
            return widthIn(material_fields::kAll, scene.materials, target.field);
        case AnimatedProperty::TextureTransform: {
            size_t width = 0;
            if (target.object < scene.materials.size())
                VisitTransform(scene.materials, target, [&](const auto& field, const auto& transform) {
                    width = Width(transform.*field.member);
                });
            return width;
        }
        case AnimatedProperty::CameraField:
            return widthIn(camera_fields::kAll, scene.cameras, target.field);
        case AnimatedProperty::LightField:
            return widthIn(light_fields::kAll, scene.lights, target.field);
    }
    return 0;
}

bool IsInfiniteAtZero(const AnimationTarget& target) {
    bool isInfinite = false;
    const auto look = [&](const auto& fields) {
        VisitField(fields, target.field, [&](const auto& field) {
            if constexpr (requires { field.ZeroIsInfinite(); }) isInfinite = field.ZeroIsInfinite();
        });
    };
    if (target.property == AnimatedProperty::MaterialField) look(material_fields::kAll);
    if (target.property == AnimatedProperty::CameraField) look(camera_fields::kAll);
    if (target.property == AnimatedProperty::LightField) look(light_fields::kAll);
    return isInfinite;
}

void GetValue(const SceneData& scene, const AnimationTarget& target, double* value) {
    const auto getFrom = [&](const auto& fields, const auto& owner) {
        VisitField(fields, target.field, [&](const auto& field) { Get(owner.*field.member, value); });
    };
    const auto getWeights = [&](const std::vector<float>& weights) {
        const bool isWhole = target.element == kNone;
        for (size_t i = 0; i < (isWhole ? weights.size() : 1); ++i)
            value[i] = double{weights[isWhole ? i : target.element]};
    };
    switch (target.property) {
        case AnimatedProperty::Translation: {
            const Node& node = scene.nodes[target.object];
            const glm::dvec3 place = glm::dvec3(node.translation) + glm::dvec3(node.translationResidual);
            for (int i = 0; i < 3; ++i) value[i] = place[i];
            return;
        }
        case AnimatedProperty::Scale:
            return Get(scene.nodes[target.object].scale, value);
        case AnimatedProperty::Rotation: {
            const glm::quat& q = scene.nodes[target.object].rotation;
            return Get(glm::vec4(q.x, q.y, q.z, q.w), value);
        }
        case AnimatedProperty::Visibility:
            return Get(scene.nodes[target.object].isVisible, value);
        case AnimatedProperty::Weights: {
            const Node& node = scene.nodes[target.object];
            const std::vector<float>& weights =
                node.weights.empty() ? scene.meshes[node.mesh].weights : node.weights;
            return getWeights(weights);
        }
        case AnimatedProperty::MeshWeights:
            return getWeights(scene.meshes[target.object].weights);
        case AnimatedProperty::MaterialField:
            return getFrom(material_fields::kAll, scene.materials[target.object]);
        case AnimatedProperty::TextureTransform:
            return VisitTransform(scene.materials, target, [&](const auto& field, const auto& transform) {
                Get(transform.*field.member, value);
            });
        case AnimatedProperty::CameraField:
            return getFrom(camera_fields::kAll, scene.cameras[target.object]);
        case AnimatedProperty::LightField:
            return getFrom(light_fields::kAll, scene.lights[target.object]);
    }
}

bool SetValue(SceneData& scene, const AnimationTarget& target, const double* value) {
    switch (target.property) {
        case AnimatedProperty::Translation:
            return SetTranslation(scene.nodes[target.object], value);
        case AnimatedProperty::Scale:
            return Set(scene.nodes[target.object].scale, kScales, value);
        case AnimatedProperty::Rotation:
            return Assign(
                scene.nodes[target.object].rotation,
                glm::quat(ToFloat(value[3]), ToFloat(value[0]), ToFloat(value[1]), ToFloat(value[2])));
        case AnimatedProperty::Visibility:
            return Set(scene.nodes[target.object].isVisible, value);
        case AnimatedProperty::MeshWeights: {
            bool isChanged = false;
            for (float& weight : scene.meshes[target.object].weights)
                isChanged = Assign(weight, ToFloat(*value++)) || isChanged;
            return isChanged;
        }
        case AnimatedProperty::Weights: {
            Node& node = scene.nodes[target.object];
            const std::vector<float>& ofMesh = scene.meshes[node.mesh].weights;
            bool isChanged = false;
            for (size_t i = 0; i < ofMesh.size(); ++i) {
                const float weight = ToFloat(value[i]);
                if ((node.weights.empty() ? ofMesh : node.weights)[i] == weight) continue;
                if (node.weights.empty()) node.weights = ofMesh;
                isChanged = Assign(node.weights[i], weight) || isChanged;
            }
            return isChanged;
        }
        case AnimatedProperty::MaterialField:
            return SetMaterial(scene.materials[target.object], target.field, value);
        case AnimatedProperty::TextureTransform: {
            bool isChanged = false;
            VisitTransform(scene.materials, target, [&](const auto& field, auto& transform) {
                isChanged = SetField(transform, field, value);
            });
            return isChanged;
        }
        case AnimatedProperty::CameraField:
            return SetCamera(scene.cameras[target.object], target.field, value);
        case AnimatedProperty::LightField:
            return SetLight(scene.lights[target.object], target.field, value);
    }
    return false;
}

}  // namespace raygraph::scene
