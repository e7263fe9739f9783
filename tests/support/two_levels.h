// Scenes whose own trees have two levels, however few triangles they show.
#pragma once

#include <vector>

#include "renderer/bvh/wide_scene.h"
#include "tests/support/scene_render.h"

namespace raygraph::testing {

// Shows for a moment more triangles than a tree of one level is rebuilt for, after which it has two levels
// until another scene is set.
inline void ForceTwoLevelTree(SceneRender& render) {
    const auto declare = [&] {
        render.renderer.BeginFrame();
        std::ignore = render.scene.Declare(render.renderer);
        render.renderer.Execute();
    };
    declare();  // the tree that is built again
    scene::Mesh mesh = SphereMesh(0.01f, 64);
    const uint64_t each = mesh.primitives[0].TriangleCount();
    mesh.primitives[0].material = 0;
    const uint32_t added = render.scene.AddMesh(std::move(mesh));
    std::vector<uint32_t> instances;
    for (uint64_t placed = 0; placed <= kMaxRebuiltTriangles; placed += each)
        instances.push_back(render.scene.AddInstance(added, {glm::mat4x3(1.0f)}));
    declare();
    for (const uint32_t instance : instances) render.scene.RemoveInstance(instance);
    render.scene.RemoveMesh(added);
}

}  // namespace raygraph::testing
