// Acceleration structures: an owner of one, and the bottom-level ones (BLAS) that a builder makes
// (rhi/blas_builder.h). Threads: as in rhi/resources.h; only its BlasBuilder changes a Blas.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/api.h"
#include "rhi/resources.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

// Owns one VkAccelerationStructureKHR and its buffer; an owner as in rhi/resources.h.
class RAYGRAPH_API AccelerationStructure {
  public:
    AccelerationStructure() = default;
    AccelerationStructure(Device& device, const std::string& name, VkAccelerationStructureTypeKHR type,
                          uint64_t bytes);
    AccelerationStructure(AccelerationStructure&& other) noexcept { *this = std::move(other); }
    AccelerationStructure& operator=(AccelerationStructure&& other) noexcept;
    ~AccelerationStructure();
    // Wraps a structure that a host owns: destroying this object then frees nothing. Bytes() is 0.
    static AccelerationStructure Wrap(Device& device, VkAccelerationStructureKHR structure);

    VkAccelerationStructureKHR Handle() const { return m_structure; }
    bool IsOwned() const { return m_isOwned; }
    VkDeviceAddress Address() const { return m_address; }
    uint64_t Bytes() const { return m_bytes; }
    explicit operator bool() const { return m_structure != VK_NULL_HANDLE; }

  private:
    void Release() noexcept;
    void RequestAddress();
    Device* m_device = nullptr;
    Buffer m_storage;
    bool m_isOwned = true;
    VkAccelerationStructureKHR m_structure = VK_NULL_HANDLE;
    VkDeviceAddress m_address = 0;
    uint64_t m_bytes = 0;
};

enum class BlasKind : uint8_t {
    Static,  // fast to trace; compacted; never updated
    // Updated or rebuilt in place when its vertices move (BlasBuilder::RecordRefits); compacted only where
    // BlasBuilderDesc says so.
    Deforming,
};

// Triangles with 32-bit indices and float3 positions at the start of each vertex. The buffers carry
// BufferUsage::BuildInput and stay alive until the build has completed.
struct TriangleGeometry {
    VkDeviceAddress vertices = 0;  // address of the first vertex, a multiple of 4
    uint32_t vertexStride = 12;    // bytes, a multiple of 4
    uint32_t vertexCount = 0;      // every index is below it
    VkDeviceAddress indices = 0;   // address of the first index, a multiple of 4
    uint32_t triangleCount = 0;
    bool isOpaque = true;            // opaque geometry never runs an any-hit shader
    bool noDuplicateAnyHit = false;  // no ray runs any-hit more than once on a triangle
};

// Boxes for an intersection shader: tightly packed VkAabbPositionsKHR (float min[3], max[3]).
struct AabbGeometry {
    VkDeviceAddress boxes = 0;  // a multiple of 8
    uint32_t boxCount = 0;
    bool isOpaque = true;
    bool noDuplicateAnyHit = false;  // no ray runs any-hit more than once for a reported hit
};

// Either triangles or AABBs: one BLAS cannot hold both. gl_GeometryIndexEXT counts the elements;
// rhi/shader_binding_table.h says which hit set each of them takes.
struct BlasDesc {
    std::string name = "blas";
    BlasKind kind = BlasKind::Static;
    std::vector<TriangleGeometry> triangles{};
    std::vector<AabbGeometry> aabbs{};
};

// One bottom-level structure, made by BlasBuilder::Add. Its address changes when a compacted structure
// replaces it: Version is then incremented, and every TLAS that refers to it has to be rebuilt.
class RAYGRAPH_API Blas {
  public:
    const std::string& Name() const { return m_desc.name; }
    BlasKind Kind() const { return m_desc.kind; }
    // False until a build has been recorded: Address() is then 0.
    bool IsBuilt() const { return static_cast<bool>(m_structure); }
    bool IsCompacted() const { return m_isCompacted; }
    VkAccelerationStructureKHR Handle() const { return m_structure.Handle(); }
    VkDeviceAddress Address() const { return m_structure.Address(); }
    uint64_t Bytes() const { return m_structure.Bytes(); }
    uint64_t BytesBuilt() const { return m_bytesBuilt; }  // before compaction
    uint32_t Version() const { return m_version; }
    const BlasDesc& Desc() const { return m_desc; }

  private:
    friend class BlasBuilder;
    BlasDesc m_desc;
    AccelerationStructure m_structure;
    AccelerationStructure m_reserved;  // for a build that has not been recorded
    VkBuildAccelerationStructureFlagsKHR m_flags = 0;
    uint64_t m_bytesBuilt = 0;
    uint64_t m_buildScratch = 0;  // bytes, known once m_reserved has been made; likewise m_updateScratch
    uint64_t m_updateScratch = 0;
    uint32_t m_version = 0;
    bool m_isCompacted = false;
};

}  // namespace raygraph::rhi
