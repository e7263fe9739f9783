// Random frames: a renderer's life without a device. Persistent and imported resources come and go from frame
// to frame with the states that the plans leave; owners use what is exported to them; passes of every kind do
// what the graph lets them do.
#pragma once

#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/graph/frame_graph.h"
#include "renderer/graph/plan.h"
#include "tests/graph/oracle.h"

namespace raygraph {

class RandomFrames {
  public:
    // `oracle` is told what owners do, from the beginning on. With a compute queue, some passes ask for it.
    RandomFrames(uint64_t seed, oracle::Oracle& oracle, bool hasComputeQueue = false);

    // Declares the next frame.
    const FrameGraph& Declare();
    // The frame was executed as planned: what it leaves is where the next one starts.
    void Commit(const Plan& plan, oracle::Oracle& oracle);

  private:
    enum class Owner : uint8_t {
        Graph,    // nobody else uses it
        Queue,    // a host on the same queue, with barriers of its own
        Signals,  // a host on another queue, with semaphores
    };
    // A persistent or imported resource.
    struct Kept {
        std::string name;
        GraphResource resource;  // without its name
        std::vector<ResourceState> otherStates = {};
        Owner owner = Owner::Graph;
        uint32_t family = VK_QUEUE_FAMILY_IGNORED;  // of an owner that signals
        uint32_t index = kNone;                     // in the frame
    };

    uint32_t Below(uint32_t count) { return static_cast<uint32_t>(m_random() % count); }
    bool Chance(uint32_t percent) { return Below(100) < percent; }
    GraphResource Transient(std::string_view name);
    void MakeParts(GraphResource& texture);
    Subresources PartOf(const GraphResource& texture);
    void AddKept(ResourceKind kind, Origin origin);
    void UseAsOwner(Kept& kept, oracle::Oracle& oracle);
    uint32_t Add(const GraphResource& resource, std::span<const ResourceState> otherStates = {});
    bool Use(uint32_t resource, Access access);
    void AddPass(uint32_t number);
    void AddRoots();
    void ReadOnHost(uint32_t resource);

    std::mt19937_64 m_random;
    bool m_hasComputeQueue;
    VkPipelineStageFlags2 m_waitStages = 0;
    std::vector<Kept> m_kept;
    FrameGraph m_graph;
    uint64_t m_frame = 0;
};

}  // namespace raygraph
