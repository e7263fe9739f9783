// PersistentStore: the resources that a Renderer keeps between frames, by name. Threads: that of the
// Renderer.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/graph/renderer.h"

namespace raygraph {

// One persistent resource. The Vulkan object is created when an executed pass first uses it, so that a view
// that is toggled off takes no memory.
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
    void Forget(std::string_view name);
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

}  // namespace raygraph
