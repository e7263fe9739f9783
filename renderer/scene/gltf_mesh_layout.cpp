#include <string>

#include "renderer/scene/gltf_meshes.h"

namespace raygraph::scene {
namespace {

// Which accessors an attribute may be read from: the core's types and those KHR_mesh_quantization adds. Both
// are taken whether or not the file declares the extension.
bool IsAllowed(Attribute attribute, const Accessor& accessor) {
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
    }
    return false;
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
    }
    return "";
}

bool IsIndexAccessor(const Accessor& accessor) {
    const bool isUnsigned = accessor.componentType == ComponentType::Uint8 ||
                            accessor.componentType == ComponentType::Uint16 ||
                            accessor.componentType == ComponentType::Uint32;
    return accessor.componentCount == 1 && isUnsigned && !accessor.isNormalized;
}

void ReadAttributes(const JsonValue& attributes, const AccessorTables& tables, PrimitiveLayout& layout) {
    layout.accessors.fill(kNone);
    for (size_t i = 0; i < kAttributeCount; ++i) {
        const auto attribute = static_cast<Attribute>(i);
        const JsonValue value = attributes[AttributeName(attribute)];
        const uint32_t index = value.IndexOr(kNone, tables.accessors.size(), "accessors");
        if (index == kNone) continue;
        const Accessor& accessor = tables.accessors[index];
        if (!IsAllowed(attribute, accessor))
            value.Fail("accessors[" + std::to_string(index) + "] must be " + AllowedTypes(attribute));
        layout.accessors[i] = index;
        if (attribute == Attribute::Position) layout.vertexCount = accessor.count;
        if (layout.Has(Attribute::Position) && accessor.count != layout.vertexCount)
            value.Fail("accessors[" + std::to_string(index) + "] has " + std::to_string(accessor.count) +
                       " elements, POSITION has " + std::to_string(layout.vertexCount));
    }
}

PrimitiveLayout ReadPrimitive(const JsonValue& value, const AccessorTables& tables, size_t materialCount) {
    PrimitiveLayout layout{.where = value, .accessors = {}};
    const JsonValue mode = value.RequireObject()["mode"];
    const uint64_t modeNumber = mode.UnsignedOr(static_cast<uint64_t>(PrimitiveMode::Triangles));
    if (modeNumber > static_cast<uint64_t>(PrimitiveMode::TriangleFan))
        mode.Fail("is " + mode.Shown() + ", must be 0 to 6");
    layout.mode = static_cast<PrimitiveMode>(modeNumber);
    layout.material = value["material"].IndexOr(kNone, materialCount, "materials");
    ReadAttributes(value["attributes"].RequireObject(), tables, layout);
    const JsonValue indices = value["indices"];
    layout.indices = indices.IndexOr(kNone, tables.accessors.size(), "accessors");
    if (layout.indices != kNone && !IsIndexAccessor(tables.accessors[layout.indices]))
        indices.Fail("accessors[" + std::to_string(layout.indices) +
                     "] must be SCALAR of 5121, 5123 or 5125");
    return layout;
}

}  // namespace

const char* AttributeName(Attribute attribute) {
    switch (attribute) {
        case Attribute::Position:
            return "POSITION";
        case Attribute::Normal:
            return "NORMAL";
        case Attribute::Tangent:
            return "TANGENT";
        case Attribute::TexCoord0:
            return "TEXCOORD_0";
        case Attribute::TexCoord1:
            return "TEXCOORD_1";
        case Attribute::Color0:
            return "COLOR_0";
    }
    return "";
}

std::vector<MeshLayout> ReadMeshLayouts(GltfContext& context, const JsonValue& root,
                                        const AccessorTables& tables, size_t materialCount) {
    std::vector<MeshLayout> meshes;
    const JsonValue values = root["meshes"];
    for (size_t m = 0; m < values.Count(); ++m) {
        const JsonValue value = values.At(m);
        MeshLayout mesh{.name = value.RequireObject()["name"].StringOr(""), .primitives = {}};
        const JsonValue primitives = value["primitives"];
        if (primitives.Count() == 0) primitives.Fail("has no elements, must have at least 1");
        for (size_t p = 0; p < primitives.Count(); ++p) {
            const PrimitiveLayout layout = ReadPrimitive(primitives.At(p), tables, materialCount);
            if (primitives.At(p)["targets"].Count() > 0)
                context.Warn(layout.where, "morph", "morph targets are not read, the base shape is shown");
            if (layout.mode < PrimitiveMode::Triangles) {
                context.Warn(layout.where, "mode", "points and lines are left out");
            } else if (!layout.Has(Attribute::Position)) {
                context.Warn(layout.where, "position", "has no POSITION, left out");
            } else {
                mesh.primitives.push_back(layout);
            }
        }
        meshes.push_back(std::move(mesh));
    }
    return meshes;
}

}  // namespace raygraph::scene
