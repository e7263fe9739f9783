// Buffers, textures, samplers and memory blocks: move-only owners that Device::Create* returns.
//
// Lifetime: destroying an owner passes the Vulkan objects to its Device, which frees them once its timeline
// has passed every submission made before the destruction. An owner must not outlive its Device. A moved-from
// or default-constructed owner is empty: Handle() is VK_NULL_HANDLE and destroying it does nothing. Threads:
// creation and destruction may happen on any thread; an object must not be used by two at once.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/api.h"
#include "rhi/format.h"
#include "rhi/memory_allocator.h"
#include "rhi/subresources.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

class Device;

// Operators that make an enum class with explicit bit values a bit set.
template <typename E>
requires requires {
    E::IsBitSet;
}
constexpr E operator|(E a, E b) {
    return static_cast<E>(static_cast<uint32_t>(a) | static_cast<uint32_t>(b));
}
template <typename E>
requires requires {
    E::IsBitSet;
}
constexpr E& operator|=(E& a, E b) {
    return a = a | b;
}
template <typename E>
requires requires {
    E::IsBitSet;
}
constexpr bool Has(E set, E bits) {
    return (static_cast<uint32_t>(set) & static_cast<uint32_t>(bits)) == static_cast<uint32_t>(bits);
}

enum class BufferUsage : uint32_t {
    None = 0,
    Storage = 1u << 0,
    Uniform = 1u << 1,
    Index = 1u << 2,
    Vertex = 1u << 3,
    Indirect = 1u << 4,
    CopySource = 1u << 5,
    CopyDestination = 1u << 6,
    BuildInput = 1u << 7,             // vertices, indices or instances of an acceleration-structure build
    AccelerationStructure = 1u << 8,  // storage of an acceleration structure
    ShaderBindingTable = 1u << 9,
    IsBitSet = 0,
};

struct BufferDesc {
    std::string name = "buffer";
    uint64_t size = 0;  // bytes; 0 is refused
    BufferUsage usage = BufferUsage::Storage;
    MemoryKind memory = MemoryKind::Device;
    // Gives the buffer its own allocation, outside of the blocks that resources share; for large buffers that
    // live long.
    bool hasOwnMemory = false;
    // For WrapBuffer: the host has created it with VK_SHARING_MODE_CONCURRENT, for the Device's queue
    // families among others. The Device shares its own buffers among its families in any case.
    bool isShared = false;
};

class RAYGRAPH_API Buffer {
  public:
    Buffer() = default;
    Buffer(Buffer&& other) noexcept { *this = std::move(other); }
    Buffer& operator=(Buffer&& other) noexcept;
    ~Buffer();

    VkBuffer Handle() const { return m_buffer; }
    uint64_t Size() const { return m_desc.size; }
    // Returns the device address, which every buffer has (buffer device address is required). It is queried
    // only here: older validation layers confuse buffers that share memory once they know their addresses.
    VkDeviceAddress Address() const;
    // Returns the mapped bytes of an Upload or Readback buffer, which are coherent; empty for Device memory.
    std::span<std::byte> Mapped() const;
    const BufferDesc& Desc() const { return m_desc; }
    // Tells whether its sharing mode is concurrent: the families for which it was created need no transfers
    // of ownership then.
    bool IsShared() const { return m_isShared; }
    // Returns false for a wrapped buffer of a host: destroying this object then frees nothing.
    bool OwnsBuffer() const { return m_ownsBuffer; }
    explicit operator bool() const { return m_buffer != VK_NULL_HANDLE; }

  private:
    friend class Device;
    void Release() noexcept;
    Device* m_device = nullptr;
    BufferDesc m_desc;
    VkBuffer m_buffer = VK_NULL_HANDLE;
    MemoryAllocation m_memory;  // empty: bound to a MemoryBlock, or wrapped
    std::byte* m_mapped = nullptr;
    bool m_ownsBuffer = true;
    bool m_isShared = false;
};

enum class TextureUsage : uint32_t {
    None = 0,
    Sampled = 1u << 0,
    Storage = 1u << 1,
    ColorTarget = 1u << 2,
    DepthTarget = 1u << 3,
    CopySource = 1u << 4,
    CopyDestination = 1u << 5,
    IsBitSet = 0,
};

struct TextureDesc {
    std::string name = "texture";
    Extent2D extent = {};  // texels; an empty extent is refused
    Format format = Format::Rgba8Unorm;
    TextureUsage usage = TextureUsage::Sampled | TextureUsage::CopyDestination;
    uint32_t mipLevels = 1;
    uint32_t layers = 1;
    // All queues of the Device may access it, without transfers of ownership. Textures of the Device that are
    // only copied and sampled always are.
    bool isShared = false;
};

// A 2D image, or an array of them, with a view of all of it (none if it is only copied). Views of parts are
// created when they are first requested, and destroyed with it. The layout is not tracked here, but by the
// render graph.
class RAYGRAPH_API Texture {
  public:
    Texture() = default;
    Texture(Texture&& other) noexcept { *this = std::move(other); }
    Texture& operator=(Texture&& other) noexcept;
    ~Texture();

    VkImage Image() const { return m_image; }
    // Returns a view of all levels and layers: a 2D view of a texture of one layer, an array view of others.
    VkImageView View() const { return m_view; }
    // Returns a view of a part, for a shader or as a target. Throws Error{Usage} for a part that the texture
    // does not have, or that does not fit the shape: a cube map needs six layers of a square texture.
    VkImageView View(const Subresources& part, ImageShape shape) const;
    Extent2D Extent() const { return m_desc.extent; }
    const TextureDesc& Desc() const { return m_desc; }
    // Tells whether its sharing mode is concurrent: the families for which it was created need no transfers
    // of ownership then.
    bool IsShared() const { return m_isShared; }
    // RangeOf takes a resolved part.
    VkImageSubresourceRange RangeOf(const Subresources& part) const;
    VkImageSubresourceRange WholeRange() const;
    // Returns false for a wrapped image of a host: destroying this object then frees only the views.
    bool OwnsImage() const { return m_ownsImage; }
    explicit operator bool() const { return m_image != VK_NULL_HANDLE; }

  private:
    friend class Device;
    struct PartView {
        Subresources part;
        ImageShape shape = ImageShape::Plain;
        VkImageView view = VK_NULL_HANDLE;
    };
    void Release() noexcept;
    Device* m_device = nullptr;
    TextureDesc m_desc;
    VkImage m_image = VK_NULL_HANDLE;
    VkImageView m_view = VK_NULL_HANDLE;
    mutable std::vector<PartView> m_partViews;  // created so far
    MemoryAllocation m_memory;                  // empty: bound to a MemoryBlock, or a host's image
    bool m_ownsImage = true;
    bool m_isShared = false;
};

enum class Filter : uint8_t { Nearest, Linear };
enum class AddressMode : uint8_t { Repeat, MirroredRepeat, ClampToEdge };

struct SamplerDesc {
    std::string name = "sampler";
    Filter magFilter = Filter::Linear;
    Filter minFilter = Filter::Linear;
    Filter mipFilter = Filter::Linear;
    AddressMode addressU = AddressMode::Repeat;
    AddressMode addressV = AddressMode::Repeat;
    // The maximum number of samples along the longer axis of a footprint that a shader gives by derivatives,
    // for linear filters. It is clamped to DeviceInfo::maxAnisotropy; 1 treats footprints as round.
    float maxAnisotropy = 1.0f;
};

class RAYGRAPH_API Sampler {
  public:
    Sampler() = default;
    Sampler(Sampler&& other) noexcept { *this = std::move(other); }
    Sampler& operator=(Sampler&& other) noexcept;
    ~Sampler();

    VkSampler Handle() const { return m_sampler; }
    explicit operator bool() const { return m_sampler != VK_NULL_HANDLE; }

  private:
    friend class Device;
    void Release() noexcept;
    Device* m_device = nullptr;
    VkSampler m_sampler = VK_NULL_HANDLE;
};

// The memory requirements of a resource, known before it is bound: input of transient aliasing.
struct MemoryRequirements {
    uint64_t size = 0;
    uint64_t alignment = 1;
    uint32_t memoryTypeBits = 0;

    bool operator==(const MemoryRequirements&) const = default;
};

// Device memory that several transient textures and buffers with disjoint lifetimes share. Each is bound at
// offset 0.
class RAYGRAPH_API MemoryBlock {
  public:
    MemoryBlock() = default;
    MemoryBlock(MemoryBlock&& other) noexcept { *this = std::move(other); }
    MemoryBlock& operator=(MemoryBlock&& other) noexcept;
    ~MemoryBlock();

    // Returns the requirements as requested, with the one memory type that was chosen. Bound resources must
    // fit into them.
    const MemoryRequirements& Requirements() const { return m_requirements; }
    explicit operator bool() const { return bool(m_memory); }

  private:
    friend class Device;
    void Release() noexcept;
    Device* m_device = nullptr;
    MemoryRequirements m_requirements;
    MemoryAllocation m_memory;
};

}  // namespace raygraph::rhi
