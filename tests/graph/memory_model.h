// Vulkan's memory model for one piece of memory, after the chapter "Synchronization and Cache Control": what
// has been done to it, which later stages that has happened before, and where the last write can be seen.
//
// It knows barriers and accesses and nothing of how the graph plans them. Two things are stricter than
// Vulkan: a stage in a mask stands for itself alone (logically earlier and later stages are not implied), and
// a barrier is told only to the memory that it was planned for, so that each piece has to be guarded by its
// own.
#pragma once

#include <array>
#include <string>
#include <vector>

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

class Memory {
  public:
    // A dependency between all before and all after it.
    void Barrier(const Scope& src, const Scope& dst);
    // The same with a change of layout or owner in between, which writes. Returns what it would race with;
    // empty: nothing.
    std::string Transition(const Scope& src, const Scope& dst, const std::string& who);
    // An access in all of the stages; one that writes may read as well. Both return what is not ordered or
    // visible; empty: all is.
    std::string Read(const Scope& scope, const std::string& who);
    std::string Write(const Scope& scope, const std::string& who);
    // What happened outside, after all that is known, and is visible to these stages by a semaphore.
    void HandedOver(VkPipelineStageFlags2 waitStages, const std::string& who);

  private:
    static constexpr size_t kStageCount = 15;
    // What one access did in one of its stages.
    struct Part {
        VkPipelineStageFlags2 stage = 0;          // 0: a transition, which is in none
        VkPipelineStageFlags2 happensBefore = 0;  // stages whose later work it happens before
        // Of a write:
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
