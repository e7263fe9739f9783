// Vulkan's memory model for one piece of memory, after the chapter "Synchronization and Cache Control": what
// has been done to it, which later stages that has happened before, and where the last write can be seen.
//
// It knows barriers and accesses and nothing of how the graph plans them. Two things are stricter than
// Vulkan: a stage in a mask stands for itself alone (logically earlier and later stages are not implied), and
// a barrier is told only to the memory that it was planned for, so that each piece has to be guarded by its
// own.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "renderer/graph/frame_graph.h"
#include "renderer/graph/plan.h"
#include "rhi/vulkan.h"

namespace raygraph::oracle {

// Stages and accesses, with those that stand for several taken apart.
VkPipelineStageFlags2 Expand(VkPipelineStageFlags2 stages);
VkAccessFlags2 ExpandAccess(VkAccessFlags2 access);
// The accesses that write, taken apart.
VkAccessFlags2 WritesOf(VkAccessFlags2 access);

struct Scope {
    VkPipelineStageFlags2 stages = VK_PIPELINE_STAGE_2_NONE;
    VkAccessFlags2 access = VK_ACCESS_2_NONE;
};
// The stages of the compute queue are stages of their own: a barrier on one queue orders nothing on the other.
Scope OnQueue(const Scope& scope, rhi::QueueKind queue);
// The stage between a signal and the waits for it, of which there are this many.
inline constexpr size_t kSemaphoreCount = 16;
VkPipelineStageFlags2 SemaphoreStage(size_t number);

class Memory {
  public:
    // A dependency between all before and all after it.
    void Barrier(const Scope& src, const Scope& dst);
    // Adds a barrier with a change of layout or owner, which writes. Returns what it would race with;
    // empty: nothing.
    std::string Transition(const Scope& src, const Scope& dst, const std::string& who);
    // An access in all of the stages; one that writes may read as well. Both return what is not ordered or
    // visible; empty: all is.
    std::string Read(const Scope& scope, const std::string& who);
    std::string Write(const Scope& scope, const std::string& who);
    // Adds accesses from outside, after all that is known, visible to these stages by a semaphore.
    void HandedOver(VkPipelineStageFlags2 waitStages, const std::string& who);

  private:
    static constexpr size_t kStageCount = 46;  // of both queues, and a stage for each semaphore
    // One access in one of its stages.
    struct Part {
        VkPipelineStageFlags2 stage = 0;          // 0: a transition, which is in none
        VkPipelineStageFlags2 happensBefore = 0;  // stages whose later work it happens before
        // These members are a write's:
        bool isAvailable = false;
        VkPipelineStageFlags2 availableBefore = 0;          // stages whose later work it is available before
        std::array<VkAccessFlags2, kStageCount> visible{};  // accesses that see it, by stage
    };
    struct Event {
        std::string who;
        VkAccessFlags2 writes = 0;
        std::vector<Part> parts;
    };
    static bool IsOrdered(const Part& part, VkPipelineStageFlags2 src);
    static bool IsMadeAvailable(const Event& write, const Part& part, const Scope& src);
    static void MakeVisible(Part& part, const Scope& dst);
    static Event EventOf(const Scope& scope, const std::string& who);
    std::string Invisible(const Scope& expanded, const std::string& who) const;

    std::vector<Event> m_writes;  // the last one; none: the contents never were
    std::vector<Event> m_reads;   // since then
};

}  // namespace raygraph::oracle

// Oracle: judges what Compile plans, frame after frame, without knowing how it plans. It carries a plan out
// on memories of its own (memory_model.h), by the accesses that passes declare (access_table.h), and says
// which access is not ordered, does not see what it needs, finds another layout or other contents, and which
// resources share memory while both live. Each level of each layer of a texture has a layout, contents and an
// equal slice of the texture's memory.
namespace raygraph::oracle {

class Oracle {
  public:
    // Returns what is wrong with the frame's plan, a line each; empty: nothing. Persistent and imported
    // resources are known by their names, transient memory by its block; what they hold stays for the next frame. A copy of
    // an Oracle judges another future.
    std::vector<std::string> Judge(const FrameGraph& graph, const Plan& plan);

    // Between frames, the owner of an imported resource uses it: in that layout, in a pass of that scope on
    // the same queue, after everything that the graph has done with it.
    void OwnerUses(const std::string& name, const Scope& scope, VkImageLayout layout);
    // The owner's use is over when the next frame's semaphores, waited for by these stages, are signaled.
    // The queue family is the one that it has released the resource from, IGNORED: the frame's own.
    void OwnerSignals(const std::string& name, VkPipelineStageFlags2 waitStages, VkImageLayout layout,
                      uint32_t queueFamily);

  private:
    // Part of a memory with what it holds.
    struct Segment {
        uint64_t end = 0;  // of its bytes, the start is the end of the one before
        Memory memory;
        uint64_t contents = 0;  // a number for each write; 0: nothing
    };
    struct Image {
        VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
        uint32_t queueFamily = VK_QUEUE_FAMILY_IGNORED;  // IGNORED: the frame's
    };
    // A texture has both by subresource, layer by layer.
    struct Object {
        std::vector<Segment> segments{1};
        std::vector<Image> images{1};
    };
    struct Frame;

    void JudgeSharing(Frame& frame);
    void PlaceTransients(Frame& frame);
    void FindSpans(Frame& frame);
    void JudgeBatch(Frame& frame, uint32_t index);
    void JudgeBarriers(Frame& frame, const BarrierRange& range, const std::string& before);
    void JudgeRelease(Frame& frame, const PlannedBarrier& barrier);
    // A barrier for all memory that the frame can reach.
    void OrderAll(Frame& frame, const Scope& src, const Scope& dst);
    void JudgeBarrier(Frame& frame, const PlannedBarrier& barrier, const std::string& before);
    void OrderTheRest(Frame& frame, const PlannedBarrier& barrier);
    void JudgePass(Frame& frame, const PlannedPass& planned);
    void JudgeAccess(Frame& frame, const GraphPass& pass, uint32_t first, uint32_t place);
    void JudgeEnd(Frame& frame);
    Object& ObjectOf(Frame& frame, uint32_t resource);
    std::vector<Segment>& AllSegments(Frame& frame, uint32_t resource);
    std::vector<Segment*> Segments(Frame& frame, uint32_t resource, uint32_t place);
    Image& ImageOf(Frame& frame, uint32_t resource, uint32_t place);
    bool HasNewest(Frame& frame, uint32_t resource, uint32_t place);

    std::map<std::string, Object> m_objects;  // persistent and imported
    std::vector<std::vector<Segment>> m_blocks;
    uint64_t m_lastContents = 0;
};

}  // namespace raygraph::oracle
