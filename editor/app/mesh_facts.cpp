#include "editor/app/mesh_facts.h"

#include <algorithm>
#include <set>

#include "base/text.h"

namespace raygraph::editor {

MeshFacts FactsOf(const scene::Mesh& mesh) {
    MeshFacts facts{.primitives = mesh.primitives.size(), .morphTargets = mesh.weights.size()};
    std::set<uint32_t> materials;
    for (const scene::Primitive& primitive : mesh.primitives) {
        facts.triangles += primitive.TriangleCount();
        facts.roundPrimitives += primitive.radii.size();
        facts.vertices += primitive.positions.size();
        facts.bounds.Extend(primitive.bounds);
        materials.insert(primitive.material);
        facts.hasJoints |= primitive.influences.perVertex > 0;
        const auto add = [&](const char* name, bool isThere) {
            if (isThere && std::ranges::count(facts.attributes, name) == 0)
                facts.attributes.emplace_back(name);
        };
        add("POSITION", !primitive.positions.empty());
        add("NORMAL", !primitive.normals.empty());
        add("TANGENT", !primitive.tangents.empty());
        add("TEXCOORD_0", !primitive.uv0.empty());
        add("TEXCOORD_1", !primitive.uv1.empty());
        add("COLOR_0", !primitive.colors.empty());
        add("JOINTS, WEIGHTS", primitive.influences.perVertex > 0);
    }
    facts.materials = materials.size();
    return facts;
}

std::vector<std::string> LinesOf(const MeshFacts& facts) {
    std::vector<std::string> lines;
    lines.push_back(Text("{}, {}", Counted(facts.triangles, "triangle"),
                         facts.vertices == 1 ? "1 vertex" : Text("{} vertices", facts.vertices)));
    if (facts.roundPrimitives > 0) lines.push_back(Counted(facts.roundPrimitives, "sphere or capsule"));
    lines.push_back(
        Text("{}, {}", Counted(facts.primitives, "primitive"), Counted(facts.materials, "material")));
    std::string attributes;
    for (const std::string& name : facts.attributes) attributes += (attributes.empty() ? "" : ", ") + name;
    if (!attributes.empty()) lines.push_back(std::move(attributes));
    if (!facts.bounds.IsEmpty()) {
        const glm::vec3 size = facts.bounds.max - facts.bounds.min;
        lines.push_back(Text("{:.4g} x {:.4g} x {:.4g} m", size.x, size.y, size.z));
    }
    if (facts.morphTargets > 0) lines.push_back(Counted(facts.morphTargets, "morph target"));
    if (facts.hasJoints) lines.emplace_back("skinned");
    return lines;
}

}  // namespace raygraph::editor
