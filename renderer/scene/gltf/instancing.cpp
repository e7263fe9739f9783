#include "renderer/scene/gltf/instancing.h"

#include <cmath>
#include <limits>

#include "base/counted.h"
#include "base/text.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {
namespace {

constexpr const char* kInstancingExtension = "EXT_mesh_gpu_instancing";

bool IsVectorOfFloats(const Accessor& accessor) {
    return !accessor.isMatrix && accessor.componentCount == 3 &&
           accessor.componentType == ComponentType::Float;
}

bool IsQuaternion(const Accessor& accessor) {
    if (accessor.isMatrix || accessor.componentCount != 4) return false;
    if (accessor.componentType == ComponentType::Float) return true;
    return accessor.isNormalized &&
           (accessor.componentType == ComponentType::Int8 || accessor.componentType == ComponentType::Int16);
}

// Returns the layout of a node's instances, checked.
InstancingLayout ReadLayout(GltfContext& context, const gltf::Value& attributes, const AccessorTables& tables,
                            const Place& where) {
    InstancingLayout layout{.where = where};
    const char* first = nullptr;
    const auto read = [&](const char* name, auto isAllowed, const char* allowed) {
        if (!attributes.Has(name)) return kNone;
        const auto index = static_cast<uint32_t>(attributes.Get(name).GetNumberAsInt());
        const Accessor& accessor = tables.accessors[index];
        if (!isAllowed(accessor)) context.Fail(where[name], Text("accessors[{}] must be {}", index, allowed));
        if (first && accessor.count != layout.count)
            context.Fail(where[name], Text("accessors[{}] has {}, {} has {}", index,
                                           Counted(accessor.count, "element"), first, layout.count));
        if (!first) first = name;
        layout.count = accessor.count;
        return index;
    };
    constexpr const char* kVector = "VEC3 of float";
    layout.translation = read("TRANSLATION", IsVectorOfFloats, kVector);
    layout.rotation = read("ROTATION", IsQuaternion, "VEC4 of float, normalized byte or normalized short");
    layout.scale = read("SCALE", IsVectorOfFloats, kVector);
    return layout;
}

std::vector<glm::quat> ReadRotations(GltfContext& context, AccessorReader& reader,
                                     const InstancingLayout& layout) {
    const Place where = layout.where["ROTATION"];
    const std::vector<glm::vec4> elements =
        reader.ReadVectors<glm::vec4>(layout.rotation, {layout.count}, where);
    context.ChargeGeometry(where, layout.count * sizeof(glm::quat));
    std::vector<glm::quat> rotations;
    rotations.reserve(elements.size());
    for (size_t i = 0; i < elements.size(); ++i) {
        const glm::vec4& xyzw = elements[i];
        const glm::dquat q(double{xyzw.w}, double{xyzw.x}, double{xyzw.y}, double{xyzw.z});
        const double length = glm::length(q);
        if (!(length > 1e-6)) context.Fail(where, Text("element {} is a quaternion of length 0", i));
        constexpr double kRounding = 1e-2;  // of four bytes
        if (std::abs(length - 1.0) > kRounding)
            context.Warn(where, "rotation", "is not of unit length, normalized");
        rotations.emplace_back(q / length);
    }
    return rotations;
}

// A scale of 0 becomes so small a positive one that the matrix tells which side is the front, and nothing
// else.
glm::vec3 AwayFromZero(glm::vec3 scale) {
    for (int i = 0; i < 3; ++i)
        if (scale[i] == 0.0f) scale[i] = std::numeric_limits<float>::min();
    return scale;
}

}  // namespace

std::vector<InstancingLayout> ReadInstancing(GltfContext& context, const gltf::Model& model,
                                             const AccessorTables& tables) {
    std::vector<InstancingLayout> layouts(model.nodes.size());
    for (size_t i = 0; i < model.nodes.size(); ++i) {
        const gltf::Node& node = model.nodes[i];
        const auto found = node.extensions.find(kInstancingExtension);
        if (found == node.extensions.end()) continue;
        const Place where = Place("nodes")[i]["extensions"][kInstancingExtension];
        layouts[i] = ReadLayout(context, found->second.Get("attributes"), tables, where["attributes"]);
        if (node.mesh < 0)
            context.Warn(where, "instancing", "is of a node without a mesh, ignored");
        else if (layouts[i].count == 0)
            context.Warn(where, "instancing",
                         "has no TRANSLATION, ROTATION or SCALE, the mesh is shown once");
    }
    return layouts;
}

std::vector<glm::mat4x3> DecodeInstancing(GltfContext& context, AccessorReader& reader,
                                          const InstancingLayout& layout) {
    const auto vectors = [&](uint32_t accessor, const char* name) {
        if (accessor == kNone) return std::vector<glm::vec3>();
        return reader.ReadVectors<glm::vec3>(accessor, {layout.count}, layout.where[name]);
    };
    const std::vector<glm::vec3> translations = vectors(layout.translation, "TRANSLATION");
    const std::vector<glm::vec3> scales = vectors(layout.scale, "SCALE");
    std::vector<glm::quat> rotations;
    if (layout.rotation != kNone) rotations = ReadRotations(context, reader, layout);
    std::vector<glm::mat4x3> transforms;
    transforms.reserve(layout.count);
    Node parts;
    for (size_t i = 0; i < layout.count; ++i) {
        if (!translations.empty()) parts.translation = translations[i];
        if (!rotations.empty()) parts.rotation = rotations[i];
        if (!scales.empty()) parts.scale = AwayFromZero(scales[i]);
        transforms.push_back(parts.LocalTransform());
    }
    return transforms;
}

}  // namespace raygraph::scene
