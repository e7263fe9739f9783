// PassDeclaration: what one setup function declares, filled by PassBuilder. One object serves all passes, so
// that its memory is allocated once. DeclaredPass: what the frame keeps of it. PassMarks: which pass the
// device had reached when it was lost. Threads: that of the Renderer, except for PassMarks::Report.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/graph/frame_graph.h"
#include "renderer/graph/pass_builder.h"
#include "renderer/graph/plan.h"
#include "renderer/graph/program.h"
#include "renderer/graph/renderer.h"
#include "rhi/command_list.h"
#include "rhi/device.h"

namespace raygraph {

enum class BindVerb : uint8_t { Reads, Writes, Updates, Uniform };

// Describes a resource, or a block of uniform data, bound by a name in set 0.
struct DeclaredBinding {
    std::string_view name;                  // lives as long as the frame
    const rhi::Sampler* sampler = nullptr;  // null unless the texture is read through a sampler
    uint32_t resource = kNone;              // index into FrameGraph::resources; kNone: uniform data
    uint32_t use = kNone;                   // index into FrameGraph::uses
    uint32_t uniformOffset = 0;             // offset in the frame's uniform memory
    uint32_t uniformBytes = 0;              // of the data, or of the block that a buffer is bound to
    uint32_t uniformAlignment = 1;
    BindVerb verb = BindVerb::Reads;
    ResourceKind kind = ResourceKind::Buffer;
    // The following fields are set from the shaders by ResolveBindings.
    bool isPart = false;  // a part of a texture, which takes its own view
    rhi::ImageShape shape = rhi::ImageShape::Plain;
    uint32_t binding = 0;
    uint32_t element = 0;  // of an array of resources
    VkDescriptorType type = VK_DESCRIPTOR_TYPE_MAX_ENUM;
    uint32_t addressOffset = 0;  // offset in the uniform block that holds the buffer's address
    bool isAddress = false;      // the buffer is bound by that
};

// States what a device lets a shader bind, in bytes.
struct BindingLimits {
    uint64_t storageBuffer = ~uint64_t{0};
    uint64_t uniformBlock = ~uint64_t{0};
};

// Describes a uniform block with addresses of buffers, which the graph fills.
struct AddressTable {
    uint32_t binding = 0;
    uint32_t bytes = 0;
    uint64_t uniformOffset = 0;  // offset in the frame's uniform memory
};

struct DeclaredColor {
    uint32_t index = 0;
    uint32_t resource = 0;
    ColorLoad load;
    Subresources part;
};

struct PassDeclaration {
    ProgramRequest request;
    std::vector<DeclaredBinding> bindings;
    std::vector<AddressTable> addressTables;
    uint32_t textureSet = kNone;        // index into FrameGraph::resources
    std::vector<DeclaredColor> colors;  // sorted by index when resolved
    uint32_t depth = kNone;             // index into FrameGraph::resources
    DepthLoad depthLoad;
    Subresources depthPart;
    bool hasConstants = false;
    size_t constantAlignment = 1;
    std::vector<std::byte> constants;
    bool isDividable = false;  // what the pass executes covers what CommandList::PortionOf returns
    // The program of the last frame's pass at this position, which is mostly that of this one, too.
    Program* guess = nullptr;
    // The places of the bindings in the shaders' interface. ResolveBindings first tries those that are here.
    std::vector<size_t> places;
    std::vector<uint8_t> isPlaced;  // by binding of the interface: the pass binds it

    void Clear(PassKind kind, Program* lastProgram);
};

// Describes a declared pass of the open frame, whose memory the spans are in.
struct DeclaredPass {
    Program* program = nullptr;  // null: the pass has no shaders
    std::span<const DeclaredBinding> bindings;
    std::span<const AddressTable> addressTables;
    std::span<const DeclaredColor> colors;
    std::span<const std::byte> constants;
    uint32_t textureSet = kNone;  // index into FrameGraph::resources
    uint32_t depth = kNone;       // index into FrameGraph::resources
    DepthLoad depthLoad;
    Subresources depthPart;
    rhi::Portion portion;  // what this frame executes
    PassBody execute;
};

// Declares a use of a resource by the last pass of `graph`, under a name of its shaders. Returns the id after
// the use; the binding is the last of `pass`.
template <ResourceKind Kind>
ResourceId<Kind> AddBinding(FrameGraph& graph, PassDeclaration& pass, std::string_view name,
                            ResourceId<Kind> id, BindVerb verb, Access access,
                            const rhi::Sampler* sampler = nullptr, const Subresources& part = {}) {
    const ResourceId<Kind> after = graph.Use(id, access, part);
    DeclaredBinding& bound = pass.bindings.emplace_back();
    bound.name = graph.Keep(name);
    bound.verb = verb;
    bound.kind = Kind;
    bound.resource = after.resource;
    bound.use = static_cast<uint32_t>(graph.uses.size() - 1);
    bound.sampler = sampler;
    return after;
}

// Checks the last pass of `graph` as declared against the shaders' interface (null: it has no shaders), and
// fills in what the shaders declare: binding numbers, whether a buffer is read as storage or uniform, and
// tables of addresses. Throws Error{Usage} naming the pass, what it asked for and what the shaders have, or
// the limit of the device.
void ResolveBindings(FrameGraph& graph, PassDeclaration& pass, const rhi::ShaderInterface* interface,
                     const BindingLimits& limits = {});
// Checks that the shaders belong to the pass's kind, before they are loaded.
void CheckShaders(const GraphPass& pass, const ProgramRequest& request);
// Sorts the targets of the last pass, checks that they fit together and to the vertex shader and the device,
// and puts their formats into the request.
void ResolveTargets(const FrameGraph& graph, PassDeclaration& pass, bool hasLayeredTargets);

// PassMarks tells which pass the device had reached when it was lost.
//
// Before a pass runs, and once its waits are over, the device writes the frame's number into that pass's
// word of mapped memory. Every pass has one word for each frame in flight, so that no two writes conflict. A
// word with the number tells that everything for which the pass waited has completed.
class PassMarks {
  public:
    static constexpr uint32_t kMaxPasses = 256;  // later passes of a frame leave no mark

    explicit PassMarks(rhi::Device& device);

    // Starts the marks of a frame, whose memory is that of the frame framesInFlight before.
    void BeginFrame(uint64_t number, const FrameGraph& graph, const Plan& plan);
    // Marks the begin of the next pass of the plan. Must be recorded outside of rendering, after the pass's
    // barriers, which must make transfers wait, too.
    void Mark(rhi::CommandList& commands);
    // Returns the last mark of the newest frame that has one, `the last pass reached was pass "Trace" (2 of
    // 3) of frame 12`, or those of both queues; empty if there is none. May be called from any thread.
    std::string Report() const;

  private:
    struct Frame {
        uint64_t number = 0;
        uint32_t passCount = 0;
        std::vector<std::string> passes;     // the first passCount; others keep their memory
        std::vector<rhi::QueueKind> queues;  // by pass
    };
    uint64_t OffsetOf(size_t slot, size_t pass) const {
        return (slot * kMaxPasses + pass) * sizeof(uint32_t);
    }
    static uint32_t ValueOf(uint64_t frame) {
        return static_cast<uint32_t>(frame) + 1;
    }  // never 0, the initial value

    mutable std::mutex m_mutex;
    rhi::Buffer m_words;
    std::vector<Frame> m_frames;  // indexed by slot
    size_t m_slot = 0;
    uint32_t m_marked = 0;  // passes of the current frame
};

}  // namespace raygraph
