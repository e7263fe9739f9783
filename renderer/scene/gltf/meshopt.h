// Buffer views that EXT_meshopt_compression or KHR_meshopt_compression holds compressed. Internal to
// renderer/scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "renderer/scene/gltf/context.h"
#include "renderer/scene/gltf/model.h"

namespace raygraph::scene {

enum class MeshoptMode : uint8_t { Attributes, Triangles, Indices };
enum class MeshoptFilter : uint8_t { None, Octahedral, Quaternion, Exponential };

// Where a view's compressed bytes are, and what they are decoded to: count * byteStride bytes.
struct MeshoptView {
    const char* extension = nullptr;
    uint32_t buffer = 0;
    uint64_t byteOffset = 0;
    uint64_t byteLength = 0;
    uint64_t count = 0;
    uint32_t byteStride = 0;
    MeshoptMode mode = MeshoptMode::Attributes;
    MeshoptFilter filter = MeshoptFilter::None;

    uint64_t DecodedBytes() const { return count * byteStride; }
};

// Returns the compression of a buffer view of the file, if it is compressed. Checks all that can be checked
// without its bytes; `byteStride` is the view's own, 0 for none.
std::optional<MeshoptView> ReadMeshoptView(const GltfContext& context, const gltf::Model& model, size_t view,
                                           uint32_t byteStride);

// Returns whether a buffer only stands in for bytes that are compressed elsewhere: it is never opened.
bool IsMeshoptFallback(const gltf::Buffer& buffer);

// `where` is the view's. Memory is charged before it is taken.
std::vector<std::byte> DecodeMeshopt(GltfContext& context, const MeshoptView& view,
                                     std::span<const std::byte> compressed, const Place& where);

}  // namespace raygraph::scene
