// A scene for tests of poses, and animations of it.
#pragma once

#include <cmath>
#include <vector>

#include "renderer/scene/animation/deform.h"
#include "renderer/scene/animation/pose.h"
#include "renderer/scene/geometry/round_primitives.h"
#include "renderer/scene/model/check.h"

namespace raygraph::scene {

// A chain of nodes 0, 1, 2, each 1 m along +x of the one above. Node 2 has a mesh with two morph targets, node 1
// a camera and a light.
inline SceneData Chain() {
    SceneData scene;
    scene.nodes.resize(3);
    for (uint32_t i = 0; i < 3; ++i) {
        scene.nodes[i].parent = i == 0 ? kNone : i - 1;
        scene.nodes[i].translation = {i == 0 ? 0 : 1, 0, 0};
    }
    scene.nodes[2].mesh = 0;
    scene.nodeOrder = {0, 1, 2};
    Primitive triangle;
    triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    triangle.normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    triangle.indices = {0, 1, 2};
    triangle.bounds = BoundsOf(triangle.positions);
    triangle.targets.resize(2);
    triangle.targets[1].positions = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    UpdateDeformationBounds(triangle);
    scene.meshes.push_back({.name = "", .primitives = {triangle}, .weights = {0.5f, 0}});
    scene.materials.resize(1);
    scene.instances.push_back({.mesh = 0, .node = 2});
    scene.cameras.emplace_back().node = 1;
    scene.lights.emplace_back().node = 1;
    scene.lights[0].type = LightType::Spot;
    UpdateWorldTransforms(scene);
    return scene;
}

// An animation of one channel, whose values go from `from` at 0 s to `to` at 1 s.
inline uint32_t Add(SceneData& scene, const AnimationTarget& target, const std::vector<float>& from,
                    const std::vector<float>& to) {
    AnimationSampler sampler{.width = uint32_t(from.size()), .times = {0, 1}, .values = from};
    sampler.values.insert(sampler.values.end(), to.begin(), to.end());
    scene.animations.push_back(
        {.name = "", .samplers = {sampler}, .channels = {{0, target}}, .duration = 1.0f});
    Check(scene);
    return uint32_t(scene.animations.size() - 1);
}
inline AnimationTarget OfNode(AnimatedProperty property, uint32_t node) {
    return {.property = property, .object = node};
}
inline std::vector<float> AboutZ(double radians) {
    return {0, 0, float(std::sin(radians / 2)), float(std::cos(radians / 2))};
}

inline std::vector<double> Values(const Pose& pose) {
    return pose.values;
}

}  // namespace raygraph::scene
