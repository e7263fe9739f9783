#include "renderer/graph/compile.h"

#include <algorithm>

#include "base/text.h"
#include "renderer/graph/memory_planner.h"
#include "renderer/graph/text.h"

namespace raygraph {

namespace {

// The readers of a presented texture, and every possible access by the owner of an exported resource.
constexpr AccessMasks kPresentMasks{VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
                                    VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
                                    VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
constexpr AccessMasks kHostReadMasks{VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT,
                                     VK_IMAGE_LAYOUT_UNDEFINED};
constexpr VkPipelineStageFlags2 kOwnerStages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
constexpr VkAccessFlags2 kOwnerAccess = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;

class Compiler {
  public:
    explicit Compiler(const FrameGraph& graph) : m_graph(graph) {}

    Plan Run() {
        CheckRoots();
        Cull();
        FindLifetimes();
        PlanMemory(m_graph, m_plan);
        PlanBarriers();
        return std::move(m_plan);
    }

  private:
    void CheckRoots() const;
    void Cull();
    bool MarkKept(std::vector<uint8_t>& isInDemand);
    void FindLifetimes();
    void PlanBarriers();
    void Acquire();
    ResourceState LeaveBlock(uint32_t block);
    void EnterBlock(uint32_t resource, PlannedBarrier& barrier);
    void PlanPass(uint32_t position);
    void Finish();

    const ResourceUse* UsesBegin(const GraphPass& pass) const { return m_graph.uses.data() + pass.firstUse; }
    const ResourceUse* UsesEnd(const GraphPass& pass) const { return UsesBegin(pass) + pass.useCount; }
    uint32_t BarrierCount() const { return static_cast<uint32_t>(m_plan.barriers.size()); }

    const FrameGraph& m_graph;
    Plan m_plan;
    std::vector<uint8_t> m_isKept;         // by pass
    std::vector<uint32_t> m_lastOccupant;  // by block: the resource that used it last, or kNone
    // By block: the stages and writes of all its occupants so far. An earlier one may reach beyond the last,
    // smaller one.
    std::vector<AccessMasks> m_occupantAccess;
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

// One traversal from the last pass to the first. Returns true if it found a persistent resource whose earlier
// contents a kept pass needs, so that its last write is needed too: then the traversal has to be repeated.
bool Compiler::MarkKept(std::vector<uint8_t>& isInDemand) {
    std::vector<uint8_t> isNeeded(m_graph.resources.size(), 0);
    for (const Root& root : m_graph.roots) isNeeded[root.resource] = 1;
    for (size_t r = 0; r < isNeeded.size(); ++r) {
        const GraphResource& resource = m_graph.resources[r];
        if (resource.origin == Origin::Persistent &&
            (resource.persistence == Persistence::Always || isInDemand[r]))
            isNeeded[r] = 1;
    }
    for (size_t p = m_graph.passes.size(); p-- > 0;) {
        const GraphPass& pass = m_graph.passes[p];
        bool isKept = pass.keepAlive;
        for (auto use = UsesBegin(pass); use != UsesEnd(pass); ++use)
            isKept = isKept || (Writes(use->access) && isNeeded[use->resource]);
        m_isKept[p] = isKept;
        if (!isKept) continue;
        for (auto use = UsesBegin(pass); use != UsesEnd(pass); ++use) isNeeded[use->resource] = 0;
        for (auto use = UsesBegin(pass); use != UsesEnd(pass); ++use)
            if (KeepsEarlierContents(m_graph.resources[use->resource].kind, use->access))
                isNeeded[use->resource] = 1;
    }
    bool isChanged = false;
    for (size_t r = 0; r < isNeeded.size(); ++r) {
        if (m_graph.resources[r].origin != Origin::Persistent || !isNeeded[r] || isInDemand[r]) continue;
        isInDemand[r] = 1;
        isChanged = true;
    }
    return isChanged;
}

void Compiler::Cull() {
    m_isKept.assign(m_graph.passes.size(), 0);
    std::vector<uint8_t> isInDemand(m_graph.resources.size(), 0);
    while (MarkKept(isInDemand)) {
    }
    m_plan.passes.reserve(m_graph.passes.size());
    for (uint32_t p = 0; p < m_graph.passes.size(); ++p) {
        if (m_isKept[p])
            m_plan.passes.push_back({.pass = p, .barriers = {}});
        else
            m_plan.culled.push_back(p);
    }
}

void Compiler::FindLifetimes() {
    m_plan.lifetimes.resize(m_graph.resources.size());
    for (uint32_t position = 0; position < m_plan.passes.size(); ++position) {
        const GraphPass& pass = m_graph.passes[m_plan.passes[position].pass];
        for (auto use = UsesBegin(pass); use != UsesEnd(pass); ++use) {
            Lifetime& lifetime = m_plan.lifetimes[use->resource];
            lifetime.first = std::min(lifetime.first, position);
            lifetime.last = position;
        }
    }
    // The roots of the frame are used until after its last pass.
    for (const Root& root : m_graph.roots) {
        Lifetime& lifetime = m_plan.lifetimes[root.resource];
        if (lifetime.IsUsed()) lifetime.last = static_cast<uint32_t>(m_plan.passes.size());
    }
}

void Compiler::PlanBarriers() {
    m_plan.states.reserve(m_graph.resources.size());
    for (const GraphResource& resource : m_graph.resources) {
        ResourceState& state = m_plan.states.emplace_back(
            resource.origin == Origin::Transient ? ResourceState{} : resource.state);
        if (resource.origin != Origin::Imported || m_graph.waitStages == VK_PIPELINE_STAGE_2_NONE) continue;
        // The frame's semaphores guard the resources that the host hands in. No transition may overtake the
        // wait. Where only some stages wait, accesses in other stages, reads too, come after those: the host
        // may have written what an earlier frame has read.
        const bool allWait = (m_graph.waitStages & VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT) != 0;
        if (resource.kind != ResourceKind::Texture && allWait) continue;
        const bool isRead = state.readStages != VK_PIPELINE_STAGE_2_NONE;
        if (isRead) state.readStages |= m_graph.waitStages;
        if (!isRead || !allWait) state.writeStages |= m_graph.waitStages;
        if (allWait) continue;
        state.visibleStages = VK_PIPELINE_STAGE_2_NONE;
        state.visibleAccess = VK_ACCESS_2_NONE;
    }
    // A block that this frame does not use keeps its state for a later one.
    m_plan.blockStates = m_graph.blockStates;
    m_plan.blockStates.resize(std::max(m_graph.blockStates.size(), m_plan.blocks.size()));
    m_lastOccupant.assign(m_plan.blocks.size(), kNone);
    m_occupantAccess.assign(m_plan.blocks.size(), {});

    Acquire();
    for (uint32_t position = 0; position < m_plan.passes.size(); ++position) PlanPass(position);
    Finish();
}

void Compiler::Acquire() {
    m_plan.acquire.first = BarrierCount();
    for (uint32_t r = 0; r < m_graph.resources.size(); ++r) {
        ResourceState& state = m_plan.states[r];
        if (state.queueFamily == VK_QUEUE_FAMILY_IGNORED) continue;
        const auto isRootOf = [&](const Root& root) { return root.resource == r; };
        if (!m_plan.lifetimes[r].IsUsed() &&
            std::none_of(m_graph.roots.begin(), m_graph.roots.end(), isRootOf))
            continue;
        if (state.queueFamily != m_graph.queueFamily) {
            const GraphResource& resource = m_graph.resources[r];
            if (resource.kind != ResourceKind::Texture && resource.kind != ResourceKind::Buffer)
                throw MakeError(
                    ErrorKind::Usage,
                    "{}, a {}, comes from queue family {}: what crosses is the buffer that holds it",
                    Quoted(resource.name), Name(resource.kind), state.queueFamily);
            m_plan.barriers.push_back({.resource = r,
                                       .dependency = {.srcStages = kOwnerStages,
                                                      .dstStages = kOwnerStages,
                                                      .dstAccess = kOwnerAccess,
                                                      .oldLayout = state.layout,
                                                      .newLayout = state.layout,
                                                      .isNeeded = true},
                                       .srcQueueFamily = state.queueFamily,
                                       .dstQueueFamily = m_graph.queueFamily});
            state = {.writeStages = kOwnerStages, .layout = state.layout};
        }
        state.queueFamily = m_graph.queueFamily;
    }
    m_plan.acquire.count = BarrierCount() - m_plan.acquire.first;
}

// The state in which the last occupant, and with it all earlier ones, leave their memory.
ResourceState Compiler::LeaveBlock(uint32_t block) {
    ResourceState state = m_plan.states[m_lastOccupant[block]];
    AccessMasks& all = m_occupantAccess[block];
    const bool isAlone = all.stages == VK_PIPELINE_STAGE_2_NONE;
    all.stages |= state.readStages | state.writeStages;
    all.access |= state.writeAccess;
    if (isAlone) return state;
    state.writeStages = all.stages;
    state.writeAccess = all.access;
    state.readStages = VK_PIPELINE_STAGE_2_NONE;
    return state;
}

// A transient starts with the state of its memory, without the layout.
void Compiler::EnterBlock(uint32_t resource, PlannedBarrier& barrier) {
    const uint32_t block = m_plan.lifetimes[resource].block;
    if (block == kNone) return;
    ResourceState& state = m_plan.states[resource];
    barrier.predecessor = m_lastOccupant[block];
    if (barrier.predecessor == kNone) {
        state = m_plan.blockStates[block];
        barrier.followsLastFrame = state != ResourceState{};
    } else {
        state = LeaveBlock(block);
    }
    // Visibility of the old contents does not apply to the new resource.
    state.visibleStages = VK_PIPELINE_STAGE_2_NONE;
    state.visibleAccess = VK_ACCESS_2_NONE;
    state.layout = VK_IMAGE_LAYOUT_UNDEFINED;
    m_lastOccupant[block] = resource;
}

void Compiler::PlanPass(uint32_t position) {
    PlannedPass& planned = m_plan.passes[position];
    const GraphPass& pass = m_graph.passes[planned.pass];
    planned.barriers.first = BarrierCount();
    for (auto use = UsesBegin(pass); use != UsesEnd(pass); ++use) {
        const uint32_t r = use->resource;
        const auto isSame = [&](const ResourceUse& other) { return other.resource == r; };
        if (std::any_of(UsesBegin(pass), use, isSame)) continue;  // planned with its first use
        const GraphResource& resource = m_graph.resources[r];
        if (resource.kind == ResourceKind::TextureSet) continue;  // ordered by its owner

        AccessRequest request{.writes = false, .needsContents = false};
        for (auto same = use; same != UsesEnd(pass); ++same) {
            if (same->resource != r) continue;
            const AccessMasks masks = MasksFor(pass.kind, same->access);
            request.masks.stages |= masks.stages;
            request.masks.access |= masks.access;
            request.masks.layout = masks.layout;
            request.writes = request.writes || Writes(same->access);
            request.needsContents =
                request.needsContents || KeepsEarlierContents(resource.kind, same->access);
        }
        if (resource.kind != ResourceKind::Texture) request.masks.layout = VK_IMAGE_LAYOUT_UNDEFINED;

        PlannedBarrier barrier{.resource = r, .dependency = {}};
        if (m_plan.lifetimes[r].first == position) EnterBlock(r, barrier);
        barrier.dependency = PlanAccess(m_plan.states[r], request);
        if (barrier.dependency.isNeeded) m_plan.barriers.push_back(barrier);
    }
    planned.barriers.count = BarrierCount() - planned.barriers.first;
}

void Compiler::Finish() {
    m_plan.finish.first = BarrierCount();
    for (const Root& root : m_graph.roots) {
        ResourceState& state = m_plan.states[root.resource];
        const auto isExportOfIt = [&](const Root& other) {
            return other.kind == RootKind::Exported && other.resource == root.resource;
        };
        // A texture that is presented and exported ends in the layout that its owner asked for.
        if (root.kind == RootKind::Presented &&
            std::any_of(m_graph.roots.begin(), m_graph.roots.end(), isExportOfIt))
            continue;
        // A transient that no pass wrote has no contents; contents from the host or an earlier frame are
        // shown as they are.
        const bool isTransient = m_graph.resources[root.resource].origin == Origin::Transient;
        if (isTransient && !m_plan.lifetimes[root.resource].IsUsed()) continue;
        AccessRequest request{.masks = root.kind == RootKind::Presented ? kPresentMasks : kHostReadMasks};
        if (root.kind == RootKind::Exported) {
            request.masks = {kOwnerStages, kOwnerAccess, root.layout};
            request.writes = true;  // its owner may write it, so the next frame waits for all
        }
        const Dependency dependency = PlanAccess(state, request);
        if (dependency.isNeeded)
            m_plan.barriers.push_back({.resource = root.resource, .dependency = dependency});
    }
    m_plan.finish.count = BarrierCount() - m_plan.finish.first;

    m_plan.release.first = BarrierCount();
    for (const Root& root : m_graph.roots) {
        if (root.queueFamily == VK_QUEUE_FAMILY_IGNORED || root.queueFamily == m_graph.queueFamily) continue;
        m_plan.barriers.push_back({.resource = root.resource,
                                   .dependency = {.srcStages = kOwnerStages,
                                                  .srcAccess = kOwnerAccess,
                                                  .oldLayout = root.layout,
                                                  .newLayout = root.layout,
                                                  .isNeeded = true},
                                   .srcQueueFamily = m_graph.queueFamily,
                                   .dstQueueFamily = root.queueFamily});
        m_plan.states[root.resource] = {.layout = root.layout, .queueFamily = root.queueFamily};
    }
    m_plan.release.count = BarrierCount() - m_plan.release.first;

    for (uint32_t b = 0; b < m_plan.blocks.size(); ++b)
        if (m_lastOccupant[b] != kNone) m_plan.blockStates[b] = LeaveBlock(b);
}

}  // namespace

Plan Compile(const FrameGraph& graph) {
    return Compiler(graph).Run();
}

}  // namespace raygraph
