// meshes: checked as a whole, then decoded one by one. Internal to renderer/scene.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "renderer/scene/geometry/triangles.h"
#include "renderer/scene/gltf/accessors.h"
#include "renderer/scene/gltf/context.h"
#include "renderer/scene/gltf/reader.h"
#include "renderer/scene/model/scene_data.h"

namespace raygraph::scene {

// The attributes that are read; others are ignored. Of joints and weights so many sets of four a vertex.
inline constexpr size_t kJointSets = 8;
enum class Attribute : uint8_t {
    Position,
    Normal,
    Tangent,
    TexCoord0,
    TexCoord1,
    Color0,
    Joints0,
    Weights0 = Joints0 + kJointSets,
};
inline constexpr std::array kAttributeNames{
    "POSITION",  "NORMAL",    "TANGENT",   "TEXCOORD_0", "TEXCOORD_1", "COLOR_0",  "JOINTS_0",  "JOINTS_1",
    "JOINTS_2",  "JOINTS_3",  "JOINTS_4",  "JOINTS_5",   "JOINTS_6",   "JOINTS_7", "WEIGHTS_0", "WEIGHTS_1",
    "WEIGHTS_2", "WEIGHTS_3", "WEIGHTS_4", "WEIGHTS_5",  "WEIGHTS_6",  "WEIGHTS_7"};
inline constexpr size_t kAttributeCount = kAttributeNames.size();
static_assert(kAttributeCount == static_cast<size_t>(Attribute::Weights0) + kJointSets);
// The first set that is not read.
inline constexpr const char* kUnreadJoints = "JOINTS_8";

constexpr const char* AttributeName(Attribute attribute) {
    return kAttributeNames[static_cast<size_t>(attribute)];
}
constexpr Attribute JointsOf(size_t set) {
    return static_cast<Attribute>(static_cast<size_t>(Attribute::Joints0) + set);
}
constexpr Attribute WeightsOf(size_t set) {
    return static_cast<Attribute>(static_cast<size_t>(Attribute::Weights0) + set);
}
constexpr bool IsJoints(Attribute attribute) {
    return attribute >= Attribute::Joints0 && attribute < Attribute::Weights0;
}

// Holds the accessors of a morph target; kNone: no displacement.
struct MorphLayout {
    uint32_t positions = kNone, normals = kNone, tangents = kNone;
};

// Where a primitive's compressed data is (KHR_draco_mesh_compression), and which of its attributes are in it.
struct DracoLayout {
    uint32_t view = kNone;
    std::array<uint32_t, kAttributeCount> ids;  // kNone: the attribute is read from its accessor.
};

// A primitive whose accessors are in range, of fitting types and of one count; nothing is decoded yet.
struct PrimitiveLayout {
    Place where;
    PrimitiveMode mode = PrimitiveMode::Triangles;
    std::array<uint32_t, kAttributeCount> accessors;  // kNone: absent
    uint32_t indices = kNone;
    uint32_t material = kNone;
    uint64_t vertexCount = 0;
    std::optional<DracoLayout> draco = {};
    // The materials of Primitive::variants. kNone is the material above, which may itself be absent.
    std::vector<VariantMaterial> variants = {};
    std::vector<MorphLayout> targets = {};

    uint32_t Accessor(Attribute attribute) const { return accessors[static_cast<size_t>(attribute)]; }
    bool Has(Attribute attribute) const { return Accessor(attribute) != kNone; }
};

struct MeshLayout {
    std::string name;
    std::vector<PrimitiveLayout> primitives;  // Without those that have no positions or are left out.
    std::vector<float> weights;               // the values of Mesh::weights
};

// Reads and checks all of the file's meshes.
std::vector<MeshLayout> ReadMeshLayouts(GltfContext& context, const gltf::Model& model,
                                        const AccessorTables& tables);

// Holds the skin of a mesh whose joints are the fewest, of those that it is placed with.
struct JointLimit {
    uint32_t skin = kNone;  // kNone: there is none, joints are not read.
    size_t count = 0;
};

// Decodes a mesh. Primitives without a material get `defaultMaterial`; those whose material, or one of a
// variant, has a normal map get tangents if they have none.
Mesh DecodeMesh(GltfContext& context, AccessorReader& reader, const MeshLayout& layout,
                std::span<const Material> materials, uint32_t defaultMaterial, const JointLimit& joints);

}  // namespace raygraph::scene
