#include "renderer/scene/gltf/morphs.h"

#include <algorithm>

#include "base/counted.h"
#include "base/text.h"

namespace raygraph::scene {

std::vector<float> ReadMorphWeights(GltfContext& context, const std::vector<double>& file, size_t targetCount,
                                    const Place& where) {
    if (!file.empty() && targetCount == 0)
        context.Warn(where, "weights", "are of a mesh without morph targets, ignored");
    else if (!file.empty() && file.size() != targetCount)
        context.Fail(where, Text("has {}, the mesh has {}", Counted(file.size(), "element"),
                                 Counted(targetCount, "morph target")));
    std::vector<float> weights;
    if (targetCount > 0)
        for (const double weight : file) weights.push_back(static_cast<float>(weight));
    return weights;
}

std::vector<MorphTarget> DecodeTargets(GltfContext& context, AccessorReader& reader,
                                       const PrimitiveLayout& layout, const ElementSelection& vertices,
                                       const ElementSelection& tangents) {
    context.ChargeGeometry(layout.where["targets"], layout.targets.size() * sizeof(MorphTarget));
    std::vector<MorphTarget> targets(layout.targets.size());
    for (size_t i = 0; i < targets.size(); ++i) {
        const Place where = layout.where["targets"][i];
        const auto read = [&](uint32_t accessor, Attribute attribute, std::vector<glm::vec3>& stream) {
            if (accessor == kNone || !layout.Has(attribute)) return;
            const ElementSelection& selection = attribute == Attribute::Tangent ? tangents : vertices;
            stream = reader.ReadVectors<glm::vec3>(accessor, selection, where[AttributeName(attribute)]);
            const auto isZero = [](const glm::vec3& displacement) { return displacement == glm::vec3(0.0f); };
            if (std::ranges::all_of(stream, isZero)) stream = {};
        };
        read(layout.targets[i].positions, Attribute::Position, targets[i].positions);
        read(layout.targets[i].normals, Attribute::Normal, targets[i].normals);
        // Tangents of a primitive without normals are not read, either.
        if (layout.Has(Attribute::Normal))
            read(layout.targets[i].tangents, Attribute::Tangent, targets[i].tangents);
    }
    return targets;
}

}  // namespace raygraph::scene
