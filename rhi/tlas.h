// Tlas: the top-level acceleration structure over instances of BLASes. Threads: one thread at a time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/api.h"
#include "rhi/acceleration_structure.h"
#include "rhi/blas_build.h"
#include "rhi/resources.h"

namespace raygraph::rhi {

class CommandList;

struct TlasInstance {
    // 3 rows of 4, row-major: world = m * (x, y, z, 1).
    std::array<float, 12> objectToWorld{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    uint32_t customIndex = 0;  // 24 bits: gl_InstanceCustomIndexEXT
    uint8_t mask = 0xff;       // seen by rays whose cull mask shares a bit; 0: never hit
    // 24 bits: the index of the instance's first hit record in the shader binding table, which is the index
    // of its hit set (RayTracingPipelineDesc::hitSets) times the number of ray types.
    uint32_t hitRecord = 0;
    VkDeviceAddress blas = 0;  // Blas::Address(); 0: the instance is inactive
    // A face is front where its vertices turn counter-clockwise seen from the ray's origin (in right-handed
    // space and before objectToWorld, as in glTF); if flipped, clockwise.
    bool isFacingFlipped = false;
    bool isCullingDisabled = true;  // gl_RayFlagsCull*FacingTrianglesEXT have no effect on it
};

// The size of one instance as the device reads it.
inline constexpr uint64_t kTlasInstanceBytes = 64;

// Writes instances as the device reads them; `target` has kTlasInstanceBytes for each (Buffer::Mapped() for
// example). Throws Error{Usage} with the instance's index if customIndex or hitRecord exceeds 24 bits.
RAYGRAPH_API void WriteInstances(std::span<const TlasInstance> instances, std::span<std::byte> target);

struct TlasDesc {
    std::string name = "tlas";
    uint32_t capacity = 0;     // maximum number of instances; more of them need a new Tlas
    bool allowsUpdate = true;  // Update may be called
};

// An owner as in rhi/resources.h, with its own scratch memory. Build and Update order themselves after
// earlier builds on the device; the caller that records the list orders readers of the structure. Dropping a
// list undoes its builds. A structure from Device::WrapTlas belongs to a host and can only be traced against:
// Build and Update throw Error{Usage}, and Bytes and InstanceCount are 0. The host's instances must have the
// fields that Raygraph's shaders read, and the hit records of its hit sets.
class RAYGRAPH_API Tlas {
  public:
    Tlas() = default;
    Tlas(Device& device, const TlasDesc& desc);

    // Builds from `count` instances at the start of `instances` (BufferUsage::BuildInput), which must live
    // until the build has completed. With zero instances, every ray misses. Throws Error{Usage} if count
    // exceeds the capacity or the buffer.
    void Build(CommandList& commands, const Buffer& instances, uint32_t count);
    // Updates in place after transforms have changed. Throws Error{Usage} without an earlier Build, with
    // another count than that of the last Build, or without allowsUpdate. No instance may have become active
    // or inactive.
    void Update(CommandList& commands, const Buffer& instances, uint32_t count);

    VkAccelerationStructureKHR Handle() const { return m_structure.Handle(); }
    VkDeviceAddress Address() const { return m_structure.Address(); }
    uint64_t Bytes() const { return m_structure.Bytes(); }
    uint32_t Capacity() const { return m_desc.capacity; }
    uint32_t InstanceCount() const { return m_built ? m_built->count : 0; }  // instances of the last build
    const std::string& Name() const { return m_desc.name; }
    explicit operator bool() const { return static_cast<bool>(m_structure); }

  private:
    friend class Device;
    void Record(CommandList& commands, const Buffer& instances, uint32_t count, bool isUpdate);
    Device* m_device = nullptr;
    TlasDesc m_desc;
    AccelerationStructure m_structure;
    BuildScratch m_scratch;
    // The state of the build after the recorded lists; it is shared with lists that may be dropped.
    struct Built {
        bool isBuilt = false;
        uint32_t count = 0;
    };
    std::shared_ptr<Built> m_built;
};

}  // namespace raygraph::rhi
