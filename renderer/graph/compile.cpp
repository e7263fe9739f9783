#include "renderer/graph/compile.h"

#include <algorithm>
#include <optional>

#include "base/text.h"
#include "renderer/graph/barrier_merge.h"
#include "renderer/graph/memory_plan.h"
#include "renderer/graph/queue_plan.h"
#include "renderer/graph/text.h"

namespace raygraph {

namespace {

// The masks of the readers of a presented texture, and of every possible access by the owner of an exported
// resource.
constexpr AccessMasks kPresentMasks{VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
                                    VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
                                    VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
constexpr AccessMasks kHostReadMasks{VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT,
                                     VK_IMAGE_LAYOUT_UNDEFINED};
constexpr VkPipelineStageFlags2 kOwnerStages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
constexpr VkAccessFlags2 kOwnerAccess = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;

// --- Culling ---

class Culler {
  public:
    Culler(const FrameGraph& graph, CullMemory& memory)
        : m_graph(graph),
          m_isKept(memory.isKept),
          m_isNeeded(memory.isNeeded),
          m_needsHistory(memory.needsHistory) {}

    void Run() {
        m_isKept.assign(m_graph.passes.size(), 0);
        m_needsHistory.assign(m_graph.SubresourceCount(), 0);
        while (MarkKept()) {
        }
    }

  private:
    bool MarkKept();

    const ResourceUse* UsesBegin(const GraphPass& pass) const { return m_graph.uses.data() + pass.firstUse; }
    const ResourceUse* UsesEnd(const GraphPass& pass) const { return UsesBegin(pass) + pass.useCount; }
    void SetNeeded(const ResourceUse& use, uint8_t isNeeded) {
        m_graph.ForEachSubresource(use.resource, use.part,
                                   [&](uint32_t s, auto&&) { m_isNeeded[s] = isNeeded; });
    }
    bool IsNeeded(const ResourceUse& use) const {
        bool isNeeded = false;
        m_graph.ForEachSubresource(use.resource, use.part,
                                   [&](uint32_t s, auto&&) { isNeeded = isNeeded || m_isNeeded[s]; });
        return isNeeded;
    }

    const FrameGraph& m_graph;
    std::vector<uint8_t>& m_isKept;
    std::vector<uint8_t>& m_isNeeded;
    std::vector<uint8_t>& m_needsHistory;
};

// Goes from the last pass to the first. Returns true if it has found a persistent resource whose earlier
// contents a kept pass needs: then its last write is needed, too, and the traversal has to be repeated.
bool Culler::MarkKept() {
    m_isNeeded.assign(m_graph.SubresourceCount(), 0);
    for (const Root& root : m_graph.roots)
        m_graph.ForEachSubresource(root.resource, [&](uint32_t s, auto&&) { m_isNeeded[s] = 1; });
    const auto forEachPersistent = [&](auto&& visit) {
        for (uint32_t r = 0; r < m_graph.resources.size(); ++r)
            if (m_graph.resources[r].origin == Origin::Persistent)
                m_graph.ForEachSubresource(
                    r, [&](uint32_t s, auto&&) { visit(m_graph.resources[r].persistence, s); });
    };
    forEachPersistent([&](Persistence persistence, uint32_t s) {
        if (persistence == Persistence::Always || m_needsHistory[s]) m_isNeeded[s] = 1;
    });
    for (size_t p = m_graph.passes.size(); p-- > 0;) {
        const GraphPass& pass = m_graph.passes[p];
        if (pass.waits) continue;
        bool isKept = pass.keepAlive;
        for (auto use = UsesBegin(pass); use != UsesEnd(pass); ++use)
            isKept = isKept || (Writes(use->access) && IsNeeded(*use));
        m_isKept[p] = isKept;
        if (!isKept) continue;
        for (auto use = UsesBegin(pass); use != UsesEnd(pass); ++use) SetNeeded(*use, 0);
        for (auto use = UsesBegin(pass); use != UsesEnd(pass); ++use)
            if (PreservesContents(m_graph.resources[use->resource].kind, use->access)) SetNeeded(*use, 1);
    }
    bool isChanged = false;
    forEachPersistent([&](Persistence, uint32_t s) {
        if (!m_isNeeded[s] || m_needsHistory[s]) return;
        m_needsHistory[s] = 1;
        isChanged = true;
    });
    return isChanged;
}

// --- The plan ---

// Families of the device need no transfer of what they share. Queues outside of it do: their family takes it
// from no family then (VUID-VkBufferMemoryBarrier2-buffer-04088, VUID-VkImageMemoryBarrier2-image-04071).
bool IsTransferred(const GraphResource& resource, uint32_t family) {
    return !resource.isShared || family == VK_QUEUE_FAMILY_EXTERNAL || family == VK_QUEUE_FAMILY_FOREIGN_EXT;
}

class Compiler {
  public:
    Compiler(const FrameGraph& graph, Plan& plan, CompileMemory& memory)
        : m_graph(graph), m_plan(plan), m_memory(memory), m_blockUses(memory.blockUses) {}

    void Run() {
        m_plan.Clear();
        CheckRoots();
        Cull();
        PlanQueues(m_graph, m_plan);
        FindLifetimes();
        PlanMemory(m_graph, m_plan, m_memory.blocks);
        PlanBarriers();
    }

  private:
    void CheckRoots() const;
    void Cull();
    void FindLifetimes();
    void PlanBarriers();
    void StartStates();
    ResourceState Guarded(const GraphResource& resource, ResourceState state) const;
    uint32_t OwnerAmongUs(const GraphResource& resource) const;
    void Acquire();
    ResourceState LeaveBlock(uint32_t block);
    void EnterBlock(uint32_t resource);
    void PlanPass(uint32_t position);
    ResourceState& StateFor(uint32_t number);
    PlannedBarrier PlanOnQueue(uint32_t resource, uint32_t number, const Subresources& part,
                               const AccessRequest& request);
    void ReturnToMain();
    void PlanReleases();
    std::optional<AccessRequest> RequestOf(const GraphPass& pass, const ResourceUse* first,
                                           const Subresources& subresource) const;
    void PlanWhole(uint32_t resource, const AccessRequest& request);
    void UniteImports();
    void Finish();

    const ResourceUse* UsesBegin(const GraphPass& pass) const { return m_graph.uses.data() + pass.firstUse; }
    const ResourceUse* UsesEnd(const GraphPass& pass) const { return UsesBegin(pass) + pass.useCount; }
    uint32_t BarrierCount() const { return static_cast<uint32_t>(m_plan.barriers.size()); }
    bool HasTwoQueues() const { return m_plan.batches.size() > 1; }
    rhi::QueueKind Queue() const { return m_plan.batches[m_batch].queue; }
    uint32_t FamilyOf(rhi::QueueKind queue) const {
        return queue == rhi::QueueKind::Compute ? m_graph.computeFamily : m_graph.queueFamily;
    }
    std::vector<ResourceState>& StatesOn(rhi::QueueKind queue) {
        return queue == rhi::QueueKind::Compute ? m_memory.computeStates : m_plan.states;
    }
    // Returns one state for all subresources of a resource.
    ResourceState StateOf(uint32_t resource) {
        if (m_graph.resources[resource].SubresourceCount() == 1) return m_plan.states[resource];
        std::vector<ResourceState>& states = m_memory.states;
        states.clear();
        m_graph.ForEachSubresource(resource, [&](uint32_t s, auto&&) { states.push_back(m_plan.states[s]); });
        return Merged(states);
    }
    void SetState(uint32_t resource, const ResourceState& state) {
        m_graph.ForEachSubresource(resource, [&](uint32_t s, auto&&) { m_plan.states[s] = state; });
    }

    const FrameGraph& m_graph;
    Plan& m_plan;
    CompileMemory& m_memory;
    std::vector<CompileMemory::BlockUse>& m_blockUses;
    uint32_t m_batch = 0;  // the one that is being planned
};

void Compiler::CheckRoots() const {
    for (const Root& root : m_graph.roots) {
        const GraphResource& resource = m_graph.resources[root.resource];
        if (root.version == resource.version) continue;
        const char* what = root.kind == RootKind::Presented  ? "presented"
                           : root.kind == RootKind::Exported ? "exported"
                                                             : "read back";
        throw MakeError(ErrorKind::Usage,
                        "{} was {} and written again later in the frame: its contents at the end of the "
                        "frame are not those that were meant",
                        Quoted(resource.name), what);
    }
}

void Compiler::Cull() {
    Culler(m_graph, m_memory.culling).Run();
    const std::vector<uint8_t>& isKept = m_memory.culling.isKept;
    m_plan.passes.reserve(m_graph.passes.size());
    for (uint32_t p = 0; p < m_graph.passes.size(); ++p) {
        if (isKept[p])
            m_plan.passes.push_back({.pass = p, .barriers = {}});
        else
            m_plan.culled.push_back(p);
    }
}

void Compiler::FindLifetimes() {
    m_plan.lifetimes.assign(m_graph.resources.size(), {});
    for (uint32_t position = 0; position < m_plan.passes.size(); ++position) {
        const GraphPass& pass = m_graph.passes[m_plan.passes[position].pass];
        for (auto use = UsesBegin(pass); use != UsesEnd(pass); ++use) {
            Lifetime& lifetime = m_plan.lifetimes[use->resource];
            lifetime.first = std::min(lifetime.first, position);
            lifetime.last = position;
        }
    }
    for (const PlannedBatch& batch : m_plan.batches) {
        if (batch.queue != rhi::QueueKind::Compute) continue;
        for (uint32_t position = batch.firstPass; position < batch.firstPass + batch.passCount; ++position) {
            const GraphPass& pass = m_graph.passes[m_plan.passes[position].pass];
            for (auto use = UsesBegin(pass); use != UsesEnd(pass); ++use)
                m_plan.lifetimes[use->resource].isConcurrent = true;
        }
    }
    // The roots of the frame are in use until after its last pass.
    for (const Root& root : m_graph.roots) {
        Lifetime& lifetime = m_plan.lifetimes[root.resource];
        if (lifetime.IsUsed()) lifetime.last = static_cast<uint32_t>(m_plan.passes.size());
    }
}

// Returns the state of a resource of the host, guarded by the frame's semaphores. No transition may precede
// the wait. Where only some stages wait, accesses in other stages, reads included, follow after those: the
// host may have written what an earlier frame has read.
ResourceState Compiler::Guarded(const GraphResource& resource, ResourceState state) const {
    if (resource.origin != Origin::Imported || m_graph.waitStages == VK_PIPELINE_STAGE_2_NONE) return state;
    const bool allWait = (m_graph.waitStages & VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT) != 0;
    if (resource.kind != ResourceKind::Texture && allWait) return state;
    const bool isRead = state.readStages != VK_PIPELINE_STAGE_2_NONE;
    if (isRead) state.readStages |= m_graph.waitStages;
    if (!isRead || !allWait) state.writeStages |= m_graph.waitStages;
    if (allWait) return state;
    state.visibleStages = VK_PIPELINE_STAGE_2_NONE;
    state.visibleAccess = VK_ACCESS_2_NONE;
    return state;
}

// Initializes the states, in the order of the subresources' numbers.
void Compiler::StartStates() {
    const auto start = [&](const GraphResource& resource, const ResourceState& state) {
        m_plan.states.push_back(resource.origin == Origin::Transient ? ResourceState{}
                                                                     : Guarded(resource, state));
    };
    m_plan.states.reserve(m_graph.SubresourceCount());
    for (const GraphResource& resource : m_graph.resources) start(resource, resource.state);
    if (m_graph.SubresourceCount() == m_graph.resources.size()) return;
    for (const GraphResource& resource : m_graph.resources)
        for (uint32_t other = 1; other < resource.SubresourceCount(); ++other)
            start(resource, resource.hasOtherStates ? m_graph.otherStates[resource.firstOther + other - 1]
                                                    : resource.state);
}

void Compiler::PlanBarriers() {
    StartStates();
    // A block that this frame does not use keeps its state for a later one.
    m_plan.blockStates = m_graph.blockStates;
    m_plan.blockStates.resize(std::max(m_graph.blockStates.size(), m_plan.blocks.size()));
    m_blockUses.assign(m_plan.blocks.size(), {});

    if (HasTwoQueues()) {
        m_memory.computeStates.assign(m_plan.states.size(), {});
        m_memory.queueUses.assign(m_plan.states.size(), {});
        m_memory.releases.clear();
    }
    Acquire();
    for (m_batch = 0; m_batch < m_plan.batches.size(); ++m_batch) {
        const PlannedBatch& batch = m_plan.batches[m_batch];
        for (uint32_t position = batch.firstPass; position < batch.firstPass + batch.passCount; ++position)
            PlanPass(position);
    }
    m_batch = static_cast<uint32_t>(m_plan.batches.size()) - 1;
    Finish();
    if (HasTwoQueues()) PlanReleases();
}

// --- Two queues: what one has done is complete and visible when a batch of the other has waited for it ---

// Returns the state of a subresource for the queue that is being planned.
ResourceState& Compiler::StateFor(uint32_t number) {
    if (!HasTwoQueues()) return m_plan.states[number];
    CompileMemory::QueueUse& use = m_memory.queueUses[number];
    ResourceState& state = StatesOn(Queue())[number];
    if (use.changedOn != Queue() && !use.isSynchronized) {
        state = {.writeStages = kOwnerStages,
                 .visibleStages = ~VkPipelineStageFlags2{0},
                 .visibleAccess = ~VkAccessFlags2{0},
                 .layout = StatesOn(use.changedOn)[number].layout,
                 .queueFamily = m_plan.states[number].queueFamily};
        use.isSynchronized = true;
    }
    return state;
}

// Plans an access by the queue that is being planned. A subresource that the queues do not share is
// transferred to the family of this one, unless its contents are not needed.
PlannedBarrier Compiler::PlanOnQueue(uint32_t resource, uint32_t number, const Subresources& part,
                                     const AccessRequest& request) {
    PlannedBarrier barrier{.resource = resource, .part = part};
    Dependency& dependency = barrier.dependency;
    ResourceState& state = StateFor(number);
    dependency = PlanAccess(state, request);
    if (!HasTwoQueues()) return barrier;

    CompileMemory::QueueUse& use = m_memory.queueUses[number];
    const rhi::QueueKind source = use.changedOn;
    const GraphResource& info = m_graph.resources[resource];
    const bool moves = !info.isShared && FamilyOf(source) != FamilyOf(Queue());
    const bool hasContents =
        info.kind != ResourceKind::Texture || dependency.oldLayout != VK_IMAGE_LAYOUT_UNDEFINED;
    if (moves && request.needsContents && hasContents) {
        barrier.srcQueueFamily = FamilyOf(source);
        barrier.dstQueueFamily = FamilyOf(Queue());
        dependency.isNeeded = true;
        PlannedBarrier release = barrier;
        release.dependency.srcStages = kOwnerStages;
        release.dependency.srcAccess = kOwnerAccess;
        release.dependency.dstStages = VK_PIPELINE_STAGE_2_NONE;
        release.dependency.dstAccess = VK_ACCESS_2_NONE;
        m_memory.releases.push_back({use.lastBatch[IndexOf(source)], release});
        dependency.srcStages = kOwnerStages;
        dependency.srcAccess = VK_ACCESS_2_NONE;
        dependency.dstStages = request.masks.stages;
        dependency.dstAccess = request.masks.access;
        if (!request.writes) {  // the transfer counts as a write that only this access sees yet
            state.writeStages = request.masks.stages;
            state.visibleStages = request.masks.stages;
            state.visibleAccess = request.masks.access;
        }
    }
    if (moves && !request.needsContents && info.kind == ResourceKind::Texture) {
        // The family gets an image whose contents it does not need by a transition that discards them.
        dependency.oldLayout = VK_IMAGE_LAYOUT_UNDEFINED;
        dependency.dstStages = request.masks.stages;
        dependency.dstAccess = request.masks.access;
        dependency.isNeeded = true;
    }
    // Without an access by this queue since, the batch has waited for all, in all stages: only transitions
    // and transfers need a barrier, which follows that wait by any stage of it.
    if (source != Queue() && dependency.srcStages == kOwnerStages) {
        const bool transfers = barrier.srcQueueFamily != barrier.dstQueueFamily;
        dependency.isNeeded = transfers || dependency.oldLayout != dependency.newLayout;
        dependency.srcStages = request.masks.stages;
    }
    // Reads by the other queue are in no state of this one, and what waits for nothing would not follow the
    // semaphore that tells of them.
    const rhi::QueueKind other =
        Queue() == rhi::QueueKind::Compute ? rhi::QueueKind::Main : rhi::QueueKind::Compute;
    if (dependency.isNeeded && dependency.srcStages == VK_PIPELINE_STAGE_2_NONE &&
        use.lastBatch[IndexOf(other)] > 0)
        dependency.srcStages = request.masks.stages;
    use.lastBatch[IndexOf(Queue())] = m_batch;
    if (moves || request.writes || dependency.oldLayout != dependency.newLayout) {
        use.changedOn = Queue();
        use.isSynchronized = false;
    }
    return barrier;
}

// The frame ends on the main queue, which then owns all that outlives it.
void Compiler::ReturnToMain() {
    m_plan.regain.first = BarrierCount();
    for (uint32_t r = 0; r < m_graph.resources.size(); ++r) {
        const GraphResource& resource = m_graph.resources[r];
        m_graph.ForEachSubresource(r, [&](uint32_t number, const Subresources& one) {
            ResourceState& state = StateFor(number);
            // A later frame follows the semaphore for which this one has waited by any stage.
            if (m_memory.queueUses[number].lastBatch[IndexOf(rhi::QueueKind::Compute)] > 0 &&
                (state.readStages | state.writeStages) == VK_PIPELINE_STAGE_2_NONE)
                state.readStages = kOwnerStages;
            const rhi::QueueKind source = m_memory.queueUses[number].changedOn;
            if (resource.isShared || resource.origin == Origin::Transient ||
                FamilyOf(source) == FamilyOf(Queue()))
                return;
            const PlannedBarrier barrier =
                PlanOnQueue(r, number, one, {.masks = {kOwnerStages, kOwnerAccess, state.layout}});
            if (barrier.dependency.isNeeded) m_plan.barriers.push_back(barrier);
        });
    }
    m_plan.regain.count = BarrierCount() - m_plan.regain.first;
}

void Compiler::PlanReleases() {
    for (uint32_t b = 0; b < m_plan.batches.size(); ++b) {
        BarrierRange& range = m_plan.batches[b].release;
        range.first = BarrierCount();
        for (const CompileMemory::Release& release : m_memory.releases)
            if (release.batch == b) m_plan.barriers.push_back(release.barrier);
        range.count = BarrierCount() - range.first;
    }
}

uint32_t Compiler::OwnerAmongUs(const GraphResource& resource) const {
    return resource.isShared ? VK_QUEUE_FAMILY_IGNORED : m_graph.queueFamily;
}

void Compiler::Acquire() {
    m_plan.acquire.first = BarrierCount();
    for (uint32_t r = 0; r < m_graph.resources.size(); ++r) {
        ResourceState state = m_plan.states[r];  // an import has one state for all subresources
        if (state.queueFamily == VK_QUEUE_FAMILY_IGNORED) continue;
        const auto isRootOf = [&](const Root& root) { return root.resource == r; };
        if (!m_plan.lifetimes[r].IsUsed() &&
            std::none_of(m_graph.roots.begin(), m_graph.roots.end(), isRootOf))
            continue;
        const GraphResource& resource = m_graph.resources[r];
        const bool isForeign = state.queueFamily != m_graph.queueFamily;
        if (isForeign && resource.kind != ResourceKind::Texture && resource.kind != ResourceKind::Buffer)
            throw MakeError(ErrorKind::Usage,
                            "{}, a {}, comes from queue family {}: what crosses is the buffer that holds it",
                            Quoted(resource.name), Name(resource.kind), state.queueFamily);
        if (isForeign && IsTransferred(resource, state.queueFamily)) {
            m_plan.barriers.push_back({.resource = r,
                                       .part = resource.Whole(),
                                       .dependency = {.srcStages = kOwnerStages,
                                                      .dstStages = kOwnerStages,
                                                      .dstAccess = kOwnerAccess,
                                                      .oldLayout = state.layout,
                                                      .newLayout = state.layout,
                                                      .isNeeded = true},
                                       .srcQueueFamily = state.queueFamily,
                                       .dstQueueFamily = OwnerAmongUs(resource)});
            state = {.writeStages = kOwnerStages, .layout = state.layout};
        } else if (isForeign && (state.readStages | state.writeStages) == VK_PIPELINE_STAGE_2_NONE) {
            state.readStages = kOwnerStages;  // what waited for the owner has done so in any stage
        }
        state.queueFamily = m_graph.queueFamily;
        SetState(r, state);
    }
    m_plan.acquire.count = BarrierCount() - m_plan.acquire.first;
}

// Returns the state in which the last occupant leaves the memory, together with all earlier ones.
ResourceState Compiler::LeaveBlock(uint32_t block) {
    ResourceState state = StateOf(m_blockUses[block].occupant);
    AccessMasks& all = m_blockUses[block].access;
    const bool isAlone = all.stages == VK_PIPELINE_STAGE_2_NONE;
    all.stages |= state.readStages | state.writeStages;
    all.access |= state.writeAccess;
    if (isAlone) return state;
    state.writeStages = all.stages;
    state.writeAccess = all.access;
    state.readStages = VK_PIPELINE_STAGE_2_NONE;
    return state;
}

// Gives a transient the state of its memory, without the layout.
void Compiler::EnterBlock(uint32_t resource) {
    const uint32_t block = m_plan.lifetimes[resource].block;
    if (block == kNone) return;
    CompileMemory::BlockUse& use = m_blockUses[block];
    ResourceState state;
    use.predecessor = use.occupant;
    if (use.predecessor == kNone) {
        state = m_plan.blockStates[block];
        use.followsLastFrame = state != ResourceState{};
    } else {
        state = LeaveBlock(block);
        use.followsLastFrame = false;
    }
    // Visibility of the old contents does not apply to the new resource.
    state.visibleStages = VK_PIPELINE_STAGE_2_NONE;
    state.visibleAccess = VK_ACCESS_2_NONE;
    state.layout = VK_IMAGE_LAYOUT_UNDEFINED;
    SetState(resource, state);
    use.occupant = resource;
}

// Returns the access of a pass to one subresource, given the uses from `first` on; nullopt if there is none.
std::optional<AccessRequest> Compiler::RequestOf(const GraphPass& pass, const ResourceUse* first,
                                                 const Subresources& subresource) const {
    const ResourceKind kind = m_graph.resources[first->resource].kind;
    AccessRequest request{.writes = false, .needsContents = false};
    bool isUsed = false;
    for (auto use = first; use != UsesEnd(pass); ++use) {
        if (use->resource != first->resource || !rhi::Overlap(use->part, subresource)) continue;
        const AccessMasks masks = MasksFor(pass.kind, use->access);
        request.masks.stages |= masks.stages;
        request.masks.access |= masks.access;
        if (kind == ResourceKind::Texture) request.masks.layout = masks.layout;
        request.writes = request.writes || Writes(use->access);
        request.needsContents = request.needsContents || PreservesContents(kind, use->access);
        isUsed = true;
    }
    return isUsed ? std::optional(request) : std::nullopt;
}

void Compiler::PlanPass(uint32_t position) {
    PlannedPass& planned = m_plan.passes[position];
    const GraphPass& pass = m_graph.passes[planned.pass];
    planned.barriers.first = BarrierCount();
    for (auto use = UsesBegin(pass); use != UsesEnd(pass); ++use) {
        const uint32_t r = use->resource;
        const auto isSame = [&](const ResourceUse& other) { return other.resource == r; };
        if (std::any_of(UsesBegin(pass), use, isSame)) continue;  // planned with the first use
        const ResourceKind kind = m_graph.resources[r].kind;
        if (kind == ResourceKind::TextureSet) continue;  // its owner orders it

        const Lifetime& lifetime = m_plan.lifetimes[r];
        if (lifetime.first == position) EnterBlock(r);
        const size_t first = m_plan.barriers.size();
        m_graph.ForEachSubresource(r, [&](uint32_t number, const Subresources& one) {
            const std::optional<AccessRequest> request = RequestOf(pass, use, one);
            if (!request) return;
            const ResourceState& state = StateFor(number);
            // Other subresources of the texture may have been used before this one.
            const bool isFirstUse = lifetime.first == position || (kind == ResourceKind::Texture &&
                                                                   state.layout == VK_IMAGE_LAYOUT_UNDEFINED);
            PlannedBarrier barrier = PlanOnQueue(r, number, one, *request);
            if (!barrier.dependency.isNeeded) return;
            if (isFirstUse && lifetime.block != kNone) {
                barrier.predecessor = m_blockUses[lifetime.block].predecessor;
                barrier.followsLastFrame = m_blockUses[lifetime.block].followsLastFrame;
            }
            AddBarrier(m_plan.barriers, first, barrier);
        });
        MergeLayers(m_plan.barriers, first);
    }
    planned.barriers.count = BarrierCount() - planned.barriers.first;
}

void Compiler::PlanWhole(uint32_t resource, const AccessRequest& request) {
    const size_t first = m_plan.barriers.size();
    m_graph.ForEachSubresource(resource, [&](uint32_t number, const Subresources& one) {
        AddBarrier(m_plan.barriers, first, PlanOnQueue(resource, number, one, request));
    });
    MergeLayers(m_plan.barriers, first);
}

// The owner of an import knows one state for all of it, with one layout: that of the first subresource that
// has a layout.
void Compiler::UniteImports() {
    if (m_graph.SubresourceCount() == m_graph.resources.size()) return;
    for (uint32_t r = 0; r < m_graph.resources.size(); ++r) {
        const GraphResource& resource = m_graph.resources[r];
        if (resource.origin != Origin::Imported || resource.SubresourceCount() == 1) continue;
        VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
        bool areAlike = true;
        m_graph.ForEachSubresource(r, [&](uint32_t number, auto&&) {
            const VkImageLayout own = m_plan.states[number].layout;
            areAlike = areAlike && own == m_plan.states[r].layout;
            if (layout == VK_IMAGE_LAYOUT_UNDEFINED) layout = own;
        });
        if (!areAlike) {
            const size_t first = m_plan.barriers.size();
            m_graph.ForEachSubresource(r, [&](uint32_t number, const Subresources& one) {
                if (m_plan.states[number].layout == layout) return;
                const AccessRequest request{.masks = {kOwnerStages, VK_ACCESS_2_MEMORY_READ_BIT, layout}};
                AddBarrier(m_plan.barriers, first, PlanOnQueue(r, number, one, request));
            });
            MergeLayers(m_plan.barriers, first);
        }
        SetState(r, StateOf(r));
    }
}

void Compiler::Finish() {
    if (HasTwoQueues()) ReturnToMain();
    m_plan.finish.first = BarrierCount();
    for (const Root& root : m_graph.roots) {
        const auto isExportOfSame = [&](const Root& other) {
            return other.kind == RootKind::Exported && other.resource == root.resource;
        };
        // A texture that is presented and exported ends in the layout that its owner asked for.
        if (root.kind == RootKind::Presented &&
            std::any_of(m_graph.roots.begin(), m_graph.roots.end(), isExportOfSame))
            continue;
        // A transient that no pass has written has no contents. Contents from the host or from an earlier
        // frame are shown as they are.
        const bool isTransient = m_graph.resources[root.resource].origin == Origin::Transient;
        if (isTransient && !m_plan.lifetimes[root.resource].IsUsed()) continue;
        AccessRequest request{.masks = root.kind == RootKind::Presented ? kPresentMasks : kHostReadMasks};
        if (root.kind == RootKind::Exported) {
            request.masks = {kOwnerStages, kOwnerAccess, root.layout};
            request.writes = true;  // its owner may write it, so that the next frame waits for all accesses
        }
        PlanWhole(root.resource, request);
    }
    UniteImports();
    m_plan.finish.count = BarrierCount() - m_plan.finish.first;

    m_plan.release.first = BarrierCount();
    for (const Root& root : m_graph.roots) {
        if (root.queueFamily == VK_QUEUE_FAMILY_IGNORED || root.queueFamily == m_graph.queueFamily) continue;
        const GraphResource& resource = m_graph.resources[root.resource];
        if (!IsTransferred(resource, root.queueFamily)) {
            ResourceState state = StateOf(root.resource);
            state.queueFamily = root.queueFamily;
            SetState(root.resource, state);
            continue;
        }
        m_plan.barriers.push_back({.resource = root.resource,
                                   .part = resource.Whole(),
                                   .dependency = {.srcStages = kOwnerStages,
                                                  .srcAccess = kOwnerAccess,
                                                  .oldLayout = root.layout,
                                                  .newLayout = root.layout,
                                                  .isNeeded = true},
                                   .srcQueueFamily = OwnerAmongUs(resource),
                                   .dstQueueFamily = root.queueFamily});
        SetState(root.resource, {.layout = root.layout, .queueFamily = root.queueFamily});
    }
    m_plan.release.count = BarrierCount() - m_plan.release.first;

    for (uint32_t b = 0; b < m_plan.blocks.size(); ++b)
        if (m_blockUses[b].occupant != kNone) m_plan.blockStates[b] = LeaveBlock(b);
}

}  // namespace

void Compile(const FrameGraph& graph, Plan& plan, CompileMemory& memory) {
    Compiler(graph, plan, memory).Run();
}

Plan Compile(const FrameGraph& graph) {
    Plan plan;
    CompileMemory memory;
    Compile(graph, plan, memory);
    return plan;
}

}  // namespace raygraph
