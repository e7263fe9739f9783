// meshes: checked as a whole, then decoded one by one. Internal to renderer/scene.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "renderer/scene/gltf_accessors.h"
#include "renderer/scene/gltf_context.h"
#include "renderer/scene/gltf_reader.h"
#include "renderer/scene/scene_data.h"
#include "renderer/scene/triangles.h"

namespace raygraph::scene {

// The attributes that are read; others are ignored.
enum class Attribute : uint8_t { Position, Normal, Tangent, TexCoord0, TexCoord1, Color0 };
inline constexpr size_t kAttributeCount = 6;
const char* AttributeName(Attribute attribute);

// Where a primitive's compressed data is (KHR_draco_mesh_compression), and which of its attributes are in it.
struct DracoLayout {
    uint32_t view = kNone;
    std::array<uint32_t, kAttributeCount> ids;  // kNone: the attribute is read from its accessor.
};

// A primitive whose accessors are in range, of fitting types and of one count; nothing is decoded yet.
struct PrimitiveLayout {
    Place where;
    PrimitiveMode mode = PrimitiveMode::Triangles;
    std::array<uint32_t, kAttributeCount> accessors;  // kNone: absent.
    uint32_t indices = kNone;
    uint32_t material = kNone;
    uint64_t vertexCount = 0;
    std::optional<DracoLayout> draco = {};
    // As Primitive::variants, where kNone is for the material above, which may be none itself.
    std::vector<VariantMaterial> variants = {};

    uint32_t Accessor(Attribute attribute) const { return accessors[static_cast<size_t>(attribute)]; }
    bool Has(Attribute attribute) const { return Accessor(attribute) != kNone; }
};

struct MeshLayout {
    std::string name;
    std::vector<PrimitiveLayout> primitives;  // Without those that have no positions or are left out.
};

// Reads and checks all of the file's meshes.
std::vector<MeshLayout> ReadMeshLayouts(GltfContext& context, const gltf::Model& model,
                                        const AccessorTables& tables);

// Decodes a mesh. Primitives without a material get `defaultMaterial`; those whose material, or one of a
// variant, has a normal map get tangents if they have none.
Mesh DecodeMesh(GltfContext& context, AccessorReader& reader, const MeshLayout& layout,
                std::span<const Material> materials, uint32_t defaultMaterial);

}  // namespace raygraph::scene
