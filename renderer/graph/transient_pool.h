// TransientPool: the Vulkan objects behind transients, kept between frames. Threads: that of the Renderer.
//
// Block b of a plan is block b of the pool; textures and buffers in it are found by name, description and
// usage. Objects that no frame has used for kKeepFrames frames are freed, as is a block that has been far too
// large for that time. The Device keeps destroyed objects until the frames that use them have completed.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "rhi/device.h"
#include "rhi/resources.h"

namespace raygraph {

class TransientPool {
  public:
    static constexpr uint64_t kKeepFrames = 16;

    explicit TransientPool(rhi::Device& device) : m_device(device) {}

    // The result is cached: the driver is queried once for each combination of all fields except the name.
    rhi::MemoryRequirements RequirementsOf(const rhi::TextureDesc& desc);
    rhi::MemoryRequirements RequirementsOf(const rhi::BufferDesc& desc);

    // Makes block b large enough for blocks[b], for every b. Objects in a block that is replaced are
    // destroyed.
    void Reserve(std::span<const rhi::MemoryRequirements> blocks, uint64_t frame);
    // Returns the object at the start of a block. The reference is valid until the next Reserve.
    const rhi::Texture& Place(const rhi::TextureDesc& desc, uint32_t block, uint64_t frame);
    const rhi::Buffer& Place(const rhi::BufferDesc& desc, uint32_t block, uint64_t frame);
    // Returns a buffer for memory that the CPU writes, which no other frame in flight uses.
    const rhi::Buffer& TakeUpload(const rhi::BufferDesc& desc, uint64_t frame);
    // Frees objects that have not been used for kKeepFrames frames.
    void Trim(uint64_t frame);

  private:
    template <typename T>
    struct Placed {
        T object;
        uint64_t lastFrame = 0;
    };
    struct Block {
        rhi::MemoryBlock memory;
        uint64_t lastFrame = 0;    // last frame that used it
        uint64_t lastFitting = 0;  // last frame that used more than a quarter of it
        std::vector<std::unique_ptr<Placed<rhi::Texture>>> textures;
        std::vector<std::unique_ptr<Placed<rhi::Buffer>>> buffers;
    };
    struct KnownTexture {
        rhi::TextureDesc desc;
        rhi::MemoryRequirements requirements;
    };
    struct KnownBuffer {
        rhi::BufferDesc desc;
        rhi::MemoryRequirements requirements;
    };

    rhi::Device& m_device;
    std::vector<Block> m_blocks;
    std::vector<std::unique_ptr<Placed<rhi::Buffer>>> m_uploads;
    std::vector<KnownTexture> m_knownTextures;
    std::vector<KnownBuffer> m_knownBuffers;
};

}  // namespace raygraph
