#include "tests/scene/same_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>
#include <type_traits>

#include "renderer/scene/light_fields.h"
#include "renderer/scene/material_fields.h"

namespace raygraph::test {

namespace {

void ExpectSamePrimitive(const scene::Primitive& a, const scene::Primitive& b) {
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.normals, b.normals);
    EXPECT_EQ(a.tangents, b.tangents);
    EXPECT_EQ(a.tangentTexCoord, b.tangentTexCoord);
    EXPECT_EQ(a.frameTurns, b.frameTurns);
    EXPECT_EQ(a.uv0, b.uv0);
    EXPECT_EQ(a.uv1, b.uv1);
    EXPECT_EQ(a.colors, b.colors);
    EXPECT_EQ(a.indices, b.indices);
    EXPECT_EQ(a.radii, b.radii);
    EXPECT_EQ(a.material, b.material);
    EXPECT_EQ(a.hasFlatNormals, b.hasFlatNormals);
    EXPECT_EQ(a.influences.perVertex, b.influences.perVertex);
    EXPECT_EQ(a.influences.joints, b.influences.joints);
    EXPECT_EQ(a.influences.weights, b.influences.weights);
    ASSERT_EQ(a.targets.size(), b.targets.size());
    for (size_t i = 0; i < a.targets.size(); ++i) {
        EXPECT_EQ(a.targets[i].positions, b.targets[i].positions);
        EXPECT_EQ(a.targets[i].normals, b.targets[i].normals);
        EXPECT_EQ(a.targets[i].tangents, b.targets[i].tangents);
    }
}

void ExpectSameMotion(const scene::SceneData& a, const scene::SceneData& b) {
    ASSERT_EQ(a.skins.size(), b.skins.size());
    for (size_t i = 0; i < a.skins.size(); ++i) {
        EXPECT_EQ(a.skins[i].name, b.skins[i].name);
        EXPECT_EQ(a.skins[i].joints, b.skins[i].joints);
        EXPECT_EQ(a.skins[i].inverseBinds, b.skins[i].inverseBinds);
    }
    ASSERT_EQ(a.animations.size(), b.animations.size());
    for (size_t i = 0; i < a.animations.size(); ++i) {
        const scene::Animation &first = a.animations[i], &second = b.animations[i];
        EXPECT_EQ(first.name, second.name);
        EXPECT_EQ(first.duration, second.duration);
        ASSERT_EQ(first.samplers.size(), second.samplers.size());
        for (size_t k = 0; k < first.samplers.size(); ++k) {
            EXPECT_EQ(first.samplers[k].interpolation, second.samplers[k].interpolation);
            EXPECT_EQ(first.samplers[k].times, second.samplers[k].times);
            EXPECT_EQ(first.samplers[k].values, second.samplers[k].values);
        }
        ASSERT_EQ(first.channels.size(), second.channels.size());
        for (size_t k = 0; k < first.channels.size(); ++k) {
            EXPECT_EQ(first.channels[k].sampler, second.channels[k].sampler);
            EXPECT_TRUE((first.channels[k].target <=> second.channels[k].target) == 0);
        }
    }
}

void ExpectSameMaterial(const scene::Material& a, const scene::Material& b) {
    EXPECT_EQ(a.name, b.name);
    scene::ForEachMaterialField([&](const auto& field) {
        if constexpr (std::is_same_v<decltype(field.member), scene::TextureRef scene::Material::*>) {
            EXPECT_TRUE(a.*field.member == b.*field.member) << a.name << ' ' << field.name;
        } else {
            EXPECT_EQ(a.*field.member, b.*field.member) << a.name << ' ' << field.name;
        }
    });
}

// All but the transform, which is the node's.
void ExpectSameCamera(const scene::Camera& a, const scene::Camera& b) {
    const auto& [name, node, projection, yFov, aspectRatio, xMag, yMag, zNear, zFar, matrix, rest] = a;
    std::ignore = std::tie(matrix, rest);
    EXPECT_EQ(name, b.name);
    EXPECT_EQ(node, b.node);
    EXPECT_EQ(projection, b.projection);
    EXPECT_EQ(yFov, b.yFov);
    EXPECT_EQ(aspectRatio, b.aspectRatio);
    EXPECT_EQ(xMag, b.xMag);
    EXPECT_EQ(yMag, b.yMag);
    EXPECT_EQ(zNear, b.zNear);
    EXPECT_EQ(zFar, b.zFar);
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
        EXPECT_EQ(a.nodes[i].name, b.nodes[i].name);
        EXPECT_EQ(a.nodes[i].parent, b.nodes[i].parent);
        EXPECT_EQ(a.nodes[i].mesh, b.nodes[i].mesh);
        EXPECT_EQ(a.nodes[i].isVisible, b.nodes[i].isVisible);
        EXPECT_EQ(a.nodes[i].skin, b.nodes[i].skin);
        EXPECT_EQ(a.nodes[i].weights, b.nodes[i].weights);
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
    for (size_t i = 0; i < a.materials.size(); ++i) ExpectSameMaterial(a.materials[i], b.materials[i]);
    ASSERT_EQ(a.textures.size(), b.textures.size());
    for (size_t i = 0; i < a.textures.size(); ++i) {
        EXPECT_EQ(a.textures[i].image, b.textures[i].image);
        EXPECT_EQ(a.textures[i].sampler, b.textures[i].sampler);
    }
    ASSERT_EQ(a.images.size(), b.images.size());
    for (size_t i = 0; i < a.images.size(); ++i) EXPECT_EQ(a.images[i].rgba, b.images[i].rgba);
    ASSERT_EQ(a.instances.size(), b.instances.size());
    for (size_t i = 0; i < a.instances.size(); ++i) {
        EXPECT_EQ(a.instances[i].mesh, b.instances[i].mesh);
        EXPECT_EQ(a.instances[i].node, b.instances[i].node);
        EXPECT_EQ(a.instances[i].objectToNode, b.instances[i].objectToNode);
        // What is saved of a node is rounded to float: a few steps of it where places are large
        const float steps = 4e-7f * glm::length(a.instances[i].objectToWorld[3]);
        EXPECT_LE(Apart(a.instances[i].objectToWorld, b.instances[i].objectToWorld), tolerance + steps);
    }
    ASSERT_EQ(a.cameras.size(), b.cameras.size());
    for (size_t i = 0; i < a.cameras.size(); ++i) ExpectSameCamera(a.cameras[i], b.cameras[i]);
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
