// Primitives that KHR_draco_mesh_compression holds compressed. Internal to renderer/scene.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/scene/gltf/accessors.h"
#include "renderer/scene/gltf/context.h"
#include "renderer/scene/gltf/meshes.h"

namespace raygraph::scene {

// Describes a decoded primitive: a list of triangles, all indices below the layout's vertex count.
struct DracoPrimitive {
    std::vector<uint32_t> indices;
    // Tightly packed, as the attribute's accessor says; empty for those that are not in the compressed data.
    std::array<std::vector<std::byte>, kAttributeCount> attributes;
};

// `compressed` are the bytes of layout.draco->view. Charges what decoding takes before it is taken. Fails at
// the extension if they are no mesh, or not the one that the primitive's accessors describe.
DracoPrimitive DecodeDraco(GltfContext& context, const PrimitiveLayout& layout, const AccessorTables& tables,
                           std::span<const std::byte> compressed);

}  // namespace raygraph::scene
