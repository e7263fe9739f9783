#include "renderer/gpu_scene/lights/brightest_pose.h"

#include <algorithm>
#include <cstdint>
#include <type_traits>

#include "renderer/scene/model/scene_fields.h"

namespace raygraph {

namespace {

// Returns the index of a field in its list, by which animations name it.
template <typename Owner, typename T, typename List>
uint8_t IndexOf(T Owner::*member, const List& list) {
    uint8_t index = 0, found = 0;
    const auto look = [&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), T Owner::*>)
            if (field.member == member) found = index;
        ++index;
    };
    std::apply([&](const auto&... fields) { (look(fields), ...); }, list);
    return found;
}

template <typename Visit>
void ForEachKey(const scene::AnimationSampler& sampler, Visit&& visit) {
    const bool hasTangents = sampler.interpolation == scene::Interpolation::CubicSpline;
    const size_t stride = size_t{sampler.width} * (hasTangents ? 3 : 1);
    const size_t first = hasTangents ? sampler.width : 0;
    for (size_t i = first; i + sampler.width <= sampler.values.size(); i += stride) visit(&sampler.values[i]);
}

void Raise(float& value, const scene::AnimationSampler& sampler) {
    ForEachKey(sampler, [&](const float* key) { value = std::max(value, key[0]); });
}

// The value of a key may have more components: that of a base color has alpha.
void Raise(glm::vec3& value, const scene::AnimationSampler& sampler) {
    ForEachKey(sampler,
               [&](const float* key) { value = glm::max(value, glm::vec3(key[0], key[1], key[2])); });
}

}  // namespace

BrightestPose FindBrightestPose(const scene::SceneData& scene) {
    using scene::AnimatedProperty;
    const auto& materialFields = scene::material_fields::kAll;
    const auto& lightFields = scene::light_fields::kAll;
    const uint8_t emissiveFactor = IndexOf(&scene::Material::emissiveFactor, materialFields);
    const uint8_t emissiveStrength = IndexOf(&scene::Material::emissiveStrength, materialFields);
    const uint8_t baseColor = IndexOf(&scene::Material::baseColorFactor, materialFields);
    const uint8_t color = IndexOf(&scene::Light::color, lightFields);
    const uint8_t intensity = IndexOf(&scene::Light::intensity, lightFields);

    std::vector<bool> isShown;  // by node, ignoring its ancestors
    for (const scene::Node& node : scene.nodes) isShown.push_back(node.isVisible);
    struct Values {
        glm::vec3 factor{0.0f}, base{0.0f};
        float strength = 0.0f;
    };
    std::vector<Values> materials;
    for (const scene::Material& material : scene.materials)
        materials.push_back(
            {material.emissiveFactor, glm::vec3(material.baseColorFactor), material.emissiveStrength});
    struct Shining {
        glm::vec3 color{0.0f};
        float intensity = 0.0f;
    };
    std::vector<Shining> lights;
    for (const scene::Light& light : scene.lights) lights.push_back({light.color, light.intensity});

    for (const scene::Animation& animation : scene.animations)
        for (const scene::AnimationChannel& channel : animation.channels) {
            const scene::AnimationTarget& target = channel.target;
            const scene::AnimationSampler& sampler = animation.samplers[channel.sampler];
            if (target.property == AnimatedProperty::Visibility) {
                ForEachKey(sampler, [&](const float* key) {
                    if (key[0] != 0.0f) isShown[target.object] = true;
                });
            } else if (target.property == AnimatedProperty::MaterialField) {
                Values& values = materials[target.object];
                if (target.field == emissiveFactor) Raise(values.factor, sampler);
                if (target.field == emissiveStrength) Raise(values.strength, sampler);
                if (target.field == baseColor) Raise(values.base, sampler);
            } else if (target.property == AnimatedProperty::LightField) {
                Shining& values = lights[target.object];
                if (target.field == color) Raise(values.color, sampler);
                if (target.field == intensity) Raise(values.intensity, sampler);
            }
        }

    BrightestPose pose;
    pose.visibleNodes.assign(scene.nodes.size(), true);
    for (const uint32_t node : scene.nodeOrder)
        pose.visibleNodes[node] =
            isShown[node] && scene::IsVisible(pose.visibleNodes, scene.nodes[node].parent);
    for (size_t i = 0; i < materials.size(); ++i) {
        const bool isUnlit = scene.materials[i].isUnlit;
        pose.emission.push_back(isUnlit ? glm::vec3(0.0f) : materials[i].factor * materials[i].strength);
        pose.unlitColors.push_back(isUnlit ? materials[i].base : glm::vec3(0.0f));
    }
    for (size_t i = 0; i < lights.size(); ++i)
        pose.hasLight |= scene::IsVisible(pose.visibleNodes, scene.lights[i].node) &&
                         lights[i].intensity > 0.0f && lights[i].color != glm::vec3(0.0f);
    return pose;
}

}  // namespace raygraph
