// Oracle: judges what Compile plans, frame after frame, without knowing how it plans. It carries a plan out
// on memories of its own (memory_model.h), by the accesses that passes declare (access_table.h), and says
// which access is not ordered, does not see what it needs, finds another layout or other contents, and which
// resources share memory while both live. Each level of each layer of a texture has a layout, contents and an
// equal slice of the texture's memory.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "renderer/graph/frame_graph.h"
#include "renderer/graph/plan.h"
#include "tests/graph/memory_model.h"

namespace raygraph::oracle {

class Oracle {
  public:
    // What is wrong with the frame's plan, a line each; empty: nothing. Persistent and imported resources are
    // known by their names, transient memory by its block; what they hold stays for the next frame. A copy of
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
    // Of a texture, both are by subresource, layer by layer.
    struct Object {
        std::vector<Segment> segments{1};
        std::vector<Image> images{1};
    };
    struct Frame;

    void JudgeSharing(Frame& frame);
    void PlaceTransients(Frame& frame);
    void JudgeBarriers(Frame& frame, const BarrierRange& range, const std::string& before);
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
