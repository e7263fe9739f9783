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
    EXPECT_EQ(a.uv0, b.uv0);
    EXPECT_EQ(a.uv1, b.uv1);
    EXPECT_EQ(a.colors, b.colors);
    EXPECT_EQ(a.indices, b.indices);
    EXPECT_EQ(a.radii, b.radii);
    EXPECT_EQ(a.material, b.material);
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
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.nodeOrder, b.nodeOrder);
    ASSERT_EQ(a.nodes.size(), b.nodes.size());
    for (size_t i = 0; i < a.nodes.size(); ++i) {
        EXPECT_EQ(a.nodes[i].name, b.nodes[i].name);
        EXPECT_EQ(a.nodes[i].parent, b.nodes[i].parent);
        EXPECT_EQ(a.nodes[i].mesh, b.nodes[i].mesh);
        EXPECT_EQ(a.nodes[i].isVisible, b.nodes[i].isVisible);
        EXPECT_LE(Apart(a.nodes[i].LocalTransform(), b.nodes[i].LocalTransform()), tolerance) << "node " << i;
    }
    ASSERT_EQ(a.meshes.size(), b.meshes.size());
    for (size_t i = 0; i < a.meshes.size(); ++i) {
        ASSERT_EQ(a.meshes[i].primitives.size(), b.meshes[i].primitives.size());
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
