#include "renderer/scene/model/ground.h"

#include <algorithm>

namespace raygraph::scene {

SceneData GroundUnder(const Bounds& bounds) {
    SceneData data;
    if (bounds.IsEmpty()) return data;
    data.name = "ground";
    Material& material = data.materials.emplace_back();
    material.name = "ground";
    material.baseColorFactor = glm::vec4(glm::vec3(kGroundReflectance), 1.0f);
    material.metallicFactor = 0.0f;
    material.specularFactor = 0.0f;
    material.isShadowCatcher = true;

    Primitive primitive;
    for (const glm::vec2 corner :
         {glm::vec2(-1.0f, -1.0f), glm::vec2(-1.0f, 1.0f), glm::vec2(1.0f, 1.0f), glm::vec2(1.0f, -1.0f)})
        primitive.positions.emplace_back(corner.x, 0.0f, corner.y);
    primitive.normals.assign(4, glm::vec3(0.0f, 1.0f, 0.0f));
    primitive.indices = {0, 1, 2, 0, 2, 3};
    for (const glm::vec3& position : primitive.positions) primitive.bounds.Extend(position);
    Mesh& mesh = data.meshes.emplace_back();
    mesh.name = "ground";
    mesh.primitives.push_back(std::move(primitive));

    const float radius = std::max(bounds.Radius(), 1e-6f);
    Node& node = data.nodes.emplace_back();
    node.name = "ground";
    node.mesh = 0;
    node.translation = {bounds.Center().x, bounds.min.y - kGroundGap * radius, bounds.Center().z};
    node.scale = glm::vec3(kGroundRadii * radius);
    data.nodeOrder = {0};
    data.instances.push_back({.mesh = 0, .node = 0});
    UpdateWorldTransforms(data);
    return data;
}

}  // namespace raygraph::scene
