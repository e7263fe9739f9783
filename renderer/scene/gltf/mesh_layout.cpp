#include <algorithm>
#include <map>
#include <string>

#include "base/counted.h"
#include "base/text.h"
#include "renderer/scene/gltf/meshes.h"
#include "renderer/scene/gltf/morphs.h"

namespace raygraph::scene {
namespace {

constexpr const char* kDraco = "KHR_draco_mesh_compression";
constexpr const char* kQuantization = "KHR_mesh_quantization";
constexpr const char* kVariants = "KHR_materials_variants";

bool IsAllowedOfJoints(Attribute attribute, const Accessor& accessor) {
    const bool isUnsigned =
        accessor.componentType == ComponentType::Uint8 || accessor.componentType == ComponentType::Uint16;
    if (accessor.isMatrix || accessor.componentCount != 4) return false;
    if (IsJoints(attribute)) return isUnsigned && !accessor.isNormalized;
    return accessor.componentType == ComponentType::Float || (isUnsigned && accessor.isNormalized);
}

// Returns whether an attribute may be read from the accessor: the core's types and those that
// KHR_mesh_quantization adds.
bool IsAllowed(Attribute attribute, const Accessor& accessor) {
    if (attribute >= Attribute::Joints0) return IsAllowedOfJoints(attribute, accessor);
    if (accessor.isMatrix || accessor.componentType == ComponentType::Uint32) return false;
    const bool isFloat = accessor.componentType == ComponentType::Float;
    const bool isSigned =
        accessor.componentType == ComponentType::Int8 || accessor.componentType == ComponentType::Int16;
    const uint32_t components = accessor.componentCount;
    switch (attribute) {
        case Attribute::Position:
            return components == 3;
        case Attribute::Normal:
            return components == 3 && (isFloat || (isSigned && accessor.isNormalized));
        case Attribute::Tangent:
            return components == 4 && (isFloat || (isSigned && accessor.isNormalized));
        case Attribute::TexCoord0:
        case Attribute::TexCoord1:
            return components == 2;
        case Attribute::Color0:
            return (components == 3 || components == 4) && (isFloat || (!isSigned && accessor.isNormalized));
        default:
            return false;
    }
}

// Returns whether an allowed accessor needs KHR_mesh_quantization.
bool IsQuantized(Attribute attribute, const Accessor& accessor) {
    if (accessor.componentType == ComponentType::Float || attribute >= Attribute::Color0) return false;
    const bool isUnsigned =
        accessor.componentType == ComponentType::Uint8 || accessor.componentType == ComponentType::Uint16;
    const bool isTexCoord = attribute == Attribute::TexCoord0 || attribute == Attribute::TexCoord1;
    return !(isTexCoord && isUnsigned && accessor.isNormalized);
}

const char* AllowedTypes(Attribute attribute) {
    switch (attribute) {
        case Attribute::Position:
            return "VEC3 of float, byte or short";
        case Attribute::Normal:
            return "VEC3 of float, normalized byte or normalized short";
        case Attribute::Tangent:
            return "VEC4 of float, normalized byte or normalized short";
        case Attribute::TexCoord0:
        case Attribute::TexCoord1:
            return "VEC2 of float, byte or short";
        case Attribute::Color0:
            return "VEC3 or VEC4 of float, normalized unsigned byte or normalized unsigned short";
        default:
            return IsJoints(attribute)
                       ? "VEC4 of unsigned byte or unsigned short"
                       : "VEC4 of float, normalized unsigned byte or normalized unsigned short";
    }
}

bool IsIndexAccessor(const Accessor& accessor) {
    const bool isUnsigned = accessor.componentType == ComponentType::Uint8 ||
                            accessor.componentType == ComponentType::Uint16 ||
                            accessor.componentType == ComponentType::Uint32;
    return accessor.componentCount == 1 && isUnsigned && !accessor.isNormalized;
}

class LayoutReader {
  public:
    LayoutReader(GltfContext& context, const gltf::Model& model, const AccessorTables& tables)
        : m_context(context),
          m_tables(tables),
          m_namesQuantization(std::ranges::count(model.extensionsUsed, kQuantization) > 0 ||
                              std::ranges::count(model.extensionsRequired, kQuantization) > 0) {}

    PrimitiveLayout Read(const gltf::Primitive& primitive, const Place& where) const {
        PrimitiveLayout layout{.where = where, .accessors = {}};
        layout.mode = static_cast<PrimitiveMode>(primitive.mode);
        // -1 is none, as in all of tinygltf's indices
        layout.material = static_cast<uint32_t>(primitive.material);
        ReadAttributes(primitive, layout);
        layout.indices = static_cast<uint32_t>(primitive.indices);
        if (layout.indices != kNone && !IsIndexAccessor(m_tables.accessors[layout.indices]))
            m_context.Fail(where["indices"],
                           Text("accessors[{}] must be SCALAR of 5121, 5123 or 5125", layout.indices));
        CheckJointSets(primitive, layout);
        layout.targets = ReadTargets(primitive, layout);
        layout.draco = ReadDraco(primitive, layout);
        layout.variants = ReadVariants(primitive, layout);
        return layout;
    }

  private:
    void ReadAttributes(const gltf::Primitive& primitive, PrimitiveLayout& layout) const {
        layout.accessors.fill(kNone);
        for (size_t i = 0; i < kAttributeCount; ++i) {
            const auto attribute = static_cast<Attribute>(i);
            const auto found = primitive.attributes.find(AttributeName(attribute));
            if (found == primitive.attributes.end()) continue;
            const auto index = static_cast<uint32_t>(found->second);
            const Accessor& accessor = m_tables.accessors[index];
            const auto fail = [&](const std::string& why) {
                m_context.Fail(layout.where["attributes"][AttributeName(attribute)],
                               Text("accessors[{}] {}", index, why));
            };
            if (!IsAllowed(attribute, accessor)) fail(Text("must be {}", AllowedTypes(attribute)));
            if (IsQuantized(attribute, accessor))
                WarnOfQuantization(layout.where["attributes"][AttributeName(attribute)], index);
            layout.accessors[i] = index;
            if (attribute == Attribute::Position) layout.vertexCount = accessor.count;
            if (layout.Has(Attribute::Position) && accessor.count != layout.vertexCount)
                fail(Text("has {}, POSITION has {}", Counted(accessor.count, "element"), layout.vertexCount));
        }
    }

    // Each set of joints has one of weights.
    void CheckJointSets(const gltf::Primitive& primitive, const PrimitiveLayout& layout) const {
        for (size_t set = 0; set < kJointSets; ++set) {
            const bool hasJoints = layout.Has(JointsOf(set)), hasWeights = layout.Has(WeightsOf(set));
            if (hasJoints == hasWeights) continue;
            m_context.Fail(
                layout.where["attributes"],
                Text("has {} without {}", AttributeName(hasJoints ? JointsOf(set) : WeightsOf(set)),
                     AttributeName(hasJoints ? WeightsOf(set) : JointsOf(set))));
        }
        if (primitive.attributes.contains(kUnreadJoints))
            m_context.Warn(layout.where["attributes"][kUnreadJoints], "sets of joints",
                           Text("is not read: the first {} sets are", kJointSets));
    }

    std::vector<MorphLayout> ReadTargets(const gltf::Primitive& primitive,
                                         const PrimitiveLayout& layout) const {
        std::vector<MorphLayout> targets;
        for (size_t t = 0; t < primitive.targets.size(); ++t) {
            const std::map<std::string, int>& file = primitive.targets[t];
            const auto read = [&](Attribute attribute) {
                const char* const name = AttributeName(attribute);
                const auto found = file.find(name);
                if (found == file.end()) return kNone;
                const auto index = static_cast<uint32_t>(found->second);
                const Accessor& accessor = m_tables.accessors[index];
                const Place where = layout.where["targets"][t][name];
                // A displacement of a tangent has no sign
                const Attribute alike = attribute == Attribute::Tangent ? Attribute::Normal : attribute;
                if (!IsAllowed(alike, accessor))
                    m_context.Fail(where, Text("accessors[{}] must be {}", index, AllowedTypes(alike)));
                if (accessor.count != layout.vertexCount)
                    m_context.Fail(where, Text("accessors[{}] has {}, POSITION has {}", index,
                                               Counted(accessor.count, "element"), layout.vertexCount));
                if (IsQuantized(alike, accessor)) WarnOfQuantization(where, index);
                return index;
            };
            targets.push_back({read(Attribute::Position), read(Attribute::Normal), read(Attribute::Tangent)});
            for (const auto& [name, accessor] : file)
                if (name != kAttributeNames[0] && name != kAttributeNames[1] && name != kAttributeNames[2])
                    m_context.Warn(layout.where["targets"][t], "morph target",
                                   "displaces more than POSITION, NORMAL and TANGENT, which is not read");
        }
        return targets;
    }

    void WarnOfQuantization(const Place& where, uint32_t accessor) const {
        if (!m_namesQuantization)
            m_context.Warn(where, "quantization",
                           Text("accessors[{}] takes {}, which the file does not name; read with it",
                                accessor, kQuantization));
    }

    std::optional<DracoLayout> ReadDraco(const gltf::Primitive& primitive,
                                         const PrimitiveLayout& layout) const {
        const auto found = primitive.extensions.find(kDraco);
        if (found == primitive.extensions.end()) return std::nullopt;
        const bool isSolid =
            layout.mode == PrimitiveMode::Triangles || layout.mode == PrimitiveMode::TriangleStrip;
        if (!isSolid)
            m_context.Fail(layout.where["extensions"][kDraco],
                           "is of a primitive that is no list or strip of triangles");
        DracoLayout draco{.view = static_cast<uint32_t>(found->second.Get("bufferView").GetNumberAsInt()),
                          .ids = {}};
        draco.ids.fill(kNone);
        const gltf::Value& attributes = found->second.Get("attributes");
        for (size_t i = 0; i < kAttributeCount; ++i) {
            const char* const name = AttributeName(static_cast<Attribute>(i));
            if (!attributes.Has(name)) continue;
            if (!layout.Has(static_cast<Attribute>(i)))
                m_context.Fail(layout.where["extensions"][kDraco]["attributes"][name],
                               "is of an attribute that the primitive does not have");
            draco.ids[i] = static_cast<uint32_t>(attributes.Get(name).GetNumberAsDouble());
        }
        return draco;
    }

    // Empty if all variants show the primitive's own material.
    std::vector<VariantMaterial> ReadVariants(const gltf::Primitive& primitive,
                                              const PrimitiveLayout& layout) const {
        std::vector<VariantMaterial> variants;
        const auto found = primitive.extensions.find(kVariants);
        if (found == primitive.extensions.end() || !found->second.Has("mappings")) return variants;
        const gltf::Value& mappings = found->second.Get("mappings");
        for (int m = 0; m < static_cast<int>(mappings.ArrayLen()); ++m) {
            const gltf::Value& mapping = mappings.Get(m);
            const auto material = static_cast<uint32_t>(mapping.Get("material").GetNumberAsInt());
            const gltf::Value& indices = mapping.Get("variants");
            for (int i = 0; i < static_cast<int>(indices.ArrayLen()); ++i)
                variants.push_back({static_cast<uint32_t>(indices.Get(i).GetNumberAsInt()), material});
        }
        // The first of each
        std::ranges::stable_sort(variants, {}, &VariantMaterial::variant);
        const auto isRepeated = [&](const VariantMaterial& first, const VariantMaterial& next) {
            if (first.variant != next.variant) return false;
            if (first.material != next.material)
                m_context.Warn(layout.where["extensions"][kVariants], "variant",
                               Text("variant {} has materials {} and {}, the first is shown", first.variant,
                                    first.material, next.material));
            return true;
        };
        variants.erase(std::unique(variants.begin(), variants.end(), isRepeated), variants.end());
        if (!variants.empty()) variants.push_back({kNone, layout.material});
        return variants;
    }

    GltfContext& m_context;
    const AccessorTables& m_tables;
    bool m_namesQuantization;
};

// The points and lines that are left out, for one warning of either.
class LeftOut {
  public:
    explicit LeftOut(const PointsAndLines& shown) : m_shown(shown) {}

    // Returns whether the primitive is one that is not shown.
    bool Takes(const PrimitiveLayout& layout, const AccessorTables& tables) {
        if (layout.mode >= PrimitiveMode::Triangles) return false;
        const bool isPoints = layout.mode == PrimitiveMode::Points;
        if ((isPoints ? m_shown.points : m_shown.lines).IsOn()) return false;
        Some& some = isPoints ? m_points : m_lines;
        const uint64_t indexCount =
            layout.indices == kNone ? layout.vertexCount : tables.accessors[layout.indices].count;
        some.count += SegmentCount(layout.mode, indexCount);
        if (some.primitives++ == 0) some.where = layout.where;
        return true;
    }

    void Warn(GltfContext& context) const {
        const auto warn = [&](const Some& some, const char* what, const char* option, const char* shape) {
            if (some.primitives == 0) return;
            const std::string more = some.primitives > 1 ? Text(" and {} more", some.primitives - 1) : "";
            context.Warn(
                some.where + more, what,
                Text("{} {} left out; a radius ({}) shows them as {}", some.count, what, option, shape));
        };
        warn(m_points, "points are", "--points", "spheres");
        warn(m_lines, "line segments are", "--lines", "capsules");
    }

  private:
    struct Some {
        std::string where;  // of the first
        size_t primitives = 0;
        uint64_t count = 0;
    };
    const PointsAndLines& m_shown;
    Some m_points, m_lines;
};

}  // namespace

std::vector<MeshLayout> ReadMeshLayouts(GltfContext& context, const gltf::Model& model,
                                        const AccessorTables& tables) {
    const LayoutReader reader(context, model, tables);
    LeftOut leftOut(context.options.pointsAndLines);
    std::vector<MeshLayout> meshes;
    for (size_t m = 0; m < model.meshes.size(); ++m) {
        const gltf::Mesh& file = model.meshes[m];
        const Place primitives = Place("meshes")[m]["primitives"];
        if (file.primitives.empty()) context.Fail(primitives, "has no elements, must have at least 1");
        MeshLayout mesh{.name = file.name, .primitives = {}, .weights = {}};
        for (size_t p = 0; p < file.primitives.size(); ++p) {
            const PrimitiveLayout layout = reader.Read(file.primitives[p], primitives[p]);
            if (layout.targets.size() != file.primitives[0].targets.size())
                context.Fail(layout.where["targets"], Text("has {}, that of primitives[0] has {}",
                                                           Counted(layout.targets.size(), "element"),
                                                           file.primitives[0].targets.size()));
            if (leftOut.Takes(layout, tables)) continue;
            if (!layout.Has(Attribute::Position)) {
                context.Warn(layout.where, "position", "has no POSITION, left out");
            } else {
                mesh.primitives.push_back(layout);
            }
        }
        mesh.weights = ReadMorphWeights(context, file.weights, file.primitives[0].targets.size(),
                                        Place("meshes")[m]["weights"]);
        mesh.weights.resize(file.primitives[0].targets.size(), 0.0f);
        meshes.push_back(std::move(mesh));
    }
    leftOut.Warn(context);
    return meshes;
}

}  // namespace raygraph::scene
