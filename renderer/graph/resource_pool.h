// The objects on the device that a Renderer keeps between frames: persistent ones and those behind
// transients. Threads: that of the Renderer.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/graph/frame_graph.h"
#include "renderer/graph/renderer.h"
#include "rhi/device.h"
#include "rhi/resources.h"

namespace raygraph {

// --- PersistentStore: the resources that a Renderer keeps between frames, by name ---

// Describes one persistent resource. The Vulkan object is created when an executed pass first uses it, so
// that a view that is toggled off takes no memory.
struct Persistent {
    std::string name;
    ResourceKind kind = ResourceKind::Texture;
    GraphTextureDesc textureDesc;
    GraphBufferDesc bufferDesc;
    rhi::Texture texture;
    rhi::Buffer buffer;
    // Both are by subresource, layer by layer.
    std::vector<ResourceState> states{1};  // after the last submitted frame
    std::vector<uint8_t> isWritten = {0};  // by a submitted frame
    uint64_t lastFrame = ~0ull;            // the last frame that declared it
    uint32_t resource = 0;                 // index in that frame

    bool IsMade() const { return texture || buffer; }
    bool Is(const GraphTextureDesc& desc) const {
        return kind == ResourceKind::Texture && textureDesc == desc;
    }
    bool Is(const GraphBufferDesc& desc) const { return kind == ResourceKind::Buffer && bufferDesc == desc; }
};

// Declaring a frame loses nothing: an entry that the frame recreates replaces the old one when the frame is
// submitted.
class PersistentStore {
  public:
    // Returns the entry with that name. If its kind or description differ, returns a new one that replaces it
    // later. Must be called at most once per frame for each name.
    Persistent& Find(std::string_view name, const GraphTextureDesc& desc);
    Persistent& Find(std::string_view name, const GraphBufferDesc& desc);
    // Returns the entry with that name if that frame has declared it; null otherwise.
    Persistent* Declared(std::string_view name, uint64_t frame);
    // Creates the Vulkan object if there is none.
    void Ensure(rhi::Device& device, Persistent& persistent);
    void Release(std::string_view name);
    // Must be called when the frame was submitted, or dropped. Entries keep their addresses.
    void CommitReplacements();
    void DropReplacements() { m_replacements.clear(); }

  private:
    using Entries = std::map<std::string, Persistent, std::less<>>;
    template <typename Desc>
    Persistent& Find(std::string_view name, ResourceKind kind, Desc Persistent::*member, const Desc& desc);
    Entries m_entries;
    Entries m_replacements;  // entries that the current frame has created
};

// TransientPool: the Vulkan objects behind transients, kept between frames.
//
// Block b of a plan is block b of the pool; textures and buffers in it are found by name, description and
// usage. Objects that no frame has used for kKeepFrames frames are freed, as is a block that has been far
// too large for that time. The Device keeps destroyed objects until the frames that use them have completed.
class TransientPool {
  public:
    static constexpr uint64_t kKeepFrames = 16;

    explicit TransientPool(rhi::Device& device) : m_device(device) {}

    // The result is cached: the driver is queried once for each combination of all fields except the name.
    rhi::MemoryRequirements RequirementsOf(const rhi::TextureDesc& desc);
    rhi::MemoryRequirements RequirementsOf(const rhi::BufferDesc& desc);

    template <typename T>
    struct Placed {
        T object;
        uint64_t lastFrame = 0;  // the last frame that used it
    };

    // Makes block b large enough for blocks[b], for every b. Objects in a block that is replaced are
    // destroyed; returns whether none was. `frame` uses these blocks.
    bool Reserve(std::span<const rhi::MemoryRequirements> blocks, uint64_t frame);
    // Returns an object at the start of a block, for the frame of the last Reserve. The reference is valid
    // until Reserve replaces the block, or Trim frees the object.
    Placed<rhi::Texture>& Place(const rhi::TextureDesc& desc, uint32_t block, uint64_t frame);
    Placed<rhi::Buffer>& Place(const rhi::BufferDesc& desc, uint32_t block, uint64_t frame);
    // Returns a buffer for memory that the CPU writes, which no other frame in flight uses.
    const rhi::Buffer& TakeUpload(const rhi::BufferDesc& desc, uint64_t frame);
    // Frees objects that have not been used for kKeepFrames frames.
    void Trim(uint64_t frame);

  private:
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
