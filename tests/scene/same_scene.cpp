#include "tests/scene/same_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <concepts>
#include <string_view>
#include <type_traits>
#include <vector>

#include "renderer/scene/model/scene_fields.h"

namespace raygraph::test {

namespace {

// Returns whether the type can be compared as a whole. Bounds follow from what is compared.
template <typename T>
constexpr bool kIsValue = std::equality_comparable<T>;
template <typename T>
constexpr bool kIsValue<std::vector<T>> = kIsValue<T>;

// Compares all of their fields that are values, except for these.
template <typename T, typename... Members>
void ExpectSameFields(const T& a, const T& b, Members... others) {
    scene::ForEachField<T>([&](const auto& field) {
        if constexpr (kIsValue<typename std::decay_t<decltype(field)>::Value>)
            if (((field.name != std::string_view(others)) && ...)) {
                EXPECT_EQ(a.*field.member, b.*field.member) << field.name;
            }
    });
}

void ExpectSamePrimitive(const scene::Primitive& a, const scene::Primitive& b) {
    ExpectSameFields(a, b);
    ExpectSameFields(a.influences, b.influences);
    ASSERT_EQ(a.targets.size(), b.targets.size());
    for (size_t i = 0; i < a.targets.size(); ++i) ExpectSameFields(a.targets[i], b.targets[i]);
}

void ExpectSameMotion(const scene::SceneData& a, const scene::SceneData& b) {
    ASSERT_EQ(a.skins.size(), b.skins.size());
    for (size_t i = 0; i < a.skins.size(); ++i) ExpectSameFields(a.skins[i], b.skins[i]);
    ASSERT_EQ(a.animations.size(), b.animations.size());
    for (size_t i = 0; i < a.animations.size(); ++i) {
        const scene::Animation &first = a.animations[i], &second = b.animations[i];
        EXPECT_EQ(first.name, second.name);
        EXPECT_EQ(first.duration, second.duration);
        ASSERT_EQ(first.samplers.size(), second.samplers.size());
        for (size_t k = 0; k < first.samplers.size(); ++k)
            ExpectSameFields(first.samplers[k], second.samplers[k]);
        ASSERT_EQ(first.channels.size(), second.channels.size());
        for (size_t k = 0; k < first.channels.size(); ++k)
            ExpectSameFields(first.channels[k], second.channels[k]);
    }
}

}  // namespace

float Apart(const glm::mat4x3& a, const glm::mat4x3& b) {
    float most = 0.0f;
    for (int i = 0; i < 4; ++i) most = std::max(most, glm::length(a[i] - b[i]));
    return most;
}

void ExpectSame(const scene::SceneData& a, const scene::SceneData& b, float tolerance) {
    ExpectSameMotion(a, b);
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.nodeOrder, b.nodeOrder);
    ASSERT_EQ(a.nodes.size(), b.nodes.size());
    for (size_t i = 0; i < a.nodes.size(); ++i) {
        ExpectSameFields(a.nodes[i], b.nodes[i], "translation", "translationResidual", "rotation", "scale",
                         "matrix");
        EXPECT_LE(Apart(a.nodes[i].LocalTransform(), b.nodes[i].LocalTransform()), tolerance) << "node " << i;
    }
    ASSERT_EQ(a.meshes.size(), b.meshes.size());
    for (size_t i = 0; i < a.meshes.size(); ++i) {
        ASSERT_EQ(a.meshes[i].primitives.size(), b.meshes[i].primitives.size());
        EXPECT_EQ(a.meshes[i].weights, b.meshes[i].weights);
        for (size_t k = 0; k < a.meshes[i].primitives.size(); ++k)
            ExpectSamePrimitive(a.meshes[i].primitives[k], b.meshes[i].primitives[k]);
    }
    ASSERT_EQ(a.materials.size(), b.materials.size());
    for (size_t i = 0; i < a.materials.size(); ++i) ExpectSameFields(a.materials[i], b.materials[i]);
    ASSERT_EQ(a.textures.size(), b.textures.size());
    for (size_t i = 0; i < a.textures.size(); ++i) ExpectSameFields(a.textures[i], b.textures[i]);
    ASSERT_EQ(a.images.size(), b.images.size());
    for (size_t i = 0; i < a.images.size(); ++i) ExpectSameFields(a.images[i], b.images[i]);
    ASSERT_EQ(a.instances.size(), b.instances.size());
    for (size_t i = 0; i < a.instances.size(); ++i) {
        EXPECT_EQ(a.instances[i].mesh, b.instances[i].mesh);
        EXPECT_EQ(a.instances[i].node, b.instances[i].node);
        EXPECT_EQ(a.instances[i].objectToNode, b.instances[i].objectToNode);
        // Saved node transforms are rounded to float: positions far from the origin differ by a few of its
        // steps
        const float steps = 4e-7f * glm::length(a.instances[i].objectToWorld[3]);
        EXPECT_LE(Apart(a.instances[i].objectToWorld, b.instances[i].objectToWorld), tolerance + steps);
    }
    ASSERT_EQ(a.cameras.size(), b.cameras.size());
    for (size_t i = 0; i < a.cameras.size(); ++i)
        ExpectSameFields(a.cameras[i], b.cameras[i], "cameraToWorld", "translationResidual");
    ASSERT_EQ(a.lights.size(), b.lights.size());
    for (size_t i = 0; i < a.lights.size(); ++i) {
        EXPECT_EQ(a.lights[i].name, b.lights[i].name);
        EXPECT_EQ(a.lights[i].node, b.lights[i].node);
        ASSERT_EQ(a.lights[i].type, b.lights[i].type);
        scene::ForEachLightField(a.lights[i], [&](const auto& field) {
            EXPECT_EQ(a.lights[i].*field.member, b.lights[i].*field.member) << i << ' ' << field.name;
        });
    }
}

}  // namespace raygraph::test
