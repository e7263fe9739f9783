#include "renderer/scene/gltf/skins.h"

#include <algorithm>
#include <cmath>

#include "base/printable.h"
#include "base/text.h"

namespace raygraph::scene {
namespace {

void ReadSkin(GltfContext& context, const SkinSource& source, const AccessorTables& tables,
              const Place& where, Skin& skin) {
    if (source.joints.empty()) context.Fail(where["joints"], "has no elements, must have at least 1");
    if (source.joints.size() > Skin::kMaxJoints)
        context.Fail(where["joints"],
                     Text("has {} elements, at most {} are read", source.joints.size(), Skin::kMaxJoints));
    skin.name = source.name;
    skin.joints = source.joints;
    if (source.inverseBinds == kNone) return;
    const Accessor& accessor = tables.accessors[source.inverseBinds];
    if (!accessor.isMatrix || accessor.componentCount != 16 || accessor.componentType != ComponentType::Float)
        context.Fail(where["inverseBindMatrices"],
                     Text("accessors[{}] must be MAT4 of float", source.inverseBinds));
    if (accessor.count < skin.joints.size())
        context.Fail(where["inverseBindMatrices"],
                     Text("accessors[{}] has {}, the skin has {}", source.inverseBinds,
                          Counted(accessor.count, "element"), Counted(skin.joints.size(), "joint")));
}

// Returns why the skin of a node cannot be used; an empty text: it can.
std::string OmissionReason(const Node& node, const std::vector<MeshLayout>& layouts, bool isInstanced,
                           uint32_t missingJoint) {
    if (node.mesh == kNone) return "is of a node without a mesh, ignored";
    for (const PrimitiveLayout& primitive : layouts[node.mesh].primitives)
        if (primitive.mode >= PrimitiveMode::Triangles && !primitive.Has(Attribute::Joints0))
            return Text("meshes[{}] has no JOINTS_0 and WEIGHTS_0 in all primitives, the skin is left out",
                        node.mesh);
    if (isInstanced) return "is of a node with EXT_mesh_gpu_instancing, left out";
    if (missingJoint != kNone)
        return Text("its joint nodes[{}] is not in the scene, the skin is left out", missingJoint);
    return "";
}

// Collects the influences on one vertex: those that do nothing are left out, the others sum to 1.
class Influences {
  public:
    struct Influence {
        float weight;
        uint32_t joint;
    };

    void Add(uint32_t joint, float weight) {
        if (weight < 0.0f) ++m_negativeCount;
        if (weight > 0.0f && m_count < m_list.size()) m_list[m_count++] = {weight, joint};
    }

    // `first` is the joint that a vertex follows whose weights are all 0.
    void Normalize(uint32_t first) {
        double sum = 0.0;
        for (size_t i = 0; i < m_count; ++i) sum += double{m_list[i].weight};
        if (m_count == 0) {
            ++m_emptyCount;
            m_list[m_count++] = {1.0f, first};
        } else if (sum != 1.0) {
            // The limit is more than the rounding of four bytes
            if (std::abs(sum - 1.0) > 1e-2) ++m_unevenCount;
            for (size_t i = 0; i < m_count; ++i)
                m_list[i].weight = static_cast<float>(double{m_list[i].weight} / sum);
        }
        std::stable_sort(m_list.begin(), m_list.begin() + static_cast<std::ptrdiff_t>(m_count),
                         [](const Influence& a, const Influence& b) { return a.weight > b.weight; });
    }

    std::span<const Influence> List() const { return {m_list.data(), m_count}; }
    void Clear() { m_count = 0; }

    void Warn(GltfContext& context, const Place& where) const {
        if (m_negativeCount > 0)
            context.Warn(where, "negative weights of joints",
                         Text("{} negative, taken as 0", Counted(m_negativeCount, "value is", "values are")));
        if (m_emptyCount > 0)
            context.Warn(where, "weights of joints of 0",
                         Text("{} no joint, taken as following the first of JOINTS_0",
                              Counted(m_emptyCount, "vertex follows", "vertices follow")));
        if (m_unevenCount > 0)
            context.Warn(where, "weights of joints",
                         Text("{} weights that do not sum to 1, normalized",
                              Counted(m_unevenCount, "vertex has", "vertices have")));
    }

  private:
    std::array<Influence, 4 * kJointSets> m_list{};
    size_t m_count = 0;
    size_t m_negativeCount = 0, m_emptyCount = 0, m_unevenCount = 0;
};

// Holds the sets of a primitive.
struct JointSets {
    size_t count = 0;
    std::array<std::vector<glm::vec4>, kJointSets> joints, weights;
};

}  // namespace

void ReadSkins(GltfContext& context, const GltfDocument& document, const AccessorTables& tables,
               const std::vector<MeshLayout>& layouts, const std::vector<InstancingLayout>& instancing,
               SceneData& scene) {
    scene.skins.resize(document.skins.size());
    for (size_t i = 0; i < document.skins.size(); ++i)
        ReadSkin(context, document.skins[i], tables, Place("skins")[i], scene.skins[i]);
    std::vector<bool> isPlaced(scene.nodes.size(), false);
    for (const uint32_t node : scene.nodeOrder) isPlaced[node] = true;
    std::vector<uint32_t> missingJoint;  // indexed by skin
    for (const Skin& skin : scene.skins) {
        const auto found =
            std::ranges::find_if(skin.joints, [&](uint32_t joint) { return !isPlaced[joint]; });
        missingJoint.push_back(found == skin.joints.end() ? kNone : *found);
    }
    for (size_t i = 0; i < scene.nodes.size(); ++i) {
        Node& node = scene.nodes[i];
        const gltf::Node& file = document.model.nodes[i];
        const Place where = Place("nodes")[i];
        const size_t targetCount = node.mesh == kNone ? 0 : layouts[node.mesh].weights.size();
        node.weights = ReadMorphWeights(context, file.weights, targetCount, where["weights"]);
        if (file.skin < 0) continue;
        const std::string why = OmissionReason(node, layouts, instancing[i].count > 0,
                                               isPlaced[i] ? missingJoint[file.skin] : kNone);
        if (why.empty())
            node.skin = static_cast<uint32_t>(file.skin);
        else
            context.Warn(where["skin"], "skin", why);
    }
}

void DecodeSkins(GltfContext& context, AccessorReader& reader, const std::vector<SkinSource>& sources,
                 SceneData& scene) {
    std::vector<bool> isUsed(sources.size(), false);
    for (const uint32_t node : scene.nodeOrder)
        if (scene.nodes[node].skin != kNone) isUsed[scene.nodes[node].skin] = true;
    for (size_t i = 0; i < sources.size(); ++i) {
        Skin& skin = scene.skins[i];
        const Place where = Place("skins")[i]["inverseBindMatrices"];
        const size_t count = skin.joints.size();
        context.ChargeGeometry(where, count * (sizeof(glm::mat4) + sizeof(glm::mat4x3)));
        skin.inverseBinds.assign(count, glm::mat4x3(1.0f));
        if (sources[i].inverseBinds == kNone || !isUsed[i]) continue;
        std::vector<glm::mat4> matrices(count);
        reader.Read(sources[i].inverseBinds, {count}, 16, &matrices[0][0][0]);
        for (size_t joint = 0; joint < count; ++joint) {
            const glm::mat4& matrix = matrices[joint];
            constexpr float kTolerance = 1e-5f;
            for (int column = 0; column < 4; ++column)
                if (std::abs(matrix[column].w - (column == 3 ? 1.0f : 0.0f)) > kTolerance)
                    context.Fail(where,
                                 Text("element {} is not affine: its last row must be 0 0 0 1", joint));
            skin.inverseBinds[joint] = glm::mat4x3(matrix);
        }
    }
}

std::vector<JointLimit> JointLimits(const SceneData& scene, size_t meshCount) {
    std::vector<JointLimit> limits(meshCount);
    for (const uint32_t index : scene.nodeOrder) {
        const Node& node = scene.nodes[index];
        if (node.mesh == kNone || node.skin == kNone) continue;
        JointLimit& limit = limits[node.mesh];
        const size_t count = scene.skins[node.skin].joints.size();
        if (limit.skin == kNone || count < limit.count) limit = {node.skin, count};
    }
    return limits;
}

JointInfluences DecodeInfluences(GltfContext& context, AccessorReader& reader, const PrimitiveLayout& layout,
                                 const ElementSelection& vertices, const JointLimit& limit,
                                 const std::array<std::vector<std::byte>, kAttributeCount>& packed) {
    const Place attributes = layout.where["attributes"];
    JointSets sets;
    while (sets.count < kJointSets && layout.Has(JointsOf(sets.count))) {
        const auto read = [&](Attribute attribute) {
            return reader.ReadVectors<glm::vec4>(layout.Accessor(attribute), vertices,
                                                 attributes[AttributeName(attribute)], glm::vec4(0.0f),
                                                 packed[static_cast<size_t>(attribute)]);
        };
        sets.joints[sets.count] = read(JointsOf(sets.count));
        sets.weights[sets.count] = read(WeightsOf(sets.count));
        ++sets.count;
    }
    JointInfluences influences;
    if (sets.count == 0) return influences;
    Influences one;
    const auto gather = [&](size_t vertex) {
        one.Clear();
        for (size_t set = 0; set < sets.count; ++set)
            for (int i = 0; i < 4; ++i)
                one.Add(static_cast<uint32_t>(sets.joints[set][vertex][i]), sets.weights[set][vertex][i]);
        one.Normalize(static_cast<uint32_t>(sets.joints[0][vertex].x));
    };
    size_t most = 0;
    std::vector<bool> isUsed;  // made where it is asked
    for (size_t i = 0; i < vertices.count; ++i) {
        gather(i);
        most = std::max(most, one.List().size());
        const auto found = std::ranges::find_if(one.List(), [&](const Influences::Influence& influence) {
            return influence.joint >= limit.count;
        });
        if (found == one.List().end()) continue;
        const std::string what = Text("vertex {} follows joint {}, skins[{}] has {}", vertices[i],
                                      found->joint, limit.skin, Counted(limit.count, "joint"));
        if (isUsed.empty()) isUsed = vertices.UsedElements();
        if (isUsed[i]) context.Fail(attributes, what);
        context.Warn(attributes, "joint of an unused vertex", what + "; it is in no triangle");
        for (size_t set = 0; set < sets.count; ++set) sets.joints[set][i] = glm::vec4(0.0f);
    }
    one.Warn(context, attributes);
    context.ChargeGeometry(attributes, vertices.count * most * (sizeof(uint16_t) + sizeof(float)) +
                                           limit.count * sizeof(Bounds));
    influences.perVertex = static_cast<uint32_t>(most);
    influences.joints.assign(vertices.count * most, 0);
    influences.weights.assign(vertices.count * most, 0.0f);
    for (size_t i = 0; i < vertices.count; ++i) {
        gather(i);
        for (size_t k = 0; k < one.List().size(); ++k) {
            influences.joints[i * most + k] = static_cast<uint16_t>(one.List()[k].joint);
            influences.weights[i * most + k] = one.List()[k].weight;
        }
    }
    return influences;
}

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
