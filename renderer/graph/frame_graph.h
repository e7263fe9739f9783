// FrameGraph: one frame as plain data: resources, passes and what each pass uses. Pure: no device, no
// vk* call.
//
// The Renderer fills one from AddPass and compiles it; tests and tools write them by hand, and plan_text.h
// describes them. A pass may only use the newest version of a resource, so the order of declaration is an
// order of execution and the graph has no cycles. Threads: plain values and pure functions, for any thread.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "renderer/graph/access.h"
#include "renderer/graph/ids.h"
#include "rhi/format.h"
#include "rhi/resources.h"
#include "rhi/vulkan.h"

namespace raygraph {

// Parts of textures: the whole, or levels and layers of it.
using rhi::Layer;
using rhi::Layers;
using rhi::Level;
using rhi::Levels;
using rhi::Subresource;
using rhi::Subresources;

enum class Origin : uint8_t {
    Transient,   // lives within the frame
    Persistent,  // the Renderer keeps it between frames
    Imported,    // owned by the caller
};
RAYGRAPH_API const char* Name(Origin origin);

// The condition under which a write to a persistent resource keeps its pass alive.
enum class Persistence : uint8_t {
    OnDemand,  // when something shown in this frame uses its contents: toggling a view off stops its
               // accumulation
    Always,    // in every frame that declares it
};

struct GraphResource {
    std::string name;
    ResourceKind kind = ResourceKind::Texture;
    Origin origin = Origin::Transient;
    Persistence persistence = Persistence::OnDemand;
    bool isHostWritten = false;  // the CPU fills it, so that reading it first is no mistake
    rhi::Extent2D extent{};      // textures
    rhi::Format format = rhi::Format::Undefined;
    uint32_t levels = 1;
    uint32_t layers = 1;
    uint64_t bytes = 0;                // buffers
    rhi::MemoryRequirements memory{};  // for a transient; size 0: it shares no memory
    ResourceState state{};             // before the frame, of its first subresource; unused for transients
    std::vector<ResourceState> otherStates = {};  // of its other ones, layer by layer; empty: as `state`
    uint32_t version = 0;                         // writes declared so far
    // Set by FrameGraph for a texture with several subresources:
    uint32_t firstOther = 0;             // the number of the second one, counted from the last resource on
    std::vector<uint8_t> isFilled = {};  // by subresource, layer by layer: it has contents

    uint32_t SubresourceCount() const { return levels * layers; }
    Subresources Whole() const { return {.levelCount = levels, .layerCount = layers}; }
};

// One access of one resource by one pass.
struct ResourceUse {
    uint32_t resource = 0;
    uint32_t versionIn = 0;
    uint32_t versionOut = 0;  // versionIn + 1 for a write
    Access access = Access::Sampled;
    Subresources part = {.levelCount = 1, .layerCount = 1};  // resolved
};

struct GraphPass {
    std::string name;
    PassKind kind = PassKind::Compute;
    bool keepAlive = false;  // it has an effect that the graph does not see
    uint32_t firstUse = 0;   // its uses are [firstUse, firstUse + useCount) of FrameGraph::uses
    uint32_t useCount = 0;
};

enum class RootKind : uint8_t {
    Presented,  // shown: left for sampling by fragment shaders
    Exported,   // handed back to its owner
    HostRead,   // read by the CPU when the frame has completed
};

// A result of the frame that must be produced.
struct Root {
    RootKind kind = RootKind::Presented;
    uint32_t resource = 0;
    uint32_t version = 0;
    VkImageLayout layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    uint32_t queueFamily = VK_QUEUE_FAMILY_IGNORED;  // other than the frame's: ownership is released to it
};

// A ResourceId without its type.
struct AnyId {
    ResourceKind kind = ResourceKind::Texture;
    uint32_t resource = 0;
    uint32_t version = 0;
    uint32_t frame = 0;
    bool isValid = false;

    AnyId() = default;
    template <ResourceKind Kind>
    AnyId(ResourceId<Kind> id)  // NOLINT(google-explicit-constructor)
        : kind(Kind), resource(id.resource), version(id.version), frame(id.frame), isValid(id.IsValid()) {}
};

struct RAYGRAPH_API FrameGraph {
    uint64_t frame = 0;
    uint32_t queueFamily = 0;              // family of the queue that executes the frame
    VkPipelineStageFlags2 waitStages = 0;  // stages of the semaphores that the frame waits for
    std::vector<GraphResource> resources;
    std::vector<GraphPass> passes;  // in order of declaration
    std::vector<ResourceUse> uses;
    std::vector<Root> roots;
    std::vector<ResourceState>
        blockStates;  // states in which the last frame left each block of transient memory

    // Empties it for the next frame; keeps queueFamily and blockStates.
    void Begin(uint64_t frameNumber);

    template <ResourceKind Kind>
    ResourceId<Kind> Add(GraphResource resource) {
        resource.kind = Kind;
        return IdOf<Kind>(AddResource(std::move(resource)));
    }
    // The id of the newest version.
    template <ResourceKind Kind>
    ResourceId<Kind> IdOf(uint32_t resource) const {
        using Id = ResourceId<Kind>;
        return {.resource = resource & Id::kInvalid,
                .version = resources[resource].version & Id::kMaxVersion,
                .frame = static_cast<uint32_t>(frame) & Id::kFrameMask};
    }

    // Starts a pass: the uses that follow are its own.
    uint32_t AddPass(std::string_view name, PassKind kind);
    // Declares a use by the last pass, and returns the id of the contents after it: of all of the texture, of
    // which a write of a part changes that part. Throws Error{Usage} naming the pass and the resource for an
    // id that is empty, of another frame, or stale, for an access that the pass's kind does not have, for a
    // part that the texture does not have, for contents that were never written, and for uses that one pass
    // cannot combine: it may read one subresource and write another.
    template <ResourceKind Kind>
    ResourceId<Kind> Use(ResourceId<Kind> id, Access access, const Subresources& part = {}) {
        return IdOf<Kind>(UseResource(id, access, part));
    }

    // These throw as Use does; `what` names the calling function: "Present".
    void Present(TextureId texture);
    void Export(TextureId texture, VkImageLayout layout, uint32_t toQueueFamily = VK_QUEUE_FAMILY_IGNORED);
    void Export(BufferId buffer, uint32_t toQueueFamily = VK_QUEUE_FAMILY_IGNORED);
    void ReadOnHost(BufferId buffer);
    // The index of a resource of this frame whose newest version the id names.
    uint32_t Resolve(AnyId id, std::string_view what) const;
    // Resolves an id of any version of the resource.
    uint32_t ResolveAnyVersion(AnyId id, std::string_view what) const;

    // All subresources of the declared frame have a number: the first one of a resource has its index, the
    // others, of textures that have several, follow after the last resource.
    uint32_t SubresourceCount() const { return static_cast<uint32_t>(resources.size()) + m_otherCount; }
    // Calls visit(number, subresource) for each of a part, layer by layer.
    template <typename Visit>
    void ForEachSubresource(uint32_t resource, const Subresources& part, Visit&& visit) const {
        if (m_otherCount == 0) {  // a frame without such textures pays nothing for them
            visit(resource, Subresource(0, 0));
            return;
        }
        const GraphResource& info = resources[resource];
        const uint32_t others = static_cast<uint32_t>(resources.size()) + info.firstOther;
        for (uint32_t layer = part.layer; layer < part.layer + part.layerCount; ++layer)
            for (uint32_t level = part.level; level < part.level + part.levelCount; ++level) {
                const uint32_t place = layer * info.levels + level;
                visit(place == 0 ? resource : others + place - 1, Subresource(level, layer));
            }
    }
    template <typename Visit>
    void ForEachSubresource(uint32_t resource, Visit&& visit) const {
        ForEachSubresource(resource, resources[resource].Whole(), visit);
    }

  private:
    uint32_t AddResource(GraphResource resource);
    uint32_t UseResource(AnyId id, Access access, const Subresources& asked);
    void ExportResource(uint32_t index, VkImageLayout layout, uint32_t toQueueFamily);
    void CheckWithinPass(const GraphPass& pass, const GraphResource& resource, const ResourceUse& earlier,
                         Access access, const Subresources& part) const;

    uint32_t m_otherCount = 0;  // subresources that are not the first of their resource
};

RAYGRAPH_API const char* Name(ResourceKind kind);  // "texture", "buffer", ...
// Returns whether a use leaves some of the earlier contents in place. Copies into a buffer, writes by address
// and builds of some structures of a set count as partial; Writes and CopiesTo of a texture, or of a part of
// it, replace all of that.
RAYGRAPH_API bool PreservesContents(ResourceKind kind, Access access);

}  // namespace raygraph
