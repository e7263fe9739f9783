// MeshFacts holds what the inspector says of a mesh, whose vertices the document does not keep. Threads: pure
// functions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/scene/model/mesh_data.h"

namespace raygraph::editor {

struct MeshFacts {
    uint64_t triangles = 0, roundPrimitives = 0, vertices = 0;
    size_t primitives = 0, materials = 0, morphTargets = 0;
    bool hasJoints = false;
    std::vector<std::string> attributes;  // by glTF's names, each once
    scene::Bounds bounds;                 // object space, at rest
};
MeshFacts FactsOf(const scene::Mesh& mesh);

// Returns the facts as lines: "12 triangles, 24 vertices" and so on.
std::vector<std::string> LinesOf(const MeshFacts& facts);

}  // namespace raygraph::editor
