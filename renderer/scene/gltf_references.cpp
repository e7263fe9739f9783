#include "renderer/scene/gltf_references.h"

#include <array>

namespace raygraph::scene {
namespace {

template <typename Visit>
void ForEach(const JsonValue& array, const Visit& visit) {
    for (size_t i = 0; i < array.Count(); ++i) visit(array.At(i).RequireObject());
}

void CheckIfPresent(const JsonValue& index, size_t count, const char* what) {
    if (index.IsPresent()) index.Index(count, what);
}

void CheckTargets(const JsonValue& primitive, size_t accessorCount) {
    constexpr std::array<const char*, 3> kMorphAttributes{"POSITION", "NORMAL", "TANGENT"};
    ForEach(primitive["targets"], [&](const JsonValue& target) {
        for (const char* attribute : kMorphAttributes)
            CheckIfPresent(target[attribute], accessorCount, "accessors");
    });
}

void CheckAnimation(const JsonValue& animation, size_t nodeCount, size_t accessorCount) {
    const JsonValue samplers = animation["samplers"];
    ForEach(samplers, [&](const JsonValue& sampler) {
        sampler["input"].Index(accessorCount, "accessors");
        sampler["output"].Index(accessorCount, "accessors");
    });
    ForEach(animation["channels"], [&](const JsonValue& channel) {
        channel["sampler"].Index(samplers.Count(), "samplers");
        CheckIfPresent(channel["target"].RequireObject()["node"], nodeCount, "nodes");
    });
}

}  // namespace

void CheckUnreadReferences(const JsonValue& root, const AccessorTables& tables) {
    const size_t nodeCount = root["nodes"].Count();
    const size_t accessorCount = tables.accessors.size();
    const JsonValue skins = root["skins"];
    ForEach(skins, [&](const JsonValue& skin) {
        const JsonValue joints = skin["joints"];
        for (size_t i = 0; i < joints.Count(); ++i) joints.At(i).Index(nodeCount, "nodes");
        CheckIfPresent(skin["skeleton"], nodeCount, "nodes");
        CheckIfPresent(skin["inverseBindMatrices"], accessorCount, "accessors");
    });
    ForEach(root["nodes"],
            [&](const JsonValue& node) { CheckIfPresent(node["skin"], skins.Count(), "skins"); });
    ForEach(root["animations"],
            [&](const JsonValue& animation) { CheckAnimation(animation, nodeCount, accessorCount); });
    ForEach(root["meshes"], [&](const JsonValue& mesh) {
        ForEach(mesh["primitives"],
                [&](const JsonValue& primitive) { CheckTargets(primitive, accessorCount); });
    });
}

}  // namespace raygraph::scene
