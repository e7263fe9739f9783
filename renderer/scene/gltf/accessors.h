// bufferViews and accessors, checked: after ReadAccessorTables every byte that an accessor covers lies inside
// its buffer view, and every view, compressed or not, inside its buffer, whatever the file said. Internal
// to renderer/scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "renderer/scene/gltf/container.h"
#include "renderer/scene/gltf/context.h"
#include "renderer/scene/gltf/document.h"
#include "renderer/scene/gltf/meshopt.h"

namespace raygraph::scene {

struct BufferView {
    uint32_t buffer = 0;
    uint64_t byteOffset = 0;
    uint64_t byteLength = 0;
    uint32_t byteStride = 0;  // 0: tightly packed
    // The source of the view's bytes, if they are not in `buffer`.
    std::optional<MeshoptView> meshopt;
};

enum class ComponentType : uint8_t { Int8, Uint8, Int16, Uint16, Uint32, Float };
size_t ByteSize(ComponentType type);

// Describes a strided run of elements in a buffer view. `view` is kNone: all zeros.
struct ElementRun {
    uint32_t view = kNone;
    uint64_t byteOffset = 0;  // in the view
    uint64_t byteStride = 0;
};

struct SparseRun {
    uint64_t count = 0;
    ComponentType indexType = ComponentType::Uint32;
    ElementRun indices;
    ElementRun values;
};

struct Accessor {
    uint64_t count = 0;
    ComponentType componentType = ComponentType::Float;
    uint32_t componentCount = 1;  // 1 for SCALAR, n for VECn, rows * columns for matrices
    bool isMatrix = false;
    bool isNormalized = false;
    ElementRun run;
    std::optional<SparseRun> sparse;
};

struct AccessorTables {
    std::vector<uint64_t> bufferLengths;  // buffers[i].byteLength
    std::vector<BufferView> views;
    std::vector<Accessor> accessors;
};

// Reads and checks buffers' lengths, bufferViews and accessors; no buffer is opened.
AccessorTables ReadAccessorTables(const GltfContext& context, const GltfDocument& document);

// The bytes behind buffer views, opened when first asked for.
class GltfBuffers {
  public:
    // All arguments must outlive this object.
    GltfBuffers(GltfContext& context, const std::vector<BufferSource>& sources, const AccessorTables& tables,
                const GltfContainer& container);

    // The bytes of a view, decoded if they are compressed; they live as long as this object. Fails if its
    // buffer cannot be read or is shorter than it claims.
    std::span<const std::byte> View(uint32_t view);

  private:
    std::span<const std::byte> Buffer(uint32_t buffer);

    GltfContext& m_context;
    const std::vector<BufferSource>& m_sources;
    const AccessorTables& m_tables;
    const GltfContainer& m_container;
    std::vector<std::optional<std::vector<std::byte>>> m_files;    // those not in the .glb
    std::vector<std::optional<std::vector<std::byte>>> m_decoded;  // indexed by view
};

}  // namespace raygraph::scene
