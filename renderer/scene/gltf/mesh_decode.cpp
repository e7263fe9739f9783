#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <string>

#include "base/printable.h"
#include "base/text.h"
#include "renderer/scene/animation/deform.h"
#include "renderer/scene/geometry/tangents.h"
#include "renderer/scene/gltf/draco.h"
#include "renderer/scene/gltf/meshes.h"
#include "renderer/scene/gltf/nodes.h"
#include "renderer/scene/gltf/skins.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/scene_fields.h"

namespace raygraph::scene {
namespace {

// Holds the vertex attributes that the materials of a primitive read.
struct VertexUse {
    std::array<bool, 2> texCoords{};
    bool tangents = false;
};

void AddUse(const Material& material, const PrimitiveLayout& layout, VertexUse& use) {
    ForEachShownTexture(material, [&](const TextureRef& texture) {
        use.texCoords[static_cast<size_t>(texture.texCoord)] = true;
    });
    const std::vector<TextureRef> maps = material.DirectionalTextures();
    if (maps.empty()) return;
    use.tangents = true;
    if (layout.Has(Attribute::Tangent) && layout.Has(Attribute::Normal)) return;
    // Tangents are made along these coordinates.
    for (const TextureRef& map : maps) use.texCoords[static_cast<size_t>(map.texCoord)] = true;
}

// Returns the elements, none of them marked as used unless they are read: then no picture depends on them.
ElementSelection SelectIf(bool isRead, ElementSelection elements) {
    static const std::vector<uint32_t> none;
    if (!isRead) elements.used = &none;
    return elements;
}

class PrimitiveDecoder {
  public:
    // `maps` are what tangents are for.
    PrimitiveDecoder(GltfContext& context, AccessorReader& reader, const PrimitiveLayout& layout,
                     std::vector<TextureRef> maps, const VertexUse& use, const JointLimit& joints)
        : m_context(context),
          m_reader(reader),
          m_layout(layout),
          m_maps(std::move(maps)),
          m_use(use),
          m_joints(joints) {}

    Primitive Decode() {
        if (m_layout.mode < PrimitiveMode::Triangles) return DecodeRound();
        Primitive primitive;
        if (m_layout.draco)
            m_decoded =
                DecodeDraco(m_context, m_layout, m_reader.Tables(), m_reader.View(m_layout.draco->view));
        primitive.indices = m_layout.draco ? DecodedTriangles() : Triangles();
        const bool makesNormals = !m_layout.Has(Attribute::Normal);
        // The vertices to read. With flat normals no two triangles share one. An index list that names less
        // than half of its vertices (many primitives over one big buffer) gets only those it names: reading
        // stays linear.
        std::vector<uint32_t> chosen;
        if (makesNormals) {
            chosen = primitive.indices;
            m_context.ChargeGeometry(m_layout.where, chosen.size() * sizeof(uint32_t));
            std::iota(primitive.indices.begin(), primitive.indices.end(), 0u);
        } else if (primitive.indices.size() < m_layout.vertexCount / 2) {
            chosen = CompactVertices(primitive.indices);
        }
        const bool readsAll = !makesNormals && chosen.empty();
        const ElementSelection vertices =
            readsAll ? ElementSelection{.count = m_layout.vertexCount, .used = &primitive.indices}
                     : ElementSelection{chosen.size(), chosen.data()};

        ReadStreams(primitive, vertices);
        primitive.hasFlatNormals = makesNormals;
        if (m_joints.skin != kNone)
            primitive.influences =
                DecodeInfluences(m_context, m_reader, m_layout, vertices, m_joints, m_decoded.attributes);
        primitive.targets =
            DecodeTargets(m_context, m_reader, m_layout, vertices, SelectIf(m_use.tangents, vertices));
        if (makesNormals) {
            m_context.ChargeGeometry(m_layout.where, primitive.positions.size() * sizeof(glm::vec3));
            primitive.normals = FlatNormals(primitive.positions);
        } else {
            primitive.normals = Stream<glm::vec3>(Attribute::Normal, vertices);
            const size_t lost = NormalizeNormals(primitive.normals, primitive.positions, primitive.indices);
            if (lost > 0) WarnLost("NORMAL", lost, "taken from the triangles around them");
            primitive.tangents = Stream<glm::vec4>(Attribute::Tangent, SelectIf(m_use.tangents, vertices),
                                                   glm::vec4(1.0f, 0.0f, 0.0f, 1.0f));
            const size_t lostTangents = NormalizeTangents(primitive.tangents, primitive.normals);
            if (lostTangents > 0) WarnLost("TANGENT", lostTangents, "made perpendicular to the normal");
        }
        if (primitive.tangents.empty()) MakeTangents(primitive);
        primitive.bounds = BoundsOf(primitive.positions);
        UpdateDeformationBounds(primitive);
        return primitive;
    }

  private:
    std::vector<uint32_t> DecodedTriangles() {
        m_context.ChargeGeometry(m_layout.where, m_decoded.indices.size() * sizeof(uint32_t));
        return std::move(m_decoded.indices);
    }

    // Points and lines. Normals of the file are not read: the surface has its own.
    Primitive DecodeRound() {
        Primitive primitive;
        std::vector<uint32_t> indices = Indices();
        const size_t count = SegmentCount(m_layout.mode, indices.size());
        if (m_layout.mode == PrimitiveMode::Lines && indices.size() % 2 != 0)
            m_context.Warn(m_layout.where, "leftover point",
                           Text("{} no whole number of segments, the last is left out",
                                Counted(indices.size(), "vertex makes", "vertices make")));
        m_context.ChargeGeometry(m_layout.where, count * (2 * sizeof(uint32_t) + sizeof(float)));
        primitive.indices = SegmentList(m_layout.mode, indices);
        std::vector<uint32_t> chosen;
        if (indices.size() < m_layout.vertexCount / 2) chosen = CompactVertices(primitive.indices);
        const ElementSelection vertices =
            chosen.empty() ? ElementSelection{.count = m_layout.vertexCount, .used = &primitive.indices}
                           : ElementSelection{chosen.size(), chosen.data()};
        ReadStreams(primitive, vertices);
        if (!m_layout.targets.empty() || m_layout.Has(Attribute::Joints0))
            m_context.Warn(m_layout.where, "round deformation",
                           "points and lines with joints or morph targets keep their base shape");
        const PointsAndLines& requested = m_context.options.pointsAndLines;
        const bool isPoints = m_layout.mode == PrimitiveMode::Points;
        primitive.radii.assign(count, RequestedRadius(isPoints ? requested.points : requested.lines));
        primitive.bounds = BoundsOf(primitive.positions);
        return primitive;
    }

    // Reads the streams that round primitives and triangles have in common.
    void ReadStreams(Primitive& primitive, const ElementSelection& vertices) {
        primitive.positions = Stream<glm::vec3>(Attribute::Position, vertices);
        primitive.uv0 = Stream<glm::vec2>(Attribute::TexCoord0, SelectIf(m_use.texCoords[0], vertices));
        primitive.uv1 = Stream<glm::vec2>(Attribute::TexCoord1, SelectIf(m_use.texCoords[1], vertices));
        primitive.colors = Stream<glm::vec4>(Attribute::Color0, vertices, glm::vec4(1.0f));
        ClampColors(primitive.colors);
    }

    // Returns the primitive's indices into the file's vertices, all checked.
    std::vector<uint32_t> Indices() {
        std::vector<uint32_t> indices;
        if (m_layout.indices == kNone) {
            m_context.ChargeGeometry(m_layout.where, m_layout.vertexCount * sizeof(uint32_t));
            indices.resize(m_layout.vertexCount);
            std::iota(indices.begin(), indices.end(), 0u);
        } else {
            const Place where = m_layout.where["indices"];
            indices = m_reader.ReadIndices(m_layout.indices, where);
            for (size_t i = 0; i < indices.size(); ++i)
                if (indices[i] >= m_layout.vertexCount)
                    m_context.Fail(
                        where, Text("accessors[{}] element {} is {}, but POSITION has {}", m_layout.indices,
                                    i, indices[i], Counted(m_layout.vertexCount, "element")));
        }
        return indices;
    }

    // Returns the primitive's triangles.
    std::vector<uint32_t> Triangles() {
        std::vector<uint32_t> indices = Indices();
        const size_t count = indices.size();
        const bool isList = m_layout.mode == PrimitiveMode::Triangles;
        if (count < 3 || (isList && count % 3 != 0))
            m_context.Warn(m_layout.where, "leftover",
                           Text("{} no whole number of triangles, the rest is left out",
                                Counted(count, "vertex makes", "vertices make")));
        if (!isList) m_context.ChargeGeometry(m_layout.where, count * 3 * sizeof(uint32_t));
        return TriangleList(m_layout.mode, std::move(indices));
    }

    // Returns the distinct vertices of `indices` in ascending order; `indices` become positions in it.
    std::vector<uint32_t> CompactVertices(std::vector<uint32_t>& indices) {
        m_context.ChargeGeometry(m_layout.where, indices.size() * sizeof(uint32_t));
        std::vector<uint32_t> used = indices;
        std::sort(used.begin(), used.end());
        used.erase(std::unique(used.begin(), used.end()), used.end());
        for (uint32_t& index : indices)
            index = static_cast<uint32_t>(std::lower_bound(used.begin(), used.end(), index) - used.begin());
        return used;
    }

    template <typename Vector>
    std::vector<Vector> Stream(Attribute attribute, const ElementSelection& vertices,
                               Vector fill = Vector(0.0f)) {
        if (!m_layout.Has(attribute)) return {};
        const Place where = m_layout.where["attributes"][AttributeName(attribute)];
        return m_reader.ReadVectors<Vector>(m_layout.Accessor(attribute), vertices, where, fill,
                                            m_decoded.attributes[static_cast<size_t>(attribute)]);
    }

    // Makes tangents along the texture coordinates of the first map that the primitive has coordinates for;
    // without one there are none. If other maps are read by the other set, finds how its tangents are turned
    // against them.
    void MakeTangents(Primitive& primitive) {
        const auto hasCoordinates = [&primitive](const TextureRef& map) {
            return !(map.texCoord == 1 ? primitive.uv1 : primitive.uv0).empty();
        };
        const auto first = std::ranges::find_if(m_maps, hasCoordinates);
        if (first == m_maps.end() || primitive.indices.empty()) return;
        primitive.tangentTexCoord = first->texCoord == 1 ? 1 : 0;
        primitive.tangents = TangentsAlong(primitive, primitive.tangentTexCoord);
        const bool hasOthers = std::ranges::any_of(m_maps, [&](const TextureRef& map) {
            return map.texCoord != first->texCoord && hasCoordinates(map);
        });
        if (!primitive.targets.empty()) {
            constexpr uint64_t kBytesPerVertex = 160;  // the moved shape, and working tables
            m_context.ChargeGeometry(m_layout.where, primitive.positions.size() * kBytesPerVertex);
            for (MorphTarget& target : primitive.targets) MoveTangentsBy(target, primitive);
            return;  // Targets change the angles between the sets: other maps have the frame of the triangle.
        }
        if (!hasOthers) return;
        const std::vector<glm::vec4> others = TangentsAlong(primitive, 1 - primitive.tangentTexCoord);
        primitive.frameTurns.reserve(others.size());
        for (size_t i = 0; i < others.size(); ++i) {
            const glm::vec3 from(primitive.tangents[i]), to(others[i]);
            primitive.frameTurns.emplace_back(glm::dot(from, to),
                                              glm::dot(primitive.normals[i], glm::cross(from, to)));
        }
    }

    // Targets turn the image with the surface, and tangents that were made along it with the image.
    void MoveTangentsBy(MorphTarget& target, const Primitive& primitive) {
        if (target.positions.empty() && target.normals.empty()) return;
        m_context.ChargeGeometry(m_layout.where, primitive.positions.size() * sizeof(glm::vec3));
        std::vector<glm::vec3> positions = primitive.positions, normals = primitive.normals;
        for (size_t i = 0; i < target.positions.size(); ++i) positions[i] += target.positions[i];
        if (primitive.hasFlatNormals) {
            normals = FlatNormals(positions);
        } else if (!target.normals.empty()) {
            for (size_t i = 0; i < normals.size(); ++i) {
                const glm::vec3 moved = normals[i] + target.normals[i];
                const float length = glm::length(moved);
                if (length > 1e-6f && std::isfinite(length)) normals[i] = moved / length;
            }
        }
        const auto isFinite = [](const glm::vec3& position) { return IsFinite(position); };
        if (!std::ranges::all_of(positions, isFinite)) return;  // Such a pose is not shown.
        target.tangents =
            MoveTangents({primitive.positions, primitive.normals}, {positions, normals}, primitive.tangents,
                         primitive.tangentTexCoord == 1 ? primitive.uv1 : primitive.uv0, primitive.indices);
        const auto isZero = [](const glm::vec3& move) { return move == glm::vec3(0.0f); };
        if (std::ranges::all_of(target.tangents, isZero)) target.tangents = {};
    }

    // Splits the vertices where several tangents along a set of texture coordinates meet.
    std::vector<glm::vec4> TangentsAlong(Primitive& primitive, uint32_t texCoord) {
        // The memory of the working tables, for at most as many vertices as there are indices.
        constexpr uint64_t kBytesPerIndex = 64, kBytesPerVertex = 64;
        m_context.ChargeGeometry(m_layout.where, primitive.indices.size() * kBytesPerIndex +
                                                     primitive.positions.size() * kBytesPerVertex);
        const uint64_t deformationBytes =
            primitive.influences.perVertex * (sizeof(uint16_t) + sizeof(float)) +
            primitive.targets.size() * 2 * sizeof(glm::vec3);
        m_context.ChargeGeometry(m_layout.where, primitive.indices.size() * deformationBytes);
        TangentMesh mesh = GenerateTangents(primitive.positions, primitive.normals,
                                            texCoord == 1 ? primitive.uv1 : primitive.uv0, primitive.indices);
        const std::span<const uint32_t> added = std::span(mesh.sources).subspan(primitive.positions.size());
        AppendVertices(primitive.positions, added);
        AppendVertices(primitive.normals, added);
        AppendVertices(primitive.tangents, added);
        AppendVertices(primitive.uv0, added);
        AppendVertices(primitive.uv1, added);
        AppendVertices(primitive.colors, added);
        AppendVertices(primitive.influences.joints, added, primitive.influences.perVertex);
        AppendVertices(primitive.influences.weights, added, primitive.influences.perVertex);
        for (MorphTarget& target : primitive.targets) {
            AppendVertices(target.positions, added);
            AppendVertices(target.normals, added);
        }
        primitive.indices = std::move(mesh.indices);
        return std::move(mesh.tangents);
    }

    // Copies of the vertices named, at the end of a stream that is there and has so many elements of each.
    template <typename Vector>
    static void AppendVertices(std::vector<Vector>& stream, std::span<const uint32_t> sources,
                               size_t perVertex = 1) {
        if (stream.empty()) return;
        stream.reserve(stream.size() + sources.size() * perVertex);
        for (const uint32_t source : sources)
            for (size_t i = 0; i < perVertex; ++i) stream.push_back(stream[source * perVertex + i]);
    }

    void ClampColors(std::vector<glm::vec4>& colors) {
        size_t count = 0;
        for (glm::vec4& color : colors) {
            const glm::vec4 clamped = glm::clamp(color, 0.0f, 1.0f);
            count += clamped != color ? 1 : 0;
            color = clamped;
        }
        if (count > 0)
            m_context.Warn(m_layout.where, "color",
                           Text("{} outside 0 to 1, put into it",
                                Counted(count, "COLOR_0 value is", "COLOR_0 values are")));
    }

    void WarnLost(const char* what, size_t count, const char* remedy) {
        m_context.Warn(
            m_layout.where, what,
            Text("{} no length, {}", Counted(count, Text("{} value has", what), Text("{} values have", what)),
                 remedy));
    }

    GltfContext& m_context;
    AccessorReader& m_reader;
    const PrimitiveLayout& m_layout;
    std::vector<TextureRef> m_maps;
    const VertexUse& m_use;
    const JointLimit& m_joints;
    DracoPrimitive m_decoded;  // Empty if the layout is not compressed.
};

// Returns whether two textures turn a direction of the surface into different ones of the image: by another
// set of coordinates, another rotation or another mirroring.
bool DiffersInMapping(const TextureRef& a, const TextureRef& b) {
    return a.texCoord != b.texCoord || a.transform.rotation != b.transform.rotation ||
           glm::sign(a.transform.scale) != glm::sign(b.transform.scale);
}

// Returns the directional textures of the primitive's own material, then those of its variants.
std::vector<TextureRef> DirectionalTextures(const Primitive& primitive, std::span<const Material> materials) {
    std::vector<TextureRef> maps = materials[primitive.material].DirectionalTextures();
    for (const VariantMaterial& variant : primitive.variants) {
        const std::vector<TextureRef> more = materials[variant.material].DirectionalTextures();
        maps.insert(maps.end(), more.begin(), more.end());
    }
    return maps;
}

// Tangents of the file are the frame of all maps, which a file whose maps differ in their coordinates may not
// mean.
void WarnOfSharedTangents(GltfContext& context, const PrimitiveLayout& layout, const Material& material) {
    if (!layout.Has(Attribute::Tangent) || !layout.Has(Attribute::Normal)) return;
    const std::vector<TextureRef> maps = material.DirectionalTextures();
    const auto differs = [&](const TextureRef& map) { return DiffersInMapping(map, maps[0]); };
    if (std::ranges::any_of(maps, differs))
        context.Warn(
            layout.where["attributes"]["TANGENT"], "frame of several maps",
            Text("material \"{}\" reads directions by different texture coordinates; all of them count "
                 "along TANGENT",
                 material.name));
}

}  // namespace

Mesh DecodeMesh(GltfContext& context, AccessorReader& reader, const MeshLayout& layout,
                std::span<const Material> materials, uint32_t defaultMaterial, const JointLimit& joints) {
    const auto given = [&](uint32_t material) { return material == kNone ? defaultMaterial : material; };
    Mesh mesh{.name = layout.name, .primitives = {}, .weights = layout.weights};
    for (const PrimitiveLayout& part : layout.primitives) {
        Primitive shown;
        shown.material = given(part.material);
        for (const VariantMaterial& variant : part.variants)
            shown.variants.push_back({variant.variant, given(variant.material)});
        WarnOfSharedTangents(context, part, materials[shown.material]);
        VertexUse use;
        AddUse(materials[shown.material], part, use);
        for (const VariantMaterial& variant : shown.variants) AddUse(materials[variant.material], part, use);
        Primitive primitive =
            PrimitiveDecoder(context, reader, part, DirectionalTextures(shown, materials), use, joints)
                .Decode();
        if (primitive.indices.empty()) continue;
        primitive.material = shown.material;
        primitive.variants = std::move(shown.variants);
        mesh.primitives.push_back(std::move(primitive));
    }
    return mesh;
}

// --- The layout of meshes, which is checked before anything is decoded ---

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

    // Returns nothing if all variants show the primitive's own material.
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
        // Only the first entry of each variant is kept
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
