// FrameGraph: one frame as plain data: resources, passes and the uses of each pass. Needs no device and makes
// no vk* call.
//
// The Renderer fills one from AddPass and compiles it; tests and tools write them by hand, and plan_text.h
// describes them. A pass may only use the newest version of a resource, so the order of declaration is an
// order of execution and the graph has no cycles. Threads: plain values and pure functions, for any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/api.h"
#include "base/arena.h"
#include "renderer/graph/access.h"
#include "renderer/graph/ids.h"
#include "rhi/format.h"
#include "rhi/resources.h"
#include "rhi/submission.h"
#include "rhi/vulkan.h"

namespace raygraph {

// Textures are used whole, or by levels and layers.
using rhi::Layer;
using rhi::Layers;
using rhi::Level;
using rhi::Levels;
using rhi::Subresource;
using rhi::Subresources;

enum class Origin : uint8_t {
    Transient,   // its contents live within the frame
    Persistent,  // the Renderer keeps it between frames
    Imported,    // owned by the caller
};
RAYGRAPH_API const char* Name(Origin origin);

// The condition under which a write to a persistent resource keeps its pass alive.
enum class Persistence : uint8_t {
    // If something shown in this frame uses its contents: toggling a view off stops its accumulation.
    OnDemand,
    // accumulation
    Always,  // in every frame that declares it
};

struct GraphResource {
    std::string_view name;  // FrameGraph::Add copies it; that copy has a zero after it
    ResourceKind kind = ResourceKind::Texture;
    Origin origin = Origin::Transient;
    Persistence persistence = Persistence::OnDemand;
    bool isHostWritten = false;  // the CPU fills it, so that a pass may read it without an earlier write
    // All queues can access it without a transfer of ownership between their families: its sharing mode is
    // concurrent, or becomes so where the plan needs that.
    bool isShared = true;
    rhi::Extent2D extent{};  // textures
    rhi::Format format = rhi::Format::Undefined;
    uint32_t levels = 1;
    uint32_t layers = 1;
    uint64_t bytes = 0;                // buffers
    rhi::MemoryRequirements memory{};  // requirements of a transient; size 0: it shares no memory
    ResourceState state{};             // before the frame; unused for transients
    uint32_t version = 0;              // number of writes declared so far
    // Set by FrameGraph for a texture with several subresources:
    // Number of the second subresource, counted from the last resource on.
    uint32_t firstOther = 0;
    uint32_t firstFilled = 0;     // its subresources, layer by layer, are FrameGraph::isFilled from here on
    bool hasOtherStates = false;  // `state` is that of the first subresource alone (FrameGraph::otherStates)

    bool operator==(const GraphResource&) const = default;
    uint32_t SubresourceCount() const { return levels * layers; }
    Subresources Whole() const { return {.levelCount = levels, .layerCount = layers}; }
};

// Describes one access of one resource by one pass.
struct ResourceUse {
    uint32_t resource = 0;
    uint32_t versionIn = 0;
    uint32_t versionOut = 0;  // versionIn + 1 for a write
    Access access = Access::Sampled;
    Subresources part = {.levelCount = 1, .layerCount = 1};  // resolved

    bool operator==(const ResourceUse&) const = default;
};

struct GraphPass {
    std::string_view name;  // as GraphResource::name
    PassKind kind = PassKind::Compute;
    rhi::QueueKind queue = rhi::QueueKind::Main;  // Compute: it may run beside others, where it can
    bool keepAlive = false;                       // the pass has an effect that the graph does not see
    bool waits = false;     // not executed in this frame, whatever needs it (PassSeries)
    uint32_t firstUse = 0;  // its uses are [firstUse, firstUse + useCount) of FrameGraph::uses
    uint32_t useCount = 0;

    bool operator==(const GraphPass&) const = default;
};

enum class RootKind : uint8_t {
    Presented,  // shown: left for sampling by fragment shaders
    Exported,   // handed back to its owner
    HostRead,   // read by the CPU once the frame has completed
};

// Describes a result of the frame that must be produced.
struct Root {
    RootKind kind = RootKind::Presented;
    uint32_t resource = 0;
    uint32_t version = 0;
    VkImageLayout layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    // If not the family of the frame: ownership is released to this family.
    uint32_t queueFamily = VK_QUEUE_FAMILY_IGNORED;

    bool operator==(const Root&) const = default;
};

// Is a ResourceId without its type, small enough for a register.
struct AnyId {
    uint16_t resource = 0;
    uint16_t version = 0;
    uint8_t frame = 0;
    ResourceKind kind = ResourceKind::Texture;
    bool isValid = false;

    AnyId() = default;
    template <ResourceKind Kind>
    AnyId(ResourceId<Kind> id)  // NOLINT(google-explicit-constructor)
        : resource(id.resource), version(id.version), frame(id.frame), kind(Kind), isValid(id.IsValid()) {}
};

struct RAYGRAPH_API FrameGraph {
    uint64_t frame = 0;
    uint32_t queueFamily = 0;  // family of the main queue, on which the frame begins and ends
    uint32_t computeFamily = VK_QUEUE_FAMILY_IGNORED;  // family of the compute queue; IGNORED: there is none
    VkPipelineStageFlags2 waitStages = 0;              // stages of the semaphores that the frame waits for
    std::vector<GraphResource> resources;
    std::vector<GraphPass> passes;  // in order of declaration
    std::vector<ResourceUse> uses;
    std::vector<Root> roots;
    // The states in which the last frame left each block of transient memory.
    std::vector<ResourceState> blockStates;
    // Both are for textures with several subresources. By number, from that of the first one after the last
    // resource on: the state before the frame, where the resource has others than its own.
    std::vector<ResourceState> otherStates;
    std::vector<uint8_t> isFilled;  // by GraphResource::firstFilled: the subresource has contents

    // Empties the graph for the next frame; keeps the queue families, blockStates and memory.
    void Begin(uint64_t frameNumber);
    // Returns whether Compile makes the same plan of both, for which resources and passes of the same names
    // are declared alike.
    bool HasSamePlanAs(const FrameGraph& other) const;

    // `others` are the states before the frame of all subresources but the first, layer by layer; if
    // empty, they are in GraphResource::state.
    template <ResourceKind Kind>
    ResourceId<Kind> Add(const GraphResource& resource, std::span<const ResourceState> others = {}) {
        return IdOf<Kind>(AddResource(resource, Kind, others));
    }
    // Returns the id of the newest version.
    template <ResourceKind Kind>
    ResourceId<Kind> IdOf(uint32_t resource) const {
        using Id = ResourceId<Kind>;
        return {.resource = resource & Id::kInvalid,
                .version = resources[resource].version & Id::kMaxVersion,
                .frame = static_cast<uint32_t>(frame) & Id::kFrameMask};
    }

    // Adds a pass, to which the following uses belong.
    uint32_t AddPass(std::string_view name, PassKind kind);
    // Returns a copy of a text that lives as long as the frame.
    std::string_view Keep(std::string_view text) { return m_texts->Copy(text); }
    // Declares a use by the last pass, and returns the id of the contents after it: the id of the whole
    // texture, even if a part of it is written. Throws Error{Usage} naming the pass and the resource for an
    // id that is empty, of another frame, or stale; for an access that the pass's kind does not have; for a
    // part that the texture does not have; for contents that were never written; and for uses that one pass
    // cannot combine. A pass may read one subresource of a texture and write another.
    template <ResourceKind Kind>
    ResourceId<Kind> Use(ResourceId<Kind> id, Access access, const Subresources& part = {}) {
        return IdOf<Kind>(UseResource(id, access, part));
    }

    // These throw as Use does; `what` names the calling function: "Present".
    void Present(TextureId texture);
    void Export(TextureId texture, VkImageLayout layout, uint32_t toQueueFamily = VK_QUEUE_FAMILY_IGNORED);
    void Export(BufferId buffer, uint32_t toQueueFamily = VK_QUEUE_FAMILY_IGNORED);
    void ReadOnHost(BufferId buffer);
    // Returns the index of a resource of this frame, of which the id must name the newest version.
    uint32_t Resolve(AnyId id, std::string_view what) const;
    // Does the same for an id of any version.
    uint32_t ResolveAnyVersion(AnyId id, std::string_view what) const;

    // All subresources of the declared frame are numbered: the first one of a resource has the index of the
    // resource, and the others, of textures that have several, follow after the last resource.
    uint32_t SubresourceCount() const { return static_cast<uint32_t>(resources.size()) + m_otherCount; }
    // Calls visit(number, subresource) for each subresource of a part, layer by layer.
    template <typename Visit>
    void ForEachSubresource(uint32_t resource, const Subresources& part, Visit&& visit) const {
        if (m_otherCount == 0) {  // so that frames without such textures are not slower
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
    uint32_t AddResource(const GraphResource& resource, ResourceKind kind,
                         std::span<const ResourceState> others);
    uint32_t UseResource(AnyId id, Access access, const Subresources& requested);
    void ExportResource(uint32_t index, VkImageLayout layout, uint32_t toQueueFamily);
    void CheckWithinPass(const GraphPass& pass, const GraphResource& resource, const ResourceUse& earlier,
                         Access access, const Subresources& part) const;

    uint32_t m_otherCount = 0;  // subresources that are not the first of their resource
    // The names. Copies of the graph share it.
    std::shared_ptr<Arena> m_texts = std::make_shared<Arena>();
};

RAYGRAPH_API const char* Name(ResourceKind kind);  // "texture", "buffer", ...
// Returns whether a use preserves some of the earlier contents. Copies into a buffer, writes by address, and
// builds of some structures of a set count as partial. Writes and CopiesTo of a texture, or of a part of it,
// replace the whole of it.
RAYGRAPH_API bool PreservesContents(ResourceKind kind, Access access);

}  // namespace raygraph
