// TextureTable: the bindless textures, set 1 of every pipeline that declares
//     layout(set = 1, binding = 0) uniform sampler2D textures[];
//
// Threads: Add and Remove may be called from any; the rest is for one at a time.
#pragma once

#include <cstdint>
#include <memory>

#include "base/api.h"
#include "rhi/resources.h"
#include "rhi/vulkan.h"

namespace raygraph::rhi {

// The maximum number of slots of a table; every device with descriptor indexing supports more.
inline constexpr uint32_t kMaxTextureTableSlots = 65536;

// Creates the layout behind Device::TextureTableLayout(): one array of combined image samplers of variable
// size, update after bind. The caller destroys it.
RAYGRAPH_API VkDescriptorSetLayout CreateTextureTableLayout(Device& device);

// A table has slots 0 to capacity - 1. Every slot always holds a texture: a free one holds the default, since
// a driver may fault on an empty one. Textures must be in SHADER_READ_ONLY_OPTIMAL; a texture and its sampler
// outlive their slot, and the defaults outlive the table. Add and Remove may be called from any thread and at
// any time, even while frames that use the table are in flight: a removed slot gets the default, and can be
// reused, only when every frame that could read it has completed.
class RAYGRAPH_API TextureTable {
  public:
    // Throws Error{Usage} if capacity is 0 or above kMaxTextureTableSlots.
    TextureTable(Device& device, uint32_t capacity, const Texture& defaultTexture,
                 const Sampler& defaultSampler);
    // Makes a larger table, independent of `smaller`, in which its textures keep their slots.
    TextureTable(Device& device, uint32_t capacity, const TextureTable& smaller);
    ~TextureTable();
    TextureTable(const TextureTable&) = delete;
    TextureTable& operator=(const TextureTable&) = delete;

    // Returns the slot that now holds the texture. Throws Error{Usage} when the table is full.
    [[nodiscard]] uint32_t Add(const Texture& texture, const Sampler& sampler);
    // The texture may be destroyed right afterwards. Throws Error{Usage} for a slot that holds none.
    void Remove(uint32_t slot);

    VkDescriptorSet Set() const;
    uint32_t Capacity() const;
    uint32_t Count() const;  // slots that hold a texture that was added
    // Returns the number of slots that Add can return now. A removed slot is one of them once no frame can
    // read it any more.
    uint32_t FreeCount() const;

  private:
    struct State;
    void Create(uint32_t capacity);
    std::shared_ptr<State> m_state;  // kept by pending removals as well
};

}  // namespace raygraph::rhi
