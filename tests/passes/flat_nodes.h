// Scenes whose nodes scale a mesh to a plane.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <utility>
#include <vector>

#include "tests/support/scene_render.h"

namespace raygraph::testing {

inline scene::Node Scaled(const glm::vec3& scale, const glm::quat& rotation = glm::quat(1, 0, 0, 0)) {
    scene::Node node;
    node.scale = scale;
    node.rotation = rotation;
    return node;
}

// The mesh is that of the last node, each of which is below the one before it. They leave a plane.
struct Chain {
    const char* name;
    std::vector<scene::Node> nodes;
    glm::vec3 normal;
};
inline std::vector<Chain> Chains() {
    const glm::quat turn = glm::angleAxis(0.9f, glm::normalize(glm::vec3(1, 2, 3)));
    const glm::quat other = glm::angleAxis(0.5f, glm::normalize(glm::vec3(2, -1, 1)));
    const glm::vec3 turned = turn * glm::vec3(0, 0, 1);
    scene::Node singular;  // no axis of it is 0
    singular.matrix =
        glm::mat4x3(glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0.5f, 0.5f, 0), glm::vec3(0));
    return {{"a scale of 0", {Scaled({1, 1, 0})}, {0, 0, 1}},
            {"along x", {Scaled({0, 1, 1})}, {1, 0, 0}},
            {"along y", {Scaled({1, 0, 1})}, {0, 1, 0}},
            {"mirrored", {Scaled({-1, 1, 0})}, {0, 0, 1}},
            {"by a parent", {Scaled({1, 1, 0}), Scaled(glm::vec3(1), other)}, {0, 0, 1}},
            {"between turns",
             {Scaled(glm::vec3(1), turn), Scaled({1.5f, 1, 0}), Scaled({1, 0.7f, 1}, other)},
             turned},
            {"almost 0, between turns",
             {Scaled(glm::vec3(1), turn), Scaled({1, 1, 1e-12f}), Scaled(glm::vec3(1), other)},
             turned},
            {"almost 0, by a parent", {Scaled({1, 1, 1e-4f}), Scaled(glm::vec3(1), turn)}, {0, 0, 1}},
            {"a matrix", {singular}, {0, 0, 1}}};
}

inline scene::SceneData Under(std::vector<scene::Node> chain, scene::Mesh mesh,
                              const scene::Material& material, const glm::vec3& at = glm::vec3(0.0f)) {
    scene::SceneData scene = SceneOf({std::move(mesh)}, {material});
    scene.nodes = std::move(chain);
    for (uint32_t i = 0; i < scene.nodes.size(); ++i) {
        if (i > 0) scene.nodes[i].parent = i - 1;
        scene.nodeOrder.push_back(i);
    }
    scene.nodes[0].translation = at;
    scene.nodes.back().mesh = 0;
    scene.instances[0].node = static_cast<uint32_t>(scene.nodes.size() - 1);
    scene.instances[0].isCollapsed = true;  // unless it is seen, as a file that scales it may say
    scene::UpdateWorldTransforms(scene);
    return scene;
}

}  // namespace raygraph::testing
