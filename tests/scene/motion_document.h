// Small documents with skins, morph targets and animations, for tests.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "tests/scene/gltf_document.h"

namespace raygraph::test {

// An accessor of 4 x 4 matrices, column by column.
size_t AddMatrices(GltfDocument& document, const std::vector<float>& values);

// An animation with one channel for `target`, e.g. {{"node", 0}, {"path", "scale"}}. Returns its index.
size_t AddAnimation(GltfDocument& document, size_t input, size_t output, const Json& target,
                    const char* interpolation = "LINEAR");
// The target of KHR_animation_pointer.
Json Pointer(const std::string& pointer);
// AddAnimation with accessors of these values, `components` numbers an element.
size_t Animate(GltfDocument& document, const Json& target, const std::vector<float>& times,
               const std::vector<float>& values, size_t components, const char* interpolation = "LINEAR");

// A triangle (0,0,0) (1,0,0) (0,1,0) with normals +z at node 0, whose vertices follow the joints node 1, node 2
// and half of each. Inverse bind matrices: node 1 none, node 2 moves by (-1, 0, 0). Both joints are roots, node 1
// at the origin, node 2 at (1, 0, 0): in the rest pose the mesh is as it was bound.
GltfDocument SkinnedTriangle();

}  // namespace raygraph::test
